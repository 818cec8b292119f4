//! The conformance test of a bridge to another simulator: real episodes in a small town, a check that they repeat, and a car that turns to the left.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::driver_trial::{TrialArgs, failed, first_difference, first_fault, passed, proving_grounds, told};
use super::{CheckArgs, for_people};
use crate::cli::external_world::external_world;
use crate::cli::failure::failed as no_files;
use crate::cli::input::session;
use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
use base::seed::{Seed, Stream};
use world::av::{Cruise, CruiseKeys, DrivingMode, DrivingPolicy, Native, NativeKeys, Perception};
use world::env::{Draw, Outcome, PolicyMaker, Scenario, Trace, WORLD_PROTOCOL};
use world::falsifier::{Random, evaluate_observed};
use world::sim::{Control, VehicleState};

/// Number of episodes, and of ticks in which the car turns.
const EPISODES: u32 = 4;
const TURN: u32 = 120;
/// What the car does while it turns to the left.
const LEFT: Control = Control { throttle: 0.5, brake: 0.0, steer: 0.15 };
/// By which factor its way may differ from that of our car.
const AS_FAR: f64 = 1.3;
/// By which factor its way may differ from what its speeds make.
const BY_SPEED: f64 = 1.05;

/// Does the same in every tick.
struct Constant(Control);

impl DrivingPolicy for Constant {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {}

    fn drive(&mut self, _: &Perception<'_>) -> Control {
        self.0
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Cruise
    }
}

/// `falsify check --world WORLD`
pub fn try_world(options: &TrialArgs, world: &str) -> ExitCode {
    interrupt::end_when_asked();
    console::say(&format!("world {world}"));
    let times = (options.timeout, options.start_timeout);
    let world = match external_world(world, Arc::new(options.opener()), times) {
        Ok(world) => world,
        Err(reason) => return failed(&format!("greets as {WORLD_PROTOCOL}: {reason}")),
    };
    let abilities = world.abilities.clone().expect("it was asked");
    passed(&format!("greets as {WORLD_PROTOCOL}: {} ({})", abilities.name, abilities.version));
    let [mut ground, _] = proving_grounds();
    let native = abilities.drivers.first().cloned();
    let usual: PolicyMaker = match (&native, abilities.controls) {
        (Some(driver), false) => native_driver(driver.clone()),
        (None, false) => return failed("has a driver of its own, or a car that a driver of ours drives"),
        _ => Arc::new(|| Box::new(Cruise::new(CruiseKeys::default())) as Box<dyn DrivingPolicy>),
    };
    ground.cast.vehicles[0].policy = usual;
    let here = Scenario { external_world: None, ..ground.clone() };
    ground.external_world = Some(Arc::new(world));
    let there = Arc::new(ground);

    let (first, traces) = episodes(&there);
    if let Some(reason) = first_fault(&first) {
        return failed(&format!("runs {EPISODES} episodes to their end: {reason}"));
    }
    passed(&format!(
        "has the lanes of the town, and runs {EPISODES} episodes to their end with pedestrians where they are told to be"
    ));
    if let Some(reason) = first_difference(&first, &episodes(&there).0) {
        return failed(&format!("is the same when the same seeds come again: {reason}"));
    }
    passed("is the same when the same seeds come again");
    if let Err(reason) = moves_by_its_speed(&traces, there.episode.tick) {
        return failed(&format!("moves the car as its speed says: {reason}"));
    }
    passed("moves the car as its speed says");
    if abilities.controls {
        match turns(&here, &there) {
            Ok(said) => passed(&format!("turns the car as it is told: {said}")),
            Err(reason) => return failed(&format!("turns the car as it is told: {reason}")),
        }
    }
    let cannot = [
        ("cars that drivers of ours drive", abilities.controls),
        ("drivers of its own", native.is_some()),
        ("friction of the road", abilities.friction),
        ("traffic lights for its drivers", abilities.lights),
        ("seeds", abilities.seeds),
    ];
    let cannot: Vec<&str> = cannot.iter().filter(|(_, can)| !can).map(|(what, _)| *what).collect();
    if abilities.tolerance > 0.0 {
        console::say(&format!("        it puts pedestrians up to {} m from where it is told", abilities.tolerance));
    }
    if !cannot.is_empty() {
        console::say(&format!("        it has no {}", cannot.join(", no ")));
    }
    ExitCode::Done
}

