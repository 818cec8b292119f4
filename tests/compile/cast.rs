//! Two cars and two pedestrians in one world: which pairs touch, what each driver knows, and what is recorded.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use base::seed::Seed;
use base::signature::{DeclarationId, Distribution};
use compile::{Catalog, Plan, compile};
use episode::walker::{
    ActionMode, Forces, Gaps, Intercept, Natural, NaturalKeys, Random, Recording, TrainedWalker, WalkPolicy,
};
use episode::{
    ActionSpec, Controller, Criterion, Destination, Draw, EgoSpeed, EgoStart, Ending, ObservationSpec, Observer,
    Outcome, PedestrianRole, Phase, Placement, Scaling, Scenario, Trace, VehicleRole, carry_out, evaluate, follow,
    play,
};
use learn::{Agent, Credit, Env, Policies, PpoConfig};
use road::geometry::{Obstacles, Point, Pose};
use search::{Archive, ArchiveSearch, BudgetedSimulation, Failure, Falsifier, Learning, PedestrianEnv, TrainingRun};
use verdict::cause::{Incident, Reruns, needs};
use verdict::{Class, NearMiss, Verdict, judge};
use world::av::{DrivingMode, PerfectSensors};
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
driver follower = idm()
driver slow = idm(limit_share: 0.4)
sensors eyes { eye: 0.4 m  least_visible: 0.2  latency: 0.4 s }
driver seeing = rss_guarded(sensors: eyes)
campaign cast {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [long] drivers: [blind] rewards: [r2] runs: 1 }
  evaluate { towns: [long, lit] drivers: [blind, follower, slow, seeing] pedestrians: [intercept] }
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
    scenario.cast.vehicles.push(VehicleRole { place: Placement::Fixed(traffic.1), ..vehicle(traffic.0) });
    let (controller, place) = (second.1, Placement::Fixed(second.0));
    let role = PedestrianRole { controller, place, ..scenario.cast.pedestrian().clone() };
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
    assert_eq!(outcome.touched(), Some((ActorId::EGO, ActorId::Vehicle(1))));
    assert!(!outcome.is_collision() && outcome.least_gap > 20.0);
    assert_eq!(contact.pedestrian_at_ego(), None);
    let pair = trace.main_pair(&scenario);
    assert!(pair.contact.is_none() && judge(&pair).is_none());
    // At the touch the boxes have no gap; one tick earlier they have one.
    let (ego, other) = (trace.vehicle(0), trace.vehicle(1));
    let last = ego.len() - 1;
    let outline = |frame: &episode::VehicleFrame| frame.state.outline(&scenario.cast.ego().blueprint);
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
    assert!(matches!(outcome.ending, Ending::Touch { pedestrian: 1, front: true, moving: true, .. }), "{outcome:?}");
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

/// The car does not look. One walks into its flank at x = 80 m, and another stands in its lane at `x` (m).
fn flank_and_lane(x: f64) -> Arc<Scenario> {
    let beside = ActorStart::standing(Pose::new(80.0, LANE - 3.7, 0.0));
    let north = WalkCommand { heading: std::f64::consts::FRAC_PI_2, speed: 1.0 };
    let mut scenario = two_and_two("blind", ("blind", away()), (beside, Controller::Fixed(north)));
    scenario.spawn.bearing = Distribution::Constant(0.0);
    scenario.spawn.distance = Distribution::Constant(x - 60.0);
    Arc::new(scenario)
}

#[test]
fn a_first_touch_does_not_hide_a_worse_one() {
    let judged = |scenario: &Arc<Scenario>| {
        let (outcome, trace) = run(scenario, [STANDING; 2]);
        let Ending::Touch { pedestrian, .. } = outcome.ending else { panic!("{outcome:?}") };
        let verdict = judge(&trace.main_pair(scenario)).unwrap();
        (pedestrian, verdict.class(), outcome, trace)
    };
    let far = judged(&flank_and_lane(150.0));
    assert_eq!((far.0, far.1), (1, Class::Flank));
    for x in [82.0, 83.0, 84.0, 90.0, 110.0] {
        let scenario = flank_and_lane(x);
        let (pedestrian, class, outcome, trace) = judged(&scenario);
        assert_eq!((pedestrian, class), (0, Class::Fault), "{x} m");
        assert!(outcome.ticks > far.2.ticks && trace.vehicle(0).len() == outcome.ticks as usize + 1);
        // Who was touched is no longer there.
        let last = outcome.ticks as usize;
        assert!(!trace.is_present(1, last) && trace.is_present(0, last));
        assert!(trace.is_present(1, far.2.ticks as usize - 1) && !trace.is_present(1, far.2.ticks as usize));
        // The episode is the same from wherever it goes on.
        let mut env = scenario.simulation();
        env.start(Draw::new(&Seed::root(1), 0));
        while env.outcome().is_none() {
            if env.phase() == Phase::Decision {
                env.decide(&[STANDING; 2]);
            }
            env.tick();
            let mut copy = env.snapshot().unwrap();
            while copy.outcome().is_none() {
                if copy.phase() == Phase::Decision {
                    copy.decide(&[STANDING; 2]);
                }
                copy.tick();
            }
            assert_eq!(copy.outcome(), Some(&outcome));
        }
        assert_eq!(env.ticks_beyond(), 0, "a fault cannot be worse");
    }
    let mut open = flank_and_lane(150.0).simulation();
    open.start(Draw::new(&Seed::root(1), 0));
    while open.outcome().is_none() {
        carry_out(&mut *open, &[STANDING; 2], &mut Trace::new(&flank_and_lane(150.0)));
    }
    assert_eq!(open.ticks_beyond(), flank_and_lane(150.0).most_ticks_beyond());
    // More than five seconds later it is another story, and the episode is that of the first touch.
    let (pedestrian, class, outcome, trace) = judged(&flank_and_lane(125.0));
    assert_eq!((pedestrian, class, outcome.ticks), (1, Class::Flank, far.2.ticks));
    assert_eq!(
        (trace.vehicle(0).len(), trace.pedestrian(0).len()),
        (outcome.ticks as usize + 1, trace.pedestrian(1).len())
    );
}

