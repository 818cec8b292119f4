//! Two cars and two pedestrians in one world: which pairs touch, what each driver knows, and what is recorded.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use base::seed::Seed;
use base::signature::Distribution;
use compile::{Catalog, Plan, compile};
use learn::Env;
use world::av::{DrivingMode, PerfectSensors};
use world::env::{
    ActionSpec, Controller, Draw, EgoSpeed, EgoStart, Ending, ObservationSpec, Observer, Outcome, PedestrianRole,
    Scenario, Trace, VehicleRole, carry_out,
};
use world::falsifier::{
    BudgetedSimulation, Failure, Intercept, PedestrianEnv, Random, WalkPolicy, evaluate, follow, play,
};
use world::geometry::{Obstacles, Pose};
use world::judge::{NearMiss, judge};
use world::sim::{ActorId, ActorStart, LightColour, LightCycle, Start, WalkCommand, World};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
town long {
  lane_width: 3.5 m
  traffic_lights: false
  street long { through: [(0 m, 0 m), (250 m, 0 m), (500 m, 0 m)]  speed_limit: 50 km/h }
}
town lit {
  traffic_lights: true
  street main { through: [(-150 m, 0 m), (0 m, 0 m), (150 m, 0 m)]  speed_limit: 50 km/h }
  street side { through: [(0 m, 0 m), (0 m, 150 m)]  speed_limit: 30 km/h }
}
policy follower = idm()
policy slow = idm(limit_share: 0.4)
campaign cast {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [long] policies: [blind] rewards: [r2] runs: 1 }
  evaluate { towns: [long, lit] policies: [blind, follower, slow] pedestrians: [intercept] }
}
"#;

const STANDING: WalkCommand = WalkCommand { heading: 0.0, speed: 0.0 };
/// The middle of the lane to the east.
const LANE: f64 = -1.75;

fn scenario(town: &str, policy: &str) -> Scenario {
    static PLAN: LazyLock<Plan> = LazyLock::new(|| {
        let root = crate::repository().join("scenarios/cast.scn");
        let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
        let compiled =
            compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
        compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
    });
    let of = |each: &&compile::Evaluation| *each.town == *town && *each.policy == *policy;
    Scenario::clone(&PLAN.campaigns[0].all::<compile::Evaluation>().find(of).unwrap().scenario)
}

fn vehicle(policy: &str) -> VehicleRole {
    scenario("long", policy).cast.ego().clone()
}

/// The ego starts at x = 60 m in its lane at 8 m/s. The first pedestrian is 30 m to its right and faces east. The arguments place the
/// second car and the second pedestrian.
pub fn two_and_two(ego: &str, traffic: (&str, ActorStart), second: (ActorStart, Controller)) -> Scenario {
    let mut scenario = scenario("long", ego);
    scenario.obstacles = Arc::new(Obstacles::new(&[]));
    scenario.spawn.ego_start = EgoStart::Poses(vec![Pose::new(60.0, LANE, 0.0)]);
    scenario.spawn.ego_speed = EgoSpeed::Drawn(Distribution::Constant(8.0));
    scenario.spawn.bearing = Distribution::Constant(-std::f64::consts::FRAC_PI_2);
    scenario.spawn.distance = Distribution::Constant(30.0);
    scenario.spawn.heading = Some(Distribution::Constant(0.0));
    scenario.spawn.constraints.clear();
    scenario.cast.vehicles.push(VehicleRole { start: Some(traffic.1), ..vehicle(traffic.0) });
    let (controller, start) = (second.1, Some(second.0));
    let role = PedestrianRole { controller, start, ..scenario.cast.pedestrian().clone() };
    scenario.cast.pedestrians.push(role);
    scenario
}

/// A car at this distance (m) ahead of the ego, at 8 m/s.
pub fn ahead(distance: f64) -> ActorStart {
    ActorStart { pose: Pose::new(60.0 + distance, LANE, 0.0), speed: 8.0 }
}

/// A place far to the side of the street.
pub fn away() -> ActorStart {
    ActorStart::standing(Pose::new(100.0, 60.0, 0.0))
}

/// Runs episode 0 with the same decision each time.
fn run(scenario: &Arc<Scenario>, commands: [WalkCommand; 2]) -> (Outcome, Trace) {
    let mut env = scenario.simulation();
    let mut trace = Trace::new(scenario);
    env.start(Draw::new(&Seed::root(1), 0));
    trace.begin(&env.scene());
    while env.outcome().is_none() {
        carry_out(&mut *env, &commands, &mut trace);
    }
    (*env.outcome().unwrap(), trace)
}

