//! InterFuser's planner on the built-in roads, in closed loop.

use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::Scenario;
use ported::interfuser::InterFuser;
use road::LaneFilter;
use road::geometry::{Pose, Vector};
use world::av::{DrivingMode, DrivingPolicy, PerfectSensors};
use world::sim::{ActorStart, PedestrianBody, Start, WalkCommand, World};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
campaign drives {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] drivers: [interfuser] rewards: [r2] runs: 1 }
  evaluate { towns: [harbour, village] drivers: [interfuser] pedestrians: [random] }
}
"#;

fn scenarios() -> Vec<Arc<Scenario>> {
    let root = crate::repository().join("scenarios/drives.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let plan = compiled.plan.expect("the scenario is sound");
    plan.campaigns[0].all::<compile::Evaluation>().map(|evaluation| Arc::clone(&evaluation.scenario)).collect()
}

/// A world with the ego at the start of a lane. The pedestrian is at these distances ahead of it and to its right (m).
fn world(scenario: &Scenario, lane: usize, pedestrian: Vector) -> World {
    let mut world = World::new(
        Arc::clone(&scenario.town),
        Arc::clone(&scenario.obstacles),
        vec![scenario.cast.ego().blueprint.clone()],
        vec![PedestrianBody::adult()],
        None,
        0.05,
    );
    let town = &scenario.town;
    let ego = town.pose(town.along(&town.driving_lanes()[lane], 5.0));
    let place = ego.to_world(Vector::new(pedestrian.x, -pedestrian.y));
    let facing = Pose::new(place.x, place.y, ego.yaw + std::f64::consts::FRAC_PI_2);
    let (vehicles, pedestrians) = (&[ActorStart::standing(ego)], &[ActorStart::standing(facing)]);
    world.begin(&Start { vehicles, pedestrians, light_phase: 0.0 });
    world
}

/// Drives for some ticks; the pedestrian stands.
fn drive(world: &mut World, ticks: u32, mut each: impl FnMut(&World, DrivingMode)) -> Option<f64> {
    let mut sensors = PerfectSensors::default();
    let mut driver = InterFuser::new();
    driver.reset(&sensors.perceive(world, 0), Seed::root(3).stream());
    let standing = WalkCommand { heading: world.pedestrians[0].state.pose.yaw, speed: 0.0 };
    for _ in 0..ticks {
        let control = driver.drive(&sensors.perceive(world, 0));
        if let Some(contact) = world.tick(&[control], &[standing]) {
            return Some(contact.impact_speed);
        }
        each(world, driver.mode());
    }
    None
}

/// A place far from every road.
const NOWHERE: Vector = Vector::new(-900.0, 0.0);

#[test]
fn it_keeps_its_lane_through_every_bend_and_stays_below_its_speed() {
    for scenario in scenarios() {
        for lane in (0..scenario.town.driving_lanes().len()).step_by(5) {
            let mut world = world(&scenario, lane, NOWHERE);
            let start = world.ego().state.pose.position();
            let (mut aside, mut fastest, mut driven, mut last) = (0.0_f64, 0.0_f64, 0.0, start);
            let hit = drive(&mut world, 1200, |world, mode| {
                let here = world.ego().state.pose.position();
                let nearest = world.town.nearest_lane(here, LaneFilter::Driving).expect("a town has lanes");
                // In a junction, the nearest of several lanes. Outside a junction it must be a lane of this direction.
                aside = aside.max((world.town.pose(nearest).position() - here).norm());
                fastest = fastest.max(world.ego().state.speed);
                driven += (here - last).norm();
                last = here;
                assert!(matches!(mode, DrivingMode::Cruise), "{mode:?} with nobody near");
            });
            assert_eq!(hit, None);
            assert!(aside < 0.8, "{} lane {lane}: {aside} m beside its lane", scenario.town.name);
            assert!(fastest < 5.2 && driven > 150.0, "lane {lane}: {fastest} m/s, {driven} m");
        }
    }
}

#[test]
fn it_stops_for_a_person_who_stands_in_its_corridor_and_passes_one_beside_it() {
    for scenario in scenarios() {
        let mut blocked = world(&scenario, 0, Vector::new(25.0, 0.3));
        let mut last = DrivingMode::Cruise;
        let hit = drive(&mut blocked, 400, |_, mode| last = mode);
        assert_eq!((hit, last), (None, DrivingMode::EmergencyStop));
        assert!(blocked.ego().state.speed < 0.01 && blocked.gap(0, 0) < 8.0, "{} m", blocked.gap(0, 0));
        // It stops beside them, creeps on in short pushes, and is past after 26 to 28 s.
        let mut free = world(&scenario, 0, Vector::new(25.0, 3.0));
        let mut passed = false;
        let hit = drive(&mut free, 600, |world, _| {
            let behind = world.ego().state.pose.to_local(world.pedestrians[0].state.pose.position()).x < 0.0;
            passed |= behind && world.gap(0, 0) > 20.0;
        });
        let (town, ego) = (&scenario.town.name, &free.ego().state);
        assert!(hit.is_none() && passed, "{town}: {hit:?}, {ego:?}, {} m apart", free.gap(0, 0));
    }
}

#[test]
fn the_same_drive_has_the_same_bits() {
    let scenario = &scenarios()[0];
    let trace = || {
        let mut bits = Vec::new();
        let hit = drive(&mut world(scenario, 3, Vector::new(40.0, 1.0)), 600, |world, _| {
            bits.extend(
                [
                    world.ego().state.pose.x,
                    world.ego().state.pose.y,
                    world.ego().state.pose.yaw,
                    world.ego().state.speed,
                ]
                .map(f64::to_bits),
            );
        });
        (hit.map(f64::to_bits), bits)
    };
    assert_eq!(trace(), trace());
}
