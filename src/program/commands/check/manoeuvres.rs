//! Manoeuvres of a car in another simulator, in which the bridge compares each tick with what the wheels and pedals are told.

use std::sync::Arc;

use super::driver_trial::{passed, plan_of};
use super::empty_road::told;
use base::seed::{Seed, Stream};
use compile::Evaluation;
use episode::{Draw, Outcome, Phase, Scenario};
use road::geometry::Vector;
use world::av::{DrivingMode, DrivingPolicy, Fault, Perception};
use world::sim::{Control, VehicleState};

/// A crossing, on whose street the car begins at 8 m/s: with somebody behind it, in its way, and 0.6 m beside its way; and at rest.
const STREET: &str = "\
edition 1
town proving_ground {
  street along { through: [(0 m, 0 m), (100 m, 0 m), (400 m, 0 m)] }
  street across { through: [(100 m, -100 m), (100 m, 0 m), (100 m, 100 m)] }
}
driver placeholder = cruise()
vehicle car = model3()
body walker { }
spawn behind { ego_poses: [(20 m, -1.75 m, 0 deg)] ego_speed: 8 m/s bearing: 180 deg distance: 15 m }
spawn ahead { ego_poses: [(20 m, -1.75 m, 0 deg)] ego_speed: 8 m/s bearing: 0 deg distance: 30 m }
spawn beside { ego_poses: [(20 m, -1.75 m, 0 deg)] ego_speed: 8 m/s bearing: 3.6 deg distance: 30 m }
spawn still { ego_poses: [(20 m, -1.75 m, 30 deg)] ego_speed: 0 m/s bearing: 180 deg distance: 15 m }
episode half_a_minute { }
campaign check {
  vehicle: car body: walker spawn: behind episode: half_a_minute
  evaluate { towns: [proving_ground] drivers: [placeholder] pedestrians: [random] episodes: 1 }
  evaluate { towns: [proving_ground] drivers: [placeholder] pedestrians: [random] episodes: 1 spawn: ahead }
  evaluate { towns: [proving_ground] drivers: [placeholder] pedestrians: [random] episodes: 1 spawn: beside }
  evaluate { towns: [proving_ground] drivers: [placeholder] pedestrians: [random] episodes: 1 spawn: still }
}
";

/// What the car does, and for how many ticks.
type Part = (Control, u32);
const fn steered(throttle: f64, steer: f64, ticks: u32) -> Part {
    (Control { throttle, brake: 0.0, steer }, ticks)
}
const BRAKE: Part = (Control::FULL_BRAKE, 80);
/// It stays on the carriageway.
const FAST: [Part; 5] =
    [steered(0.7, 0.0, 160), steered(0.5, 0.05, 20), steered(0.5, -0.05, 40), steered(0.5, 0.05, 20), BRAKE];

/// How far a car that stands may get from its start (m).
const ASIDE: f64 = 0.05;

/// What a manoeuvre showed, or what was wrong with it.
type Found = Result<String, String>;

/// Does one thing after another.
struct Parts(Vec<Control>);

impl DrivingPolicy for Parts {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {}

    fn drive(&mut self, _: &Perception<'_>) -> Control {
        self.0.pop().unwrap_or(Control::FULL_BRAKE)
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Cruise
    }
}

/// The scenarios of the text above, with a car that another simulator moves as `there` says.
fn scenarios(there: &Scenario) -> [Scenario; 4] {
    let plan = plan_of(STREET);
    let scenario = |number| Scenario {
        external_world: there.external_world.clone(),
        ..(*plan.campaigns[0].nth::<Evaluation>(number).scenario).clone()
    };
    [0, 1, 2, 3].map(scenario)
}