/// The verdict on a car that does not look: somebody stands at `x` (m) in its lane, 60 m from where it starts, and a car follows it at this distance (m).
fn followed_by(distance: f64, x: f64) -> Verdict {
    let behind = ActorStart { pose: Pose::new(60.0 - distance, LANE, 0.0), speed: 8.0 };
    let in_lane = ActorStart::standing(Pose::new(x, LANE, 0.0));
    let scenario = two_and_two("blind", ("blind", behind), (in_lane, Controller::Fixed(STANDING)));
    let (_, trace) = run(&Arc::new(scenario.clone()), [STANDING; 2]);
    judge(&trace.main_pair(&scenario)).unwrap()
}

/// A tailgater exonerates a driver whose danger needs hard braking, and not one who could have braked mildly long before.
#[test]
fn a_car_behind_counts_only_where_the_danger_needs_hard_braking() {
    for distance in [5.4, 5.8, 6.2, 6.5, 6.7] {
        for x in [78.2, 78.5] {
            let verdict = followed_by(distance, x);
            assert_eq!(verdict.class(), Class::Followed, "{distance} m behind, {x}: {verdict:?}");
        }
        for x in [100.0, 115.0] {
            let verdict = followed_by(distance, x);
            assert_eq!(verdict.class(), Class::Fault, "{distance} m behind, {x}: {verdict:?}");
            let needed = verdict.follower.unwrap().deceleration.unwrap();
            assert!(needed < 2.5, "{distance} m behind, {x}: {needed} m/s²");
        }
    }
}

/// The car under test does not look, and somebody stands in its lane. A careful human stops; the car behind must stop, too.
#[test]
fn a_human_whose_braking_is_hit_from_behind_is_told_apart() {
    let [near, far] = [6.5, 25.0].map(|distance| followed_by(distance, 78.5));
    assert_eq!((near.class(), far.class()), (Class::Followed, Class::Fault), "{near:?} {far:?}");
    assert!(near.is_preventable() && !near.is_fault());
    let [near, far] = [near, far].map(|verdict| verdict.follower.unwrap());
    assert!(near.touches() && !far.touches());
    assert_eq!((near.vehicle, far.vehicle), (1, 1));
    // Both drive at the same speed, so that it has the gap and the way of the human's brake, but for its reaction: far less than 7 m/s².
    assert!(far.deceleration.unwrap() < 3.0 && near.deceleration.is_none_or(|needed| needed > near.limit));
}