#[test]
fn a_car_follows_another_and_each_pedestrian_does_what_it_is_told() {
    let scenario = Arc::new(two_and_two("follower", ("slow", ahead(40.0)), (away(), Controller::External)));
    let commands =
        [WalkCommand { heading: 0.0, speed: 1.0 }, WalkCommand { heading: std::f64::consts::PI, speed: 2.0 }];
    let (outcome, trace) = run(&scenario, commands);
    assert_eq!((outcome.ending, trace.contact()), (Ending::Timeout, None));
    let (ego, other) = (trace.vehicle(0), trace.vehicle(1));
    assert_eq!((ego.len(), other.len()), (601, 601));
    let (first, last) = (ego[0], ego[600]);
    assert_eq!((first.state.speed, other[0].state.pose.x), (8.0, 100.0));
    // Alone the ego drives 0.9 of the limit.
    assert!((last.state.speed - other[600].state.speed).abs() < 0.3 && last.state.speed < 4.0, "{last:?}");
    assert!(ego.iter().any(|frame| frame.driven.mode == DrivingMode::Yield));
    let gap = other[600].state.pose.x - last.state.pose.x;
    assert!(gap > 5.0 && gap < 20.0, "{gap} m behind");
    for (number, east) in [30.0, -60.0].into_iter().enumerate() {
        let track = trace.pedestrian(number);
        assert_eq!((track.len(), trace.decisions(number).len()), (601, 30));
        assert!((track[600].pose.x - track[0].pose.x - east).abs() < 1e-6, "pedestrian {number}");
        assert_eq!(trace.decisions(number), [commands[number]; 30]);
    }
}

#[test]
fn an_episode_of_four_is_the_same_again_and_goes_on_from_where_it_was_saved() {
    let scenario = Arc::new(two_and_two("follower", ("slow", ahead(40.0)), (away(), Controller::External)));
    let commands = [WalkCommand { heading: 0.3, speed: 1.0 }, WalkCommand { heading: 3.0, speed: 2.0 }];
    let (outcome, _) = run(&scenario, commands);
    assert_eq!(run(&scenario, commands).0, outcome);
    assert_ne!(
        run(&scenario, [commands[0], STANDING]).0.digest,
        outcome.digest,
        "the second pedestrian is in the digest"
    );
    let nearer = Arc::new(two_and_two("follower", ("slow", ahead(39.0)), (away(), Controller::External)));
    assert_ne!(run(&nearer, commands).0.digest, outcome.digest, "the traffic is in the digest");
    let make = || PedestrianEnv::new(scenario.simulation(), Seed::root(1));
    let mut env = make();
    env.begin(0);
    for _ in 0..7 {
        env.carry_out(&commands);
    }
    let saved = env.save().unwrap();
    let mut again = make();
    assert!(again.load(&saved) && again.save().unwrap() == saved);
    for env in [&mut env, &mut again] {
        while env.simulation().outcome().is_none() {
            env.carry_out(&commands);
        }
        assert_eq!(env.simulation().outcome(), Some(&outcome));
    }
}

#[test]
fn drivers_know_the_others_and_their_own_signs_and_lights() {
    let blueprint = || vehicle("blind").blueprint;
    let body = scenario("long", "blind").cast.pedestrian().body;
    let town = scenario("lit", "blind").town;
    let (fast, slow) = {
        let sign = |limit: f64| town.speed_signs.iter().find(|sign| (sign.limit - limit / 3.6).abs() < 1e-9).unwrap();
        (sign(50.0), sign(30.0))
    };
    let empty = Arc::new(Obstacles::new(&[]));
    let lights = Some(LightCycle::default());
    let mut world =
        World::new(Arc::clone(&town), empty, vec![blueprint(), blueprint(), blueprint()], vec![body; 2], lights, 0.05);
    let pedestrians = &[ActorStart::default(); 2];
    let at = ActorStart::standing;
    let second_light = town.traffic_lights.len() - 1;
    let stops = [town.traffic_lights[0].stop, town.traffic_lights[second_light].stop];
    let vehicles = &[at(fast.trigger.pose), at(slow.trigger.pose), at(stops[1])];
    world.begin(&Start { vehicles, pedestrians, light_phase: 0.0 });
    let mut sensors = PerfectSensors::default();
    for (number, (limit, light)) in [(50.0, None), (30.0, None), (30.0, Some(second_light))].into_iter().enumerate() {
        let perception = sensors.perceive(&world, number);
        assert!((perception.speed_limit - limit / 3.6).abs() < 1e-9, "vehicle {number}: {}", perception.speed_limit);
        assert_eq!(perception.affecting_light, light, "vehicle {number}");
        assert_eq!(perception.lights.len(), town.traffic_lights.len());
        assert_eq!(perception.ego.id, ActorId::Vehicle(number as u8));
        assert_eq!(perception.ego.pose, vehicles[number].pose);
        let others: Vec<ActorId> = perception.vehicles.iter().map(|actor| actor.id).collect();
        let wanted: Vec<ActorId> = (0..3).filter(|other| *other != number as u8).map(ActorId::Vehicle).collect();
        assert_eq!(others, wanted);
        let people: Vec<ActorId> = perception.pedestrians.iter().map(|actor| actor.id).collect();
        assert_eq!(people, [ActorId::Pedestrian(0), ActorId::Pedestrian(1)]);
    }
    // Lights that are switched off affect no vehicle.
    let vehicles = &[at(stops[0]), at(stops[1]), at(stops[0])];
    world.begin(&Start { vehicles, pedestrians, light_phase: 0.0 });
    assert_eq!([0, 1, 2].map(|vehicle| world.affecting_light(vehicle)), [Some(0), Some(second_light), Some(0)]);
    let colours: Vec<LightColour> = sensors.perceive(&world, 1).lights.iter().map(|light| light.colour).collect();
    assert!(colours.contains(&LightColour::Green) && colours.contains(&LightColour::Red));
    world.lights = None;
    assert_eq!([0, 1, 2].map(|vehicle| world.affecting_light(vehicle)), [None; 3]);
}

