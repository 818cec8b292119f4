//! The conformance test of a bridge to another simulator: real episodes in a small town, a check that they repeat, and manoeuvres.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::driver_trial::{TrialArgs, driven, failed, first_difference, first_fault, passed, proving_grounds};
use super::empty_road::told;
use super::manoeuvres::manoeuvres;
use super::{CheckArgs, for_people};
use crate::cli::external_world::external_world;
use crate::cli::failure::failed as no_files;
use crate::cli::input::session;
use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
use episode::walker::Random;
use episode::{Abilities, ExternalWorld, PolicyMaker, Scenario, WORLD_PROTOCOL};
use world::av::{Cruise, CruiseKeys, DrivingPolicy, Native, NativeKeys};

/// What may be wrong after all.
const UNTRIED: &str = "        not compared: an engine of half to twice our force, 10 % less brake, 15 % less steering, a control 0.1 s late, how its own drivers move its car; \
    other speeds, times, maps and bodies are not tried: a run compares its car in each tick, too";

const EPISODES: u32 = 4;

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
    let world = Arc::new(world);
    let ended = lanes(&world, &ground, "the town");
    if ended != ExitCode::Done {
        return ended;
    }
    ground.external_world = Some(world);
    let ours = Arc::new(|| Box::new(Cruise::new(CruiseKeys::default())) as Box<dyn DrivingPolicy>) as PolicyMaker;
    let ours = abilities.controls.then(|| ("a driver of ours".to_string(), ours));
    let theirs = abilities.drivers.iter().map(|name| (format!("its driver `{name}`"), native_driver(name.clone())));
    let drivers: Vec<(String, PolicyMaker)> = ours.into_iter().chain(theirs).collect();
    if drivers.is_empty() {
        return failed("has a driver of its own, or a car that a driver of ours drives");
    }
    for (who, policy) in drivers {
        ground.cast.vehicles[0].policy = policy;
        if let Err(reason) = drives(&Arc::new(ground.clone()), &who, &abilities) {
            return failed(&reason);
        }
    }
    let driven = if abilities.controls { manoeuvres(&ground) } else { Ok(()) };
    if let Err(reason) = driven {
        return failed(&reason);
    }
    let cannot = [
        ("cars that drivers of ours drive", abilities.controls),
        ("drivers of its own", !abilities.drivers.is_empty()),
        ("friction of the road", abilities.friction),
        ("traffic lights for its drivers", abilities.lights),
        ("seeds", abilities.seeds),
    ];
    let cannot: Vec<&str> = cannot.iter().filter(|(_, can)| !can).map(|(what, _)| *what).collect();
    if abilities.tolerance > 0.0 {
        console::say(&format!("        it puts pedestrians up to {} m from where it is told", abilities.tolerance));
    }
    if abilities.pedal_delay > 0.0 {
        console::say(&format!("        it follows its pedals up to {} s late", abilities.pedal_delay));
    }
    if !cannot.is_empty() {
        console::say(&format!("        it has no {}", cannot.join(", no ")));
    }
    console::say(UNTRIED);
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
        ended = ended.or(lanes(&world, scenario, town));
    }
    Ok(ended)
}

/// Compares the lanes of a world with those of a town.
fn lanes(world: &Arc<ExternalWorld>, scenario: &Scenario, town: &str) -> ExitCode {
    match world.lanes(scenario) {
        Ok(Some(lanes)) => passed(&format!(
            "has the lanes of {town}: {:.3} m apart on average and at most {:.3} m, at {} places",
            lanes.mean, lanes.farthest, lanes.places
        )),
        Ok(None) => console::say(&format!("        the lanes of {town} are not compared: the bridge states no lanes")),
        Err(fault) => return failed(&format!("has the lanes of {town}: {}", told(fault))),
    }
    ExitCode::Done
}

/// Lets a driver drive some episodes, and again from the same seeds.
///
/// # Errors
/// What failed.
fn drives(there: &Arc<Scenario>, who: &str, abilities: &Abilities) -> Result<(), String> {
    let first = driven(&mut Random::default(), there, EPISODES);
    let what = format!("runs {EPISODES} episodes of {who} to their end");
    if let Some(reason) = first_fault(&first.outcomes) {
        return Err(format!("{what}: {reason}"));
    }
    if first.ways < 1.0 {
        return Err(format!("{what}: the car hardly moves"));
    }
    passed(&format!("{what}, with everybody where they are told to be, and the car where its speed and its yaw lead"));
    if abilities.seeds {
        let again = driven(&mut Random::default(), there, EPISODES);
        if let Some(reason) = first_difference(&first.outcomes, &again.outcomes) {
            return Err(format!("is the same when the same seeds come again: {reason}"));
        }
        passed("is the same when the same seeds come again");
    }
    Ok(())
}

fn native_driver(driver: String) -> PolicyMaker {
    Arc::new(move || Box::new(Native::new(NativeKeys { name: driver.clone() })))
}