/// `falsify check --world WORLD FILES`: how far the lanes of a world are from those of the towns in scenario files.
pub fn compare_lanes(options: &CheckArgs, name: &str) -> Ended {
    let input = options.given.input(&options.files);
    let found = session(options.given.allow_external).check(&input).map_err(no_files)?;
    let Ok(plan) = found.plan() else { return Ok(for_people(&found)) };
    interrupt::end_when_asked();
    let times = (options.trial.timeout, options.trial.start_timeout);
    let world = match external_world(name, Arc::new(options.trial.opener()), times) {
        Ok(world) => Arc::new(world),
        Err(reason) => return Ok(failed(&format!("greets as {WORLD_PROTOCOL}: {reason}"))),
    };
    let mut compared = BTreeSet::new();
    let mut ended = ExitCode::Done;
    for (town, scenario) in plan.campaigns.iter().flat_map(|campaign| campaign.starts()) {
        if !compared.insert((town, Arc::as_ptr(&scenario.town))) {
            continue;
        }
        match world.lanes(scenario) {
            Ok(Some(lanes)) => passed(&format!(
                "has the lanes of {town}: {:.3} m apart on average and at most {:.3} m, at {} places",
                lanes.mean, lanes.farthest, lanes.places
            )),
            Ok(None) => console::say(&format!("        it has no lanes to compare with those of {town}")),
            Err(fault) => ended = failed(&format!("has the lanes of {town}: {}", told(fault))),
        }
    }
    Ok(ended)
}

fn native_driver(driver: String) -> PolicyMaker {
    Arc::new(move || Box::new(Native::new(NativeKeys { driver: driver.clone() })))
}

fn episodes(scenario: &Arc<Scenario>) -> (Vec<Outcome>, Vec<Trace>) {
    let seed = Seed::root(1);
    let mut traces = Vec::new();
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| {
        traces.push(trace.clone());
        *outcome
    };
    let go_on = &mut |_| ControlFlow::Continue(());
    let walker = &mut Random::default();
    let ended = evaluate_observed(walker, scenario, 0..EPISODES, &seed, &seed.child("walker"), note, go_on);
    (ended, traces)
}

/// Compares the way of the car with what its speeds make.
fn moves_by_its_speed(traces: &[Trace], dt: f64) -> Result<(), String> {
    let (mut way, mut expected) = (0.0, 0.0);
    for pair in traces.iter().flat_map(|trace| trace.vehicle(0).windows(2)) {
        let [before, after] = [pair[0].state, pair[1].state];
        way += (after.pose.position() - before.pose.position()).norm();
        expected += (before.speed + after.speed) / 2.0 * dt;
    }
    let factor = way / expected.max(1e-9);
    if expected < 1.0 {
        return Err("the car hardly moves".into());
    }
    if (1.0 / BY_SPEED..BY_SPEED).contains(&factor) {
        return Ok(());
    }
    Err(format!(
        "it gets {factor:.2} times as far; its time step is not the tick of {dt} s, or its speed is not in m/s"
    ))
}

/// Lets the car turn to the left here and there.
fn turns(here: &Scenario, there: &Scenario) -> Result<String, String> {
    let end = |scenario: &Scenario| -> Result<[f64; 3], String> {
        let mut scenario = scenario.clone();
        scenario.cast.vehicles[0].policy = Arc::new(|| Box::new(Constant(LEFT)));
        let mut simulation = Arc::new(scenario).simulation();
        simulation.start(Draw::new(&Seed::root(2), 0));
        let start: VehicleState = simulation.scene().world.ego().state;
        while simulation.outcome().is_none() && simulation.scene().world.ticks < TURN {
            let commands = simulation.scene().commands().to_vec();
            simulation.carry_out(&commands);
        }
        if let Some(fault) = simulation.outcome().and_then(Outcome::fault) {
            return Err(told(fault));
        }
        let end = simulation.scene().world.ego().state.pose;
        let place = start.pose.to_local(end.position());
        Ok([place.x, place.y, world::geometry::wrap_angle(end.yaw - start.pose.yaw)])
    };
    let (ours, theirs) = (end(here)?, end(there)?);
    let said = format!(
        "after {TURN} ticks it is {:.1} m ahead and {:.1} m to the left, turned by {:.0}°; our car is {:.1} m ahead and {:.1} m to the left, turned by {:.0}°",
        theirs[0],
        theirs[1],
        theirs[2].to_degrees(),
        ours[0],
        ours[1],
        ours[2].to_degrees()
    );
    if theirs[1] < 0.0 || theirs[2] < 0.0 {
        return Err(format!("steer and yaw are positive to the left, y is north; {said}"));
    }
    let far = |place: [f64; 3]| (place[0] * place[0] + place[1] * place[1]).sqrt();
    let factor = far(theirs) / far(ours).max(1e-9);
    if (1.0 / AS_FAR..AS_FAR).contains(&factor) { Ok(said) } else { Err(said) }
}