#[test]
fn cars_touch_cars_and_the_touch_names_them() {
    // The ego does not look; the other car stands.
    let standing = ActorStart { speed: 0.0, ..ahead(30.0) };
    let mut scenario = two_and_two("blind", ("blind", standing), (away(), Controller::External));
    scenario.cast.vehicles[1].blueprint.start_up_pause = 1e6;
    let scenario = Arc::new(scenario);
    let (outcome, trace) = run(&scenario, [STANDING; 2]);
    let contact = *trace.contact().unwrap();
    assert_eq!(contact.pair, (ActorId::EGO, ActorId::Vehicle(1)));
    let length = 2.0 * scenario.cast.ego().blueprint.half_length;
    assert!((contact.ahead - length).abs() < 1e-3 && contact.aside.abs() < 0.1, "{contact:?}");
    assert!(contact.impact_speed > 7.0 && contact.is_front(0.1));
    assert_eq!(outcome.ending, Ending::OtherContact);
    assert!(!outcome.is_collision() && outcome.least_gap > 20.0);
    assert_eq!(contact.pedestrian_at_ego(), None);
    let pair = trace.main_pair(&scenario);
    assert!(pair.contact.is_none() && judge(&pair).is_none());
    // At the touch the boxes have no gap; one tick earlier they have one.
    let (ego, other) = (trace.vehicle(0), trace.vehicle(1));
    let last = ego.len() - 1;
    let outline = |frame: &world::env::VehicleFrame| frame.state.outline(&scenario.cast.ego().blueprint);
    assert!(outline(&ego[last]).overlaps(&outline(&other[last])));
    assert!(!outline(&ego[last - 1]).overlaps(&outline(&other[last - 1])));
}

#[test]
fn the_struck_pedestrian_is_the_one_that_is_judged() {
    // The second pedestrian stands in the lane, the first one beside the street.
    let in_lane = ActorStart::standing(Pose::new(85.0, LANE, 0.0));
    let behind = ActorStart { pose: Pose::new(20.0, LANE, 0.0), speed: 0.0 };
    let scenario = Arc::new(two_and_two("blind", ("slow", behind), (in_lane, Controller::Fixed(STANDING))));
    // A choice for a pedestrian with its own controller has no effect.
    let running = WalkCommand { heading: 1.0, speed: 3.0 };
    let (outcome, trace) = run(&scenario, [STANDING, running]);
    let contact = *trace.contact().unwrap();
    assert_eq!(contact.pair, (ActorId::EGO, ActorId::Pedestrian(1)));
    assert!(matches!(outcome.ending, Ending::Touch { front: true, moving: true, .. }), "{outcome:?}");
    assert!(outcome.reward > 3.0 && outcome.least_gap == 0.0);
    let pair = trace.main_pair(&scenario);
    assert_eq!(pair.frame(0).pedestrian.pose, in_lane.pose);
    assert_eq!(pair.last(), pair.frames().last());
    assert!(pair.gap(&pair.last().unwrap()) < 0.5 && pair.in_sight(&pair.frame(0)));
    assert!(judge(&pair).is_some() && NearMiss::new(&pair).min_ttc == Some(0.0));
    let first = trace.pair(&scenario, 0, 0);
    assert!(first.contact.is_none() && judge(&first).is_none() && NearMiss::new(&first).min_ttc != Some(0.0));
    assert_eq!((first.len(), first.decisions), (pair.len(), &vec![STANDING; first.decisions.len()][..]));
    // The second car drives behind and forms a pair of its own.
    let other = trace.pair(&scenario, 1, 1);
    assert!(other.contact.is_none() && other.frame(0).ego.pose == behind.pose);
}