/// What a car did, and how its episode ended if it is over.
fn drive(scenario: &Scenario, parts: &[Part]) -> (Vec<VehicleState>, Option<Outcome>) {
    let controls: Vec<Control> =
        parts.iter().rev().flat_map(|(control, ticks)| std::iter::repeat_n(*control, *ticks as usize)).collect();
    let ticks = controls.len() as u32;
    let mut scenario = scenario.clone();
    scenario.cast.vehicles[0].policy = Arc::new(move || Box::new(Parts(controls.clone())));
    let mut simulation = Arc::new(scenario).simulation();
    simulation.start(Draw::new(&Seed::root(2), 0));
    let mut states = vec![simulation.scene().world.ego().state];
    while simulation.outcome().is_none() && simulation.scene().world.ticks < ticks {
        if simulation.phase() == Phase::Decision {
            let commands = simulation.scene().commands().to_vec();
            simulation.decide(&commands);
        }
        simulation.tick();
        states.push(simulation.scene().world.ego().state);
    }
    (states, simulation.outcome().copied())
}

/// Lets a car stand, brake, turn, drive fast, and meet somebody, and says how it went.
///
/// # Errors
/// The first manoeuvre that failed, and how.
pub fn manoeuvres(there: &Scenario) -> Result<(), String> {
    let [behind, ahead, beside, still] = scenarios(there);
    let trials: [(&str, &dyn Fn() -> Found); 6] = [
        ("stands where it is put", &|| follows(&still, &[BRAKE])),
        ("brakes as it is told", &|| follows(&behind, &[BRAKE])),
        ("turns to the left as it is told", &|| follows(&behind, &[steered(0.4, 0.15, 100)])),
        ("turns to the right as it is told", &|| follows(&behind, &[steered(0.4, -0.15, 100)])),
        ("speeds up, steers and brakes as it is told", &|| follows(&behind, &FAST)),
        ("leaves collisions to us", &|| meets(&ahead, &beside)),
    ];
    for (what, trial) in trials {
        let said = trial().map_err(|reason| format!("{what}: {reason}"))?;
        passed(&format!("{what}: {said}"));
    }
    Ok(())
}

/// Lets a car do one thing after another; the bridge finds what is wrong.
fn follows(scenario: &Scenario, parts: &[Part]) -> Found {
    let (theirs, outcome) = drive(scenario, parts);
    if let Some(fault) = outcome.as_ref().and_then(Outcome::fault) {
        return Err(told(fault));
    }
    let (ours, _) = drive(&Scenario { external_world: None, ..scenario.clone() }, parts);
    let fastest = theirs.iter().map(|state| state.speed).fold(0.0, f64::max);
    // Ahead and to the left of the start.
    let [there, here] =
        [&theirs, &ours].map(|states| states[0].pose.to_local(states[states.len() - 1].pose.position()));
    let place = |end: Vector| format!("{:.2} m ahead and {:.2} m to the left", end.x, end.y);
    let (ticks, there_said, here_said) = (theirs.len() - 1, place(there), place(here));
    let said = format!("in {ticks} ticks at up to {fastest:.1} m/s it gets {there_said}, our car {here_said}");
    match fastest == 0.0 && there.norm() > ASIDE {
        true => Err(format!("{said}; the place of a car is the middle of its box, at the start and later")),
        false => Ok(said),
    }
}

/// Lets a car pass somebody who stands beside its way, and run into somebody in its way.
fn meets(ahead: &Scenario, beside: &Scenario) -> Found {
    let ends = |scenario: &Scenario, whom: &str| {
        let (_, outcome) = drive(scenario, &[steered(0.6, 0.0, 100)]);
        match outcome.as_ref().map(|outcome| (outcome.fault(), outcome.least_gap)) {
            Some((Some(Fault::EndedEarly), gap)) => Err(format!(
                "it ended the episode {gap:.2} m from somebody {whom}; collisions are judged from the poses that come back, so go on"
            )),
            Some((Some(fault), gap)) => Err(format!("{gap:.2} m from somebody {whom} {}", told(fault))),
            ended => Ok(ended.is_some()),
        }
    };
    match (ends(beside, "beside its way")?, ends(ahead, "in its way")?) {
        (false, true) => Ok("it passes somebody 0.6 m beside its way, and reaches somebody in it".into()),
        _ => Err("it touches somebody 0.6 m beside its way, or does not reach somebody in it".into()),
    }
}
