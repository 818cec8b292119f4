//! The built-in drivers on an open street: they stop for a pedestrian in their way and for no other.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use base::seed::Seed;
use compile::{Catalog, Plan, compile};
use episode::{Draw, Scenario};
use lang::Reader;
use road::geometry::{Obstacles, Pose};
use world::av::{DrivingMode, PerfectSensors};
use world::sim::{ActorStart, Contact, Start, WalkCommand, World};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
driver jrc = rss_guarded(figures: jrc)
campaign driven {
  vehicle: plain_car  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] drivers: [blind] rewards: [r2] runs: 1 }
  evaluate { towns: [harbour] drivers: [blind, aeb, rss, jrc, predictive, oracle, late_oracle] pedestrians: [intercept] }
}
"#;

const GUARDED: [&str; 6] = ["aeb", "rss", "jrc", "predictive", "oracle", "late_oracle"];

fn scenario(policy: &str) -> Arc<Scenario> {
    static PLAN: LazyLock<Plan> = LazyLock::new(|| {
        let root = crate::repository().join("scenarios/driven.scn");
        let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
        let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default());
        compiled.unwrap().plan.unwrap()
    });
    PLAN.campaigns[0].all::<compile::Evaluation>().find(|each| *each.policy == *policy).unwrap().scenario.clone()
}

/// The time of a decision comes from the trial, which is made outside.
#[test]
fn a_network_that_is_slow_is_named_with_its_time() {
    struct Files;
    impl Reader for Files {
        fn text(&self, _: &Path) -> std::io::Result<String> {
            Ok("edition 1\ndriver p = onnx(model: \"follow.onnx\")\n".into())
        }

        fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
            std::fs::read(crate::repository().join("tests/reference/onnx").join(path.file_name().unwrap()))
        }
    }
    let said = |seconds: Option<f64>| {
        let catalog = Catalog::builtin().with_network_trial(Arc::new(move |_| Ok(seconds)));
        let compiled = compile(&["slow.scn".into()], &catalog, &Files, &mut Default::default()).unwrap();
        compiled.diagnostics.iter().map(|each| each.message.clone()).collect::<Vec<_>>()
    };
    assert!(said(None).is_empty(), "{:?}", said(None));
    assert_eq!(said(Some(0.7)), ["the model `follow.onnx` takes 0.7 s for a decision"]);
}

/// The result of a drive from (x, −1.75 m) to the east.
struct Drive {
    contact: Option<Contact>,
    world: World,
    slowest: f64,
    emergencies: u32,
}

fn drive(policy: &str, x: f64, walker: Pose, walking: f64, seconds: f64) -> Drive {
    let scenario = scenario(policy);
    let body = scenario.cast.pedestrian().body.nimble();
    let empty = Arc::new(Obstacles::new(&[]));
    let (car, town) = (scenario.cast.ego().blueprint.clone(), scenario.town.clone());
    let mut world = World::new(town, empty, vec![car], vec![body], None, 0.05);
    let vehicles = &[ActorStart { pose: Pose::new(x, -1.75, 0.0), speed: 7.5 }];
    world.begin(&Start { vehicles, pedestrians: &[ActorStart::standing(walker)], light_phase: 0.0 });
    let mut driver = (scenario.cast.ego().policy)();
    let mut sensors = PerfectSensors::default();
    driver.reset(&sensors.perceive(&world, 0), Seed::root(1).stream());
    let (mut slowest, mut emergencies, mut contact) = (f64::INFINITY, 0, None);
    while contact.is_none() && world.elapsed() < seconds {
        let control = driver.drive(&sensors.perceive(&world, 0));
        emergencies += u32::from(driver.mode() == DrivingMode::EmergencyStop);
        contact = world.tick(&[control], &[WalkCommand { heading: walker.yaw, speed: walking }]);
        slowest = slowest.min(world.ego().state.speed);
    }
    Drive { contact, world, slowest, emergencies }
}

#[test]
fn they_stop_for_a_person_who_stands_in_the_lane() {
    let standing = Pose::new(60.0, -1.75, 1.57);
    assert!(drive("blind", 20.0, standing, 0.0, 15.0).contact.is_some());
    for policy in GUARDED {
        let end = drive(policy, 20.0, standing, 0.0, 15.0);
        assert!(end.contact.is_none(), "{policy} hits at {:?}", end.contact);
        assert!(end.slowest < 0.5 && end.world.ego().state.pose.x < 60.0, "{policy} does not stop: {}", end.slowest);
    }
    let gap = |policy| drive(policy, 20.0, standing, 0.0, 15.0).world.gap(0, 0);
    let (late, sure) = (gap("late_oracle"), gap("oracle"));
    assert!(late < 0.7, "as late as it can: {late}");
    assert!(sure < 1.5, "it creeps up as far as is safe: {sure}");
}

#[test]
fn they_brake_for_a_person_who_crosses() {
    // From the near pavement at 1.4 m/s, into the middle of the car if the car keeps going.
    let (walker, start) = (Pose::new(60.0, -6.0, std::f64::consts::FRAC_PI_2), 60.0 - 7.5 * 4.25 / 1.4);
    assert!(drive("blind", start, walker, 1.4, 8.0).contact.is_some());
    for policy in GUARDED {
        let end = drive(policy, start, walker, 1.4, 8.0);
        assert!(end.contact.is_none(), "{policy} hits: {:?}", end.contact);
    }
}

#[test]
fn they_drive_past_a_person_on_the_far_pavement() {
    for policy in GUARDED {
        let alone = drive(policy, 20.0, Pose::new(1000.0, 1000.0, 0.0), 0.0, 60.0);
        let passing = drive(policy, 20.0, Pose::new(50.0, 5.3, 0.0), 0.0, 60.0);
        assert_eq!(passing.emergencies, 0, "{policy}");
        assert_eq!(passing.world.ego().state, alone.world.ego().state, "{policy} is not moved by somebody over there");
        assert!(alone.slowest > 1.0, "{policy}: {}", alone.slowest);
    }
}

/// The oracle never hits a pedestrian while it moves, whatever the pedestrian does: it stops in time.
#[test]
fn the_oracle_hits_no_person_while_it_moves() {
    let scenario = scenario("oracle");
    let mut env = scenario.simulation();
    let (mut hits, mut moving) = (0, 0);
    for episode in 0..60 {
        env.start(Draw::new(&Seed::root(2), episode));
        while env.outcome().is_none() {
            env.carry_out(&[env.scene().intercept(0)]);
        }
        if let episode::Ending::Touch { moving: at_speed, .. } = env.outcome().unwrap().ending {
            hits += 1;
            moving += u32::from(at_speed);
        }
    }
    assert!(hits > 30, "the pedestrian reaches the car: {hits}");
    assert_eq!(moving, 0, "of {hits}");
}