#[test]
fn traffic_that_touches_a_pedestrian_ends_the_episode_too() {
    let in_lane = ActorStart::standing(Pose::new(120.0, LANE, 0.0));
    let scenario = Arc::new(two_and_two("follower", ("blind", ahead(40.0)), (in_lane, Controller::Fixed(STANDING))));
    let (outcome, trace) = run(&scenario, [STANDING; 2]);
    assert_eq!(trace.contact().unwrap().pair, (ActorId::Vehicle(1), ActorId::Pedestrian(1)));
    assert_eq!(outcome.ending, Ending::OtherContact);
    assert!(trace.pair(&scenario, 1, 1).contact.is_some() && trace.main_pair(&scenario).contact.is_none());
}

#[test]
fn pedestrians_pass_through_each_other() {
    let opposite = ActorStart { pose: Pose::new(70.0, LANE - 30.0, 0.0), speed: 1.5 };
    let west = WalkCommand { heading: std::f64::consts::PI, speed: 1.5 };
    let scenario = Arc::new(two_and_two("follower", ("slow", ahead(40.0)), (opposite, Controller::Fixed(west))));
    let (outcome, trace) = run(&scenario, [WalkCommand { heading: 0.0, speed: 1.5 }, STANDING]);
    let apart = trace.pedestrian(0).iter().zip(trace.pedestrian(1)).map(|(a, b)| a.pose.x - b.pose.x);
    let apart: Vec<f64> = apart.collect();
    assert!(apart[0] < 0.0 && apart[apart.len() - 1] > 0.0, "they have passed each other");
    assert_eq!(outcome.ending, Ending::Timeout);
    assert!((trace.pedestrian(1)[0].velocity.x - 1.5).abs() < 1e-12, "it starts walking");
    assert!((trace.pedestrian(1)[1].velocity.x + 1.5).abs() < 1e-9, "and turns at once");
    assert!(trace.decisions(1).iter().all(|command| *command == west), "it decides for itself");
}

#[test]
fn policies_and_searches_see_an_environment_by_its_dimensions() {
    let both = Arc::new(two_and_two("blind", ("slow", ahead(60.0)), (away(), Controller::External)));
    let mut env = PedestrianEnv::new(both.simulation(), Seed::root(3));
    assert_eq!((env.obs_dim(), env.action_bounds().len()), (2 * ObservationSpec::DIM, 2 * ActionSpec::DIM));
    let mut state = vec![0.0; env.obs_dim()];
    env.reset(&mut state);
    let distance = |number: usize| {
        let world = env.simulation().scene().world;
        (world.pedestrians[number].state.pose.position() - world.ego().state.pose.position()).norm()
    };
    assert!((state[1] - distance(0)).abs() < 1e-9 && (state[ObservationSpec::DIM + 1] - distance(1)).abs() < 1e-9);
    let mut commands = [STANDING; 2];
    let scene = env.simulation().scene();
    scene.write_commands(&[0.0, 1.0, 0.0, 2.0], &mut commands);
    let homing = [scene.homing(0), scene.homing(1)];
    for (command, towards) in commands.iter().zip(homing) {
        assert!((command.heading - towards.heading).abs() < 1e-12, "angles are measured from the line of sight");
    }
    assert_eq!(commands.map(|command| command.speed), [1.0, 2.0]);
    let alone = Arc::new(two_and_two("blind", ("slow", ahead(60.0)), (away(), Controller::Fixed(STANDING))));
    assert_eq!(PedestrianEnv::new(alone.simulation(), Seed::root(3)).obs_dim(), ObservationSpec::DIM);

    let go_on = &mut |_| ControlFlow::Continue(());
    let policies: [&mut dyn WalkPolicy; 2] = [&mut Random::default(), &mut Intercept];
    let found = policies.map(|policy| evaluate(policy, &both, 3, &Seed::root(4), &Seed::root(5), go_on));
    assert!(found.iter().all(|outcomes| outcomes.len() == 3) && found[0] != found[1]);

    let mut simulator = BudgetedSimulation::new(Arc::clone(&both), Seed::root(6), 5_000, &|| false);
    while simulator.begin(0) && play(&mut simulator, &mut Intercept, &mut ()).is_some() {}
    let spent = simulator.into_spent();
    for failure in &spent.failures {
        let Failure { start, commands, outcome, .. } = failure;
        assert!(commands.len().is_multiple_of(2));
        let again = follow(&both, Seed::root(6), *start, commands);
        assert_eq!(again.map(|(again, _)| again), Some(*outcome));
    }
    assert!(spent.episodes > 0, "{spent:?}");
}
