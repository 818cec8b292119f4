//! A tick allocates nothing: an episode's memory exists before the episode starts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::{Controller, Draw, Observer, Placement, Trace, VehicleRole, carry_out};
use lang::Reader;
use rand::RngExt;
use world::sim::WalkCommand;

use crate::cast::{ahead, away, two_and_two};

/// Counts the allocations of each thread, and the bytes that it holds.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    static HELD: Cell<i64> = const { Cell::new(0) };
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[expect(unsafe_code, reason = "an allocator cannot be written otherwise; it passes everything on")]
// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        let _ = HELD.try_with(|held| held.set(held.get() + layout.size() as i64));
        // SAFETY: the caller's promise about the layout is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        let _ = HELD.try_with(|held| held.set(held.get() - layout.size() as i64));
        // SAFETY: the caller's promise about pointer and layout is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/sensors.scn"
import "lib/towns.scn"
import "lib/requirements.scn"
/// All signals that are measured tick by tick, and all operators.
requirement every_signal = always(
  until(gap > 1 m or closing_speed < 9 m/s or ttc > 1 s or pet > 1 s, in_sight, [0.5 s, 2 s]) or eventually(
    ego_jerk < 9 m/s^3 and pedestrian_acceleration < 3 m/s^2 and abs(lane_offset) < 1 m and bearing < 1 rad, [0 s, 3 s]
  ) or crosswalk_waiting
)
driver squinting = aeb(sensors: poor)
driver lav_eyed = idm(sensors: lav_eyes)
driver self_play = pufferdrive(weights: "policy.bin", pedestrians: to_wheel)
campaign ticks {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  requirements: [
    no_collision, safe_passing, comfort, keeps_lane, stops_at_red, yields_at_crosswalk, no_imminent_risk, every_signal
  ]
  train { towns: [harbour] drivers: [behavior] rewards: [r2] runs: 1 }
  evaluate {
    towns: [village]  pedestrians: [intercept]
    drivers: [
      behavior, behavior_0_9_11, behavior_0_9_13, interfuser, lav, lav_v1, idm, blind,
      aeb, rss, predictive, oracle, late_oracle, careful_human, squinting, lav_eyed, self_play
    ]
  }
}
"#;

/// Reads the scenario above as `ticks.scn`, and the weights of a network without training as `policy.bin`.
struct Files;

impl Reader for Files {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        if path.ends_with("ticks.scn") { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        let mut stream = Seed::root(1).stream();
        let mut weight = || (stream.random::<f32>() - 0.5).to_le_bytes();
        let is_policy = path.ends_with("policy.bin");
        if is_policy { Ok((0..614_172).flat_map(|_| weight()).collect()) } else { std::fs::read(path) }
    }
}

#[test]
fn a_tick_allocates_nothing_with_any_driver() {
    let root = crate::repository().join("scenarios/ticks.scn");
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &Files, &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap();
    for evaluation in plan.campaigns[0].all::<compile::Evaluation>() {
        let mut env = evaluation.scenario.simulation();
        let mut trace = Trace::new(&evaluation.scenario);
        let mut walk = |episode| {
            env.start(Draw::new(&Seed::root(1), episode));
            let before = ALLOCATIONS.get();
            trace.begin(&env.scene());
            while env.outcome().is_none() {
                let commands = [env.scene().intercept(0)];
                carry_out(&mut *env, &commands, &mut trace);
            }
            ALLOCATIONS.get() - before
        };
        // Indices and queues are filled in the first episodes.
        for episode in 0..10 {
            walk(episode);
        }
        let allocations: u64 = (10..60).map(&mut walk).sum();
        assert_eq!(allocations, 0, "{}", evaluation.policy);
    }
}

#[test]
fn a_tick_of_two_cars_and_two_pedestrians_allocates_nothing() {
    let walking = Controller::Fixed(WalkCommand { heading: 1.0, speed: 1.0 });
    let scenario = Arc::new(two_and_two("follower", ("slow", ahead(40.0)), (away(), walking)));
    let mut env = scenario.simulation();
    let mut trace = Trace::new(&scenario);
    let mut walk = |episode| {
        env.start(Draw::new(&Seed::root(1), episode));
        let before = ALLOCATIONS.get();
        trace.begin(&env.scene());
        while env.outcome().is_none() {
            let commands = [env.scene().homing(0), env.scene().homing(1)];
            carry_out(&mut *env, &commands, &mut trace);
        }
        ALLOCATIONS.get() - before
    };
    for episode in 0..10 {
        walk(episode);
    }
    assert_eq!((10..30).map(&mut walk).sum::<u64>(), 0);
}

#[test]
fn a_tick_of_twelve_pedestrians_and_four_cars_allocates_nothing_and_their_world_does_not_grow() {
    let walking = Controller::Fixed(WalkCommand { heading: 1.0, speed: 1.0 });
    let mut scenario = two_and_two("follower", ("slow", ahead(40.0)), (away(), walking));
    for number in 0..10 {
        let role = scenario.cast.pedestrians[number % 2].clone();
        scenario.cast.pedestrians.push(role);
        scenario.cast.pedestrians[number].observation.others = 4;
        scenario.cast.pedestrians[number].observation.road = true;
        if number < 2 {
            let place = Placement::Fixed(ahead(80.0 + 40.0 * number as f64));
            scenario.cast.vehicles.push(VehicleRole { place, ..scenario.cast.vehicles[1].clone() });
        }
        if number % 2 == 0 {
            scenario.cast.pedestrians[number + 2].place = Placement::Fixed(away());
        }
    }
    let scenario = Arc::new(scenario);
    let mut env = scenario.simulation();
    let mut trace = Trace::new(&scenario);
    let mut state = vec![0.0; scenario.cast.obs_dim()];
    let mut walk = |episode| {
        env.start(Draw::new(&Seed::root(1), episode));
        let mut commands = [WalkCommand::default(); 12];
        let before = ALLOCATIONS.get();
        trace.begin(&env.scene());
        while env.outcome().is_none() {
            env.scene().write_state(&mut state);
            (0..12).for_each(|number| commands[number] = env.scene().homing(number));
            carry_out(&mut *env, &commands, &mut trace);
        }
        ALLOCATIONS.get() - before
    };
    for episode in 0..10 {
        walk(episode);
    }
    let held = HELD.get();
    assert_eq!((10..20).map(&mut walk).sum::<u64>(), 0);
    assert_eq!(HELD.get(), held, "starts of episodes keep nothing, either");
}