#[test]
fn traffic_that_touches_a_pedestrian_ends_the_episode_too() {
    let in_lane = ActorStart::standing(Pose::new(120.0, LANE, 0.0));
    let scenario = Arc::new(two_and_two("follower", ("blind", ahead(40.0)), (in_lane, Controller::Fixed(STANDING))));
    let (outcome, trace) = run(&scenario, [STANDING; 2]);
    assert_eq!(trace.contact().unwrap().pair, (ActorId::Vehicle(1), ActorId::Pedestrian(1)));
    assert_eq!(outcome.ending, Ending::OtherContact { pair: (ActorId::Vehicle(1), ActorId::Pedestrian(1)) });
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

/// A child that stands at the right edge of the street 30 m ahead of the ego, behind a van that is parked between them.
fn behind_a_van(is_parked: bool) -> Scenario {
    let van = ActorStart::standing(Pose::new(85.0, -4.6, 0.0));
    let mut scenario = two_and_two("follower", ("blind", van), (away(), Controller::Fixed(STANDING)));
    scenario.cast.pedestrians.truncate(1);
    scenario.cast.vehicles[1].is_parked = is_parked;
    scenario.spawn.bearing = Distribution::Constant(-0.1);
    scenario.spawn.distance = Distribution::Constant(30.0);
    scenario
}

#[test]
fn a_parked_van_hides_and_is_walked_around_and_one_that_may_drive_hides_only() {
    let steps = |scenario: &Arc<Scenario>, command: WalkCommand| {
        let mut env = scenario.simulation();
        let mut trace = Trace::new(scenario);
        env.start(Draw::new(&Seed::root(1), 0));
        trace.begin(&env.scene());
        carry_out(&mut *env, &[command], &mut trace);
        let is_seen = env.scene().world.sees(ActorId::EGO, ActorId::Pedestrian(0));
        (trace, is_seen)
    };
    let [van, car] = [true, false].map(|is_parked| Arc::new(behind_a_van(is_parked)));
    let ((with, is_seen), (without, is_seen_too)) = (steps(&van, STANDING), steps(&car, STANDING));
    assert!(!is_seen && !is_seen_too);
    let [first, other] = [with.main_pair(&van), without.main_pair(&car)];
    assert!(!first.in_sight(&first.frame(0)) && !other.in_sight(&other.frame(0)));
    // It walks west, at the front of the van, and is pushed aside instead of touching it.
    let west = WalkCommand { heading: std::f64::consts::PI, speed: 3.0 };
    let (trace, _) = steps(&van, west);
    let outline = trace.vehicle(1)[0].state.outline(&van.cast.vehicles[1].blueprint);
    assert!(trace.contact().is_none());
    let radius = van.cast.pedestrian().body.radius;
    assert!(trace.pedestrian(0).iter().all(|state| outline.distance_to(state.pose.position()) > radius - 1e-4));
}

#[test]
fn a_follower_appears_behind_the_ego_with_its_speed_and_its_gap() {
    let mut scenario = two_and_two("follower", ("follower", ahead(0.0)), (away(), Controller::Fixed(STANDING)));
    scenario.cast.vehicles[1].place = Placement::Behind { gap: Distribution::Uniform(1.0, 2.0) };
    scenario.spawn.ego_speed = EgoSpeed::Steady;
    let scenario = Arc::new(scenario);
    let (_, trace) = run(&scenario, [STANDING; 2]);
    let (ego, other) = (trace.vehicle(0)[0].state, trace.vehicle(1)[0].state);
    let apart = ego.pose.x - other.pose.x - 2.0 * scenario.cast.ego().blueprint.half_length;
    assert_eq!(other.speed, ego.speed);
    assert!(
        (1.0..2.0).contains(&(apart / ego.speed)) && (other.pose.y - LANE).abs() < 0.1,
        "{apart} m at {} m/s",
        ego.speed
    );
    assert_ne!(trace.vehicle(1)[20].state.speed, ego.speed, "its driver drives");
}

#[test]
fn placed_pedestrians_keep_their_distances_and_draw_for_themselves() {
    let scene = |distance| {
        let mut scenario = two_and_two("follower", ("slow", ahead(40.0)), (away(), Controller::Fixed(STANDING)));
        let beside = Placement::Beside { anchor: ActorId::Pedestrian(0), distance };
        scenario.cast.pedestrians[1].place = beside;
        let ahead = Placement::Ahead {
            anchor: ActorId::Pedestrian(1),
            distance: Distribution::Constant(1.0),
            aside: Distribution::Constant(-2.0),
        };
        let role = PedestrianRole { place: ahead, ..scenario.cast.pedestrians[1].clone() };
        scenario.cast.pedestrians.push(role);
        Arc::new(scenario)
    };
    let starts = |scenario: &Arc<Scenario>, episode| {
        let mut env = scenario.simulation();
        env.start(Draw::new(&Seed::root(1), episode));
        let places: Vec<_> = env.scene().world.pedestrians.iter().map(|each| each.state.pose.position()).collect();
        places
    };
    let (near, far) = (scene(Distribution::Uniform(0.5, 2.0)), scene(Distribution::Uniform(4.0, 6.0)));
    let half = near.cast.pedestrian().body.half().x;
    let mut seen = Vec::new();
    for episode in 0..20 {
        let [first, second, third] = starts(&near, episode)[..] else { panic!("three pedestrians") };
        let apart = (second - first).norm();
        assert!((0.5 + 2.0 * half..2.0 + 2.0 * half * 2_f64.sqrt()).contains(&apart), "{apart}");
        assert!((third - second).norm() > 2.0);
        assert_eq!(starts(&far, episode)[0], first, "what is drawn for the others does not move the first");
        seen.push(apart);
    }
    seen.dedup();
    assert_eq!(seen.len(), 20);
}

#[test]
fn a_pedestrian_with_a_controller_of_its_own_walks_by_it_whatever_is_decided() {
    let place = ActorStart::standing(Pose::new(90.0, -6.0, 0.0));
    let with = |controller| Arc::new(two_and_two("follower", ("slow", ahead(40.0)), (place, controller)));
    let own = episode::walker::Controller::new("intercept", || Box::new(Intercept));
    let (alone, left) = (with(Controller::Own(own)), with(Controller::External));
    let (outcome, trace) = run(&alone, [STANDING; 2]);
    // The same pedestrian, moved from outside; the first one stands.
    let mut env = left.simulation();
    env.start(Draw::new(&Seed::root(1), 0));
    while env.outcome().is_none() {
        let mut commands = [STANDING; 2];
        commands[1] = env.scene().intercept(1);
        env.carry_out(&commands);
    }
    assert_eq!((outcome.digest, outcome.ticks), (env.outcome().unwrap().digest, env.outcome().unwrap().ticks));
    assert!(trace.decisions(1).iter().all(|command| command.speed > 3.0), "{:?}", trace.decisions(1));
    assert_eq!(alone.cast.obs_dim(), ObservationSpec::DIM, "a search moves the first alone");
    // A copy goes on as the original does.
    let mut env = alone.simulation();
    env.start(Draw::new(&Seed::root(1), 0));
    env.carry_out(&[STANDING; 2]);
    let mut copy = env.snapshot().unwrap();
    while copy.outcome().is_none() {
        copy.carry_out(&[STANDING; 2]);
    }
    assert_eq!(copy.outcome(), Some(&outcome));
}

/// A campaign whose cast is declared in place.
const CAST: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
town long {
  lane_width: 3.5 m
  traffic_lights: false
  street long { through: [(0 m, 0 m), (250 m, 0 m), (500 m, 0 m)]  speed_limit: 50 km/h }
}
body small { shape: child }
campaign cast {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  cast {
    friend: pedestrian(moved_by: natural, beside: child, distance: 0.5 m .. 2 m)
    child: pedestrian(body: small)
    van: vehicle(vehicle: generic(length: 5.5 m, width: 2 m), distance: 12 m .. 20 m, aside: -3.2 m)
    follower: vehicle(driver: idm(), behind: ego, gap: 1 s .. 2 s)
    crowd: pedestrian(moved_by: still, count: 3, ahead_of: van, distance: 3 m .. 9 m, aside: -4 m .. -1 m)
  }
  evaluate { towns: [long] drivers: [idm()] pedestrians: [intercept] }
}
"#;

#[test]
fn a_campaign_names_its_cast_and_the_block_moves_the_one_that_is_left() {
    let root = crate::repository().join("scenarios/cast.scn");
    let read = |path: &Path| if path == root { Ok(CAST.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let scenario = plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone();
    let names: Vec<String> = scenario.cast.actors().map(|actor| scenario.cast.name(actor).to_string()).collect();
    assert_eq!(names, ["ego", "van", "follower", "child", "friend", "crowd", "crowd", "crowd"]);
    let controlled: Vec<usize> = scenario.cast.controlled().map(|(number, _)| number).collect();
    assert_eq!(controlled, [0]);
    assert!(scenario.cast.pedestrian().body.is_child() && !scenario.cast.pedestrians[1].body.is_child());
    assert!(scenario.cast.vehicles[1].is_parked && !scenario.cast.vehicles[2].is_parked);
    let outcomes =
        || evaluate(&mut Intercept, &scenario, 20, &Seed::root(1), &Seed::root(2), &mut |_| ControlFlow::Continue(()));
    let first = outcomes();
    assert_eq!(first, outcomes());
    assert!(first.iter().any(Outcome::is_collision) && first.iter().all(|outcome| outcome.fault().is_none()));
}

/// A scenario of the cast with these requirements.
fn cast_with(requirements: &str, names: &str) -> Arc<Scenario> {
    let text = CAST
        .replace("campaign", &format!("{requirements}\ncampaign"))
        .replace("episode: thirty_seconds", &format!("episode: thirty_seconds  requirements: [{names}]"));
    let root = crate::repository().join("scenarios/cast.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

/// Whom the car has touched lies there, and is not far away.
#[test]
fn a_requirement_knows_where_the_first_touched_lies() {
    let near = cast_with("requirement near = always(friend.gap < 50 m)", "near").requirements.clone();
    let mut scenario = Scenario::clone(&flank_and_lane(110.0));
    scenario.requirements = near;
    let scenario = Arc::new(scenario);
    let (outcome, trace) = run(&scenario, [STANDING; 2]);
    assert!(matches!(outcome.ending, Ending::Touch { pedestrian: 0, .. }), "{outcome:?}");
    let [near] = trace.degrees() else { panic!("one requirement") };
    assert!((15.0..35.0).contains(&near.robustness), "{near:?}");
    let again = episode::OtherDrive::recorded(trace.main_pair(&scenario), &scenario.requirements[0].requirement);
    assert!((again.robustness - near.robustness).abs() < 1e-9, "{} and {}", again.robustness, near.robustness);
}

#[test]
fn requirements_name_roles_and_hold_of_every_member_of_a_group() {
    let rooms = "requirement room = always(min(crowd.gap) > 0.2 m)\nrequirement shadow = eventually(gap(child, van) < 60 m and van.ahead > 0 m)";
    let scenario = cast_with(rooms, "room, shadow");
    let still = WalkCommand { heading: 0.0, speed: 0.0 };
    let mut env = scenario.simulation();
    let mut trace = Trace::new(&scenario);
    env.start(Draw::new(&Seed::root(1), 0));
    trace.begin(&env.scene());
    while env.outcome().is_none() {
        carry_out(&mut *env, &[still; 5], &mut trace);
    }
    let blueprint = &scenario.cast.ego().blueprint;
    let gap = |member: usize, tick: usize| {
        trace.pedestrian(member)[tick]
            .gap_to(&trace.vehicle(0)[tick].state.outline(blueprint), &scenario.cast.pedestrians[member].body)
    };
    let members = (2..5).flat_map(|member| (0..trace.vehicle(0).len()).map(move |tick| (member, tick)));
    let least = members.map(|(member, tick)| gap(member, tick)).fold(f64::INFINITY, f64::min);
    let [room, shadow] = env.degrees() else { panic!("two requirements") };
    assert!((room.robustness - (least - 0.2)).abs() < 1e-9, "{} and {least}", room.robustness);
    assert!(!shadow.is_violated());
    // The samples of a recorded episode have the same values.
    let pair = trace.main_pair(&scenario);
    let again = episode::OtherDrive::recorded(pair, &scenario.requirements[0].requirement);
    assert!((again.robustness - room.robustness).abs() < 1e-9);
}

/// A child runs into the street from behind a parked van, after it has stood for some decisions of 0.2 s; somebody stands far away.
fn out_of_the_shadow(wait: usize) -> Incident {
    let mut scenario = behind_a_van(true);
    scenario.cast.vehicles[0] = vehicle("blind");
    let far = Placement::Fixed(away());
    let role =
        PedestrianRole { controller: Controller::Fixed(STANDING), place: far, ..scenario.cast.pedestrian().clone() };
    scenario.cast.pedestrians.push(role);
    scenario.episode.hold = 4;
    let runs = WalkCommand { heading: std::f64::consts::FRAC_PI_2, speed: 3.5 };
    let commands = (0..60).flat_map(|number| [if number < wait { STANDING } else { runs }, STANDING]).collect();
    Incident { scenario: Arc::new(scenario), seed: Seed::root(1), start: 0, commands, criterion: Criterion::Collision }
}

#[test]
fn removal_names_the_child_and_neither_the_van_nor_the_one_who_stands_far_away() {
    let mut failures = 0;
    for incident in (0..25).map(out_of_the_shadow) {
        let fails = Reruns::new(&incident).run(&incident.commands).is_some_and(|rerun| rerun.outcome.is_collision());
        if fails {
            let found: Vec<_> = needs(&incident).iter().map(|need| (need.actor, need.is_needed)).collect();
            let wanted =
                [(ActorId::Vehicle(1), false), (ActorId::Pedestrian(0), true), (ActorId::Pedestrian(1), false)];
            assert_eq!(found, wanted, "the driver is blind");
            failures += 1;
        }
    }
    assert!(failures > 0);
}

/// Somebody far away whose policy draws: the commands of the others are carried out in the decision that takes them, and it is not needed.
#[test]
fn somebody_who_walks_at_random_far_away_is_not_needed_and_delays_nobody() {
    let mut failures = 0;
    for mut incident in (0..25).map(out_of_the_shadow) {
        let mut scenario = Scenario::clone(&incident.scenario);
        scenario.cast.pedestrians[1].controller =
            Controller::Own(episode::walker::Controller::new("random", || Box::new(Random::default())));
        incident.scenario = Arc::new(scenario);
        let again = Reruns::new(&incident).run(&incident.commands).unwrap();
        let taken = again.commands.iter().step_by(2);
        assert!(taken.zip(incident.commands.iter().step_by(2)).all(|(taken, told)| taken == told));
        if again.outcome.is_collision() {
            let found: Vec<_> = needs(&incident).iter().map(|need| (need.actor, need.is_needed)).collect();
            let wanted =
                [(ActorId::Vehicle(1), false), (ActorId::Pedestrian(0), true), (ActorId::Pedestrian(1), false)];
            assert_eq!(found, wanted, "the driver is blind");
            failures += 1;
        }
    }
    assert!(failures > 0);
}

#[test]
fn a_driver_sees_a_parked_car_in_its_lane_and_stops_behind_it() {
    let parked = ActorStart::standing(Pose::new(120.0, LANE, 0.0));
    let mut scenario = two_and_two("follower", ("blind", parked), (away(), Controller::Fixed(STANDING)));
    scenario.cast.vehicles[1].is_parked = true;
    let (outcome, trace) = run(&Arc::new(scenario), [STANDING; 2]);
    assert_eq!((outcome.ending, trace.contact()), (Ending::Timeout, None));
    let last = trace.vehicle(0)[600].state;
    assert!(last.speed < 0.1 && last.pose.x > 100.0, "{last:?}");
}

/// The ego does not look; the second pedestrian stands in its lane, and the first far away. Both are moved from outside.
fn one_in_the_lane() -> Arc<Scenario> {
    let place = ActorStart::standing(Pose::new(95.0, LANE, 0.0));
    Arc::new(two_and_two("blind", ("blind", ahead(150.0)), (place, Controller::External)))
}

#[test]
fn each_pedestrian_earns_what_the_episode_earns_with_it_and_not_without_it() {
    let scenario = one_in_the_lane();
    let credits = |credit| {
        let config = PpoConfig { policies: Some(Policies::Shared), credit: Some(credit), ..PpoConfig::paper() };
        let mut env = PedestrianEnv::new(scenario.simulation(), Seed::root(1)).with_agents(&config);
        let dims = |agent: Agent| (agent.policy, agent.obs_dim, agent.action_bounds.len());
        let each = (0, ObservationSpec::DIM, ActionSpec::DIM);
        assert_eq!(env.agents().into_iter().map(dims).collect::<Vec<_>>(), [each; 2]);
        let mut states = [0.0; 2 * ObservationSpec::DIM];
        let mut earned = [0.0; 2];
        env.reset(&mut states);
        loop {
            let step = env.step(&[0.0; 4], &mut states);
            (0..2).for_each(|agent| earned[agent] += env.credit(agent, step.reward));
            if step.done() {
                break (earned, env.simulation().outcome().copied().unwrap());
            }
        }
    };
    let ([first, second], outcome) = credits(Credit::Team);
    assert_eq!((first, second), (outcome.reward, outcome.reward));
    assert!(outcome.is_collision() && outcome.reward > 3.0, "{outcome:?}");
    let ([first, second], _) = credits(Credit::Own);
    assert!(second > 3.0 && first < second, "{first} {second}");
    let (removal, _) = credits(Credit::Removal);
    for (number, credit) in removal.into_iter().enumerate() {
        let cast = scenario.cast.without(ActorId::Pedestrian(number as u8));
        let (without, _) = run(&Arc::new(Scenario { cast, ..Scenario::clone(&scenario) }), [STANDING; 2]);
        assert!((credit - (outcome.reward - without.reward)).abs() < 1e-9, "pedestrian {number}: {credit}");
    }
    assert!(removal[0] == 0.0 && removal[1] > 3.0, "{removal:?}");
}

#[test]
fn one_policy_learns_for_all_pedestrians_or_one_for_each_role_and_is_that_of_one_where_there_is_one() {
    let config = |kind: Option<(Policies, Credit)>| PpoConfig {
        steps: 60,
        steps_per_update: 30,
        batch_size: 30,
        epochs: 2,
        hidden: vec![8],
        policies: kind.map(|kind| kind.0),
        credit: kind.map(|kind| kind.1),
        ..PpoConfig::paper()
    };
    let trained = |scenario: &Arc<Scenario>, kind| {
        let run = TrainingRun::begin(std::slice::from_ref(scenario), 2, &config(kind), &Seed::root(7)).unwrap();
        run.carry_on(&mut |_| ControlFlow::Continue(())).unwrap().policies
    };
    let alone = Arc::new(scenario("long", "blind"));
    let one = trained(&alone, None);
    for policies in [Policies::Shared, Policies::Each] {
        assert_eq!(trained(&alone, Some((policies, Credit::Team))), one);
    }
    let mut both = Scenario::clone(&one_in_the_lane());
    assert_eq!(trained(&Arc::new(both.clone()), None)[0].action_dim(), 2 * ActionSpec::DIM);
    // The members of a group have one role.
    let group = Some((Policies::Each, Credit::Own));
    assert_eq!(
        trained(&Arc::new(both.clone()), group),
        trained(&Arc::new(both.clone()), Some((Policies::Shared, Credit::Own)))
    );
    both.cast.pedestrians[1].name = "second".into();
    let both = Arc::new(both);
    for kind in [(Policies::Shared, Credit::Removal), (Policies::Each, Credit::Team), (Policies::Each, Credit::Removal)]
    {
        let policies = trained(&both, Some(kind));
        let number = if kind.0 == Policies::Each { 2 } else { 1 };
        assert!(policies.len() == number && policies[0] != policies[number - 1] || number == 1);
        // Each is moved by what that one sees.
        let mut walker = TrainedWalker::new(policies.clone(), &both.cast, ActionMode::Deterministic);
        let mut env = both.simulation();
        env.start(Draw::new(&Seed::root(1), 0));
        walker.begin(Seed::root(2).stream());
        let mut commands = [STANDING; 2];
        walker.choose(&env.scene(), &mut commands);
        let (mut states, mut joint, mut wanted) = ([0.0; 2 * ObservationSpec::DIM], [0.0; 4], [STANDING; 2]);
        env.scene().write_state(&mut states);
        let each = states.chunks(ObservationSpec::DIM).zip(joint.chunks_mut(ActionSpec::DIM));
        for ((state, action), policy) in each.zip(policies.iter().cycle()) {
            assert_eq!((policy.obs_dim(), policy.action_dim()), (ObservationSpec::DIM, ActionSpec::DIM));
            policy.act(state, action, &mut policy.scratch(1));
        }
        let bounds = both.cast.action_bounds();
        joint.iter_mut().zip(bounds).for_each(|(number, (low, high))| *number = number.clamp(low, high));
        env.scene().write_commands(&joint, &mut wanted);
        assert_eq!(commands, wanted);
        assert_ne!(commands[0], commands[1]);
        // A training that is interrupted ends with the same numbers.
        let (seed, config) = (&Seed::root(7), config(Some(kind)));
        let mut begun = TrainingRun::begin(std::slice::from_ref(&both), 2, &config, seed).unwrap();
        begun.update().unwrap();
        let state = begun.state(&std::collections::BTreeMap::new());
        let again = TrainingRun::resume(&state, std::slice::from_ref(&both), None, 2, &config, seed).unwrap();
        assert_eq!(again.carry_on(&mut |_| ControlFlow::Continue(())).unwrap().policies, policies);
    }
}

#[test]
fn a_search_gives_each_pedestrian_a_goal_of_its_own_and_cells_name_the_role_that_was_hit() {
    let beside = ActorStart::standing(Pose::new(85.0, 3.0, 0.0));
    let mut both = two_and_two("blind", ("blind", ahead(80.0)), (beside, Controller::External));
    both.cast.pedestrians[1].name = "second".into();
    (both.spawn.bearing, both.spawn.distance) = (Distribution::Constant(-0.2), Distribution::Constant(25.0));
    let both = Arc::new(both);
    let search = |falsifier: &dyn Falsifier, scenario: &Arc<Scenario>| {
        let mut simulator = BudgetedSimulation::new(scenario.clone(), Seed::root(6), 60_000, &|| false);
        falsifier.search(&mut simulator, &Seed::root(7)).unwrap();
        simulator.into_spent()
    };
    let reward = DeclarationId(0);
    let keys = Archive { reward, explore: 0.1, spread: 0.1, tries: 32, again: 0.3, choice: 0.1, from: None };
    let archive = ArchiveSearch { keys, from: None };
    let found = search(&archive, &both).failures;
    let roles: BTreeSet<u8> = found.iter().map(|failure| failure.cell.role).collect();
    assert_eq!(roles, BTreeSet::from([0, 1]));
    let differ = |failure: &Failure| failure.commands.chunks(2).any(|each| each[0].speed != each[1].speed);
    assert!(found.iter().any(differ), "each has a pace of its own");
    // Policies of each pedestrian learn in a search, and are that of one where there is one.
    let learner = |kind: Option<(Policies, Credit)>| {
        let sizes =
            PpoConfig { steps_per_update: 30, batch_size: 30, epochs: 2, hidden: vec![8], ..PpoConfig::paper() };
        Learning(PpoConfig { policies: kind.map(|kind| kind.0), credit: kind.map(|kind| kind.1), ..sizes })
    };
    let alone = Arc::new(scenario("long", "blind"));
    assert_eq!(search(&learner(Some((Policies::Shared, Credit::Team))), &alone), search(&learner(None), &alone));
    let kinds = [(Policies::Shared, Credit::Team), (Policies::Shared, Credit::Own), (Policies::Each, Credit::Own)];
    let mut lane = Scenario::clone(&one_in_the_lane());
    lane.cast.pedestrians[1].name = "second".into();
    let lane = Arc::new(lane);
    let found = kinds.map(|kind| search(&learner(Some(kind)), &lane));
    assert!(found.iter().all(|spent| spent.ticks <= 60_000 && !spent.failures.is_empty()));
    assert!(found[0] != found[1] && found[1] != found[2]);
}

#[test]
fn a_walker_with_a_destination_walks_around_whom_it_meets_and_stays_there() {
    let meets = ActorStart::standing(Pose::new(70.0, LANE - 29.7, 0.0));
    let mut scenario = two_and_two("blind", ("blind", ahead(80.0)), (meets, Controller::Fixed(STANDING)));
    scenario.episode.hold = 2;
    let scenario = Arc::new(scenario);
    let least = |forces: Option<Forces>| {
        let changes = Recording::Dut;
        let destination = Some(Destination::Point(Point::new(80.0, LANE - 30.0)));
        let keys = NaturalKeys { changes, heed: 1.0, gaps: Gaps::Recorded, destination, forces };
        let mut walker = Natural::from_keys(keys);
        let mut env = scenario.simulation();
        let mut trace = Trace::new(&scenario);
        env.start(Draw::new(&Seed::root(1), 0));
        trace.begin(&env.scene());
        walker.begin(Seed::root(2).stream());
        let mut commands = [STANDING; 2];
        while env.outcome().is_none() {
            walker.choose(&env.scene(), &mut commands);
            carry_out(&mut *env, &commands, &mut trace);
        }
        let track: Vec<Point> = trace.pedestrian(0).iter().map(|state| state.pose.position()).collect();
        let last = (track[track.len() - 1] - Point::new(80.0, LANE - 30.0)).norm();
        assert!(last < 0.3, "{last} m from its destination");
        track.iter().map(|here| (here - meets.pose.position()).norm()).fold(f64::INFINITY, f64::min)
    };
    let (through, around) = (least(None), least(Some(Forces::Social)));
    assert!(around > through + 0.02, "{through} and {around}");
}

#[test]
fn a_pedestrian_sees_the_nearest_others_in_fixed_places() {
    let mut scenario = two_and_two("follower", ("slow", ahead(40.0)), (away(), Controller::Fixed(STANDING)));
    scenario.cast.pedestrians[0].observation.others = 3;
    let observation = scenario.cast.pedestrians[0].observation.clone();
    assert_eq!(observation.dim(), ObservationSpec::DIM + 3 * ObservationSpec::OTHER_DIM);
    assert_eq!(observation.components().len(), observation.dim());
    let mut env = Arc::new(scenario).simulation();
    env.start(Draw::new(&Seed::root(1), 0));
    let mut state = vec![0.0; observation.dim()];
    env.scene().write_state(&mut state);
    let world = env.scene().world;
    let here = world.pedestrians[0].state.pose;
    let places = state[ObservationSpec::DIM..].chunks(ObservationSpec::OTHER_DIM);
    let others = [world.vehicles[1].state.pose, world.pedestrians[1].state.pose];
    let mut apart = others.map(|pose| (pose.position() - here.position()).norm());
    let is_car_first = apart[0] < apart[1];
    apart.sort_by(f64::total_cmp);
    let seen: Vec<[f64; 3]> = places.map(|other| [other[0], other[1], other[2].hypot(other[3])]).collect();
    for (number, distance) in apart.into_iter().enumerate() {
        assert_eq!(seen[number][..2], [1.0, f64::from((number == 0) == is_car_first)]);
        assert!((seen[number][2] - distance).abs() < 1e-9);
    }
    assert_eq!(seen[2], [0.0; 3]);
}

#[test]
fn a_pedestrian_sees_its_place_beside_the_lane_of_the_car() {
    let mut scenario = two_and_two("follower", ("slow", ahead(40.0)), (away(), Controller::Fixed(STANDING)));
    scenario.spawn.ego_start = EgoStart::Poses(vec![Pose::new(60.0, LANE + 0.4, 0.1)]);
    scenario.spawn.bearing = Distribution::Constant(-0.5);
    scenario.spawn.distance = Distribution::Constant(10.0);
    for scaling in [Scaling::Natural, Scaling::Unit] {
        let observation = &mut scenario.cast.pedestrians[0].observation;
        (observation.road, observation.scaling) = (true, scaling);
        let observation = observation.clone();
        assert_eq!(observation.dim(), ObservationSpec::DIM + ObservationSpec::ROAD_DIM);
        assert_eq!(observation.components().len(), observation.dim());
        let mut env = Arc::new(scenario.clone()).simulation();
        env.start(Draw::new(&Seed::root(1), 0));
        let mut state = vec![0.0; observation.dim()];
        env.scene().write_state(&mut state);
        // It is 10 m from the car, 0.4 rad to the right of the road's direction; the line of sight leads back from there.
        let (x, y) = (10.0 * libm::cos(-0.4), 10.0 * libm::sin(-0.4) + 0.4);
        let sight = std::f64::consts::PI - 0.4;
        let edge = -y - 1.75;
        let natural = [x, y, edge, -edge, libm::cos(-sight), libm::sin(-sight), 0.4, 0.1];
        let units = if scaling == Scaling::Unit { [60.0, 20.0, 10.0, 6.0, 1.0, 1.0, 2.0, 2.0] } else { [1.0; 8] };
        let found = &state[ObservationSpec::DIM..];
        for ((found, natural), unit) in found.iter().zip(natural).zip(units) {
            assert!((found - natural / unit).abs() < 1e-9, "{state:?} {natural} {unit}");
        }
        // What is farther is cut.
        scenario.spawn.distance = Distribution::Constant(30.0);
        let mut env = Arc::new(scenario.clone()).simulation();
        env.start(Draw::new(&Seed::root(1), 0));
        env.scene().write_state(&mut state);
        assert_eq!(state[ObservationSpec::DIM + 3], -6.0 / units[3]);
        scenario.spawn.distance = Distribution::Constant(10.0);
    }
}
