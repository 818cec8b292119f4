//! Manoeuvres of a car in another simulator, compared with what its wheels and pedals are told.

use std::io;
use std::path::Path;
use std::sync::Arc;

use super::driver_trial::told;
use base::diagnostic::Sources;
use base::seed::{Seed, Stream};
use compile::{Catalog, Evaluation, compile};
use world::av::{DrivingMode, DrivingPolicy, Fault, Perception};
use world::env::{Draw, Outcome, Phase, Scenario};
use world::geometry::{Vector, wrap_angle};
use world::sim::{Control, VehicleState};

/// A crossing, on whose street the car begins at 8 m/s: with somebody behind it, in its way, and 0.6 m beside its way; and at rest.
const STREET: &str = "\
edition 1
town proving_ground {
  street along { through: [(0 m, 0 m), (100 m, 0 m), (200 m, 0 m)] }
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
const STRAIGHT: (Control, u32) = (Control { throttle: 0.6, brake: 0.0, steer: 0.0 }, 60);
const BRAKE: (Control, u32) = (Control { throttle: 0.0, brake: 1.0, steer: 0.0 }, 80);
const LEFT: (Control, u32) = (Control { throttle: 0.4, brake: 0.0, steer: 0.15 }, 100);
const PAST: u32 = 100;
const STAND: (Control, u32) = (Control::FULL_BRAKE, 20);

/// How far it may get from its start while its brake is on (m, rad).
const ASIDE: (f64, f64) = (0.05, 0.02);
/// How far the car may get from a straight line (m), and turn on it (rad).
const ASTRAY: (f64, f64) = (0.5, 0.05);
/// By which factor what it gains of speed, its way until it stands, and its angle and radius may differ from what they are to be.
const GAIN: f64 = 3.0;
const STOP: f64 = 1.6;
const TURN: f64 = 1.4;
/// How far somebody beside its way may change that (m).
const UNTOUCHED: f64 = 0.2;
/// A car that is slower stands (m/s).
const STANDING: f64 = 0.2;

/// What a manoeuvre showed, or what was wrong with it.
type Found = Result<String, String>;

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

/// What a car did.
struct Drive {
    states: Vec<VehicleState>,
    outcome: Option<Outcome>,
}

/// The scenarios of the text above, with a car that another simulator moves as `there` says.
fn scenarios(there: &Scenario) -> [Scenario; 4] {
    let read = |path: &Path| match path.to_str() {
        Some("street.scn") => Ok(STREET.to_string()),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    };
    let compiled = compile(&["street.scn".into()], &Catalog::builtin(), &read, &mut Sources::default());
    let plan = compiled.ok().and_then(|compiled| compiled.plan).expect("the text above is sound");
    let scenario = |number| Scenario {
        external_world: there.external_world.clone(),
        ..(*plan.campaigns[0].nth::<Evaluation>(number).scenario).clone()
    };
    [0, 1, 2, 3].map(scenario)
}

fn drive(scenario: &Scenario, (control, ticks): (Control, u32)) -> Drive {
    let mut scenario = scenario.clone();
    scenario.cast.vehicles[0].policy = Arc::new(move || Box::new(Constant(control)));
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
    Drive { states, outcome: simulation.outcome().copied() }
}

impl Drive {
    /// # Errors
    /// What failed as a program.
    fn whole(self) -> Result<Self, String> {
        self.outcome.as_ref().and_then(Outcome::fault).map_or(Ok(self), |fault| Err(told(fault)))
    }

    fn first(&self) -> VehicleState {
        self.states[0]
    }

    fn last(&self) -> VehicleState {
        self.states[self.states.len() - 1]
    }

    /// Where it is after some ticks, from its start: ahead and to the left (m).
    fn place(&self, ticks: usize) -> Vector {
        self.first().pose.to_local(self.states[ticks].pose.position())
    }

    /// Where it ends.
    fn end(&self) -> Vector {
        self.place(self.states.len() - 1)
    }

    fn way(&self) -> f64 {
        self.states.windows(2).map(|pair| (pair[1].pose.position() - pair[0].pose.position()).norm()).sum()
    }
}

/// Whether a number is another one by at most this factor.
fn is_near(one: f64, other: f64, factor: f64) -> bool {
    (one / factor..=one * factor).contains(&other)
}

/// Lets a car stand, drive straight, brake, turn, and meet somebody. The first that fails is the last.
pub fn manoeuvres(there: &Scenario) -> Vec<(&'static str, Found)> {
    let [behind, ahead, beside, still] = scenarios(there);
    let mut tried = Vec::new();
    let trials: [(&str, &dyn Fn() -> Found); 5] = [
        ("stands where it is put", &|| stands(&drive(&still, STAND).whole()?)),
        ("drives straight on, faster with its throttle", &|| {
            goes_straight(&ours(&behind, STRAIGHT), &drive(&behind, STRAIGHT).whole()?)
        }),
        ("brakes as it is told", &|| brakes(&ours(&behind, BRAKE), &drive(&behind, BRAKE).whole()?)),
        ("turns the car as it is told", &|| turns(&behind, &drive(&behind, LEFT).whole()?)),
        ("leaves collisions to us", &|| meets(&behind, &ahead, &beside)),
    ];
    for (what, trial) in trials {
        let found = trial();
        let failed = found.is_err();
        tried.push((what, found));
        if failed {
            break;
        }
    }
    tried
}

/// The same in our simulator.
fn ours(scenario: &Scenario, manoeuvre: (Control, u32)) -> Drive {
    drive(&Scenario { external_world: None, ..scenario.clone() }, manoeuvre)
}

fn stands(theirs: &Drive) -> Found {
    let off = theirs.states.iter().map(|state| (state.pose.position() - theirs.first().pose.position()).norm());
    let off = off.fold(0.0, f64::max);
    let turned = theirs.states.iter().map(|state| wrap_angle(state.pose.yaw - theirs.first().pose.yaw).abs());
    let turned = turned.fold(0.0, f64::max);
    let said = format!("with its brake on it gets {off:.2} m away, turned by {:.0}°", turned.to_degrees());
    if off <= ASIDE.0 && turned <= ASIDE.1 {
        return Ok(said);
    }
    Err(format!("{said}; the place of a car is the middle of its box, at the start and later"))
}

fn goes_straight(ours: &Drive, theirs: &Drive) -> Found {
    let (end, turned) = (theirs.end(), wrap_angle(theirs.last().pose.yaw - theirs.first().pose.yaw));
    let ticks = STRAIGHT.1;
    if end.y.abs() > ASTRAY.0 || turned.abs() > ASTRAY.1 {
        let side = if end.y > 0.0 { "left" } else { "right" };
        return Err(format!(
            "after {ticks} ticks with its wheels straight it is {:.1} m to the {side}, turned by {:.0}°",
            end.y.abs(),
            turned.to_degrees()
        ));
    }
    let gain = |drive: &Drive| drive.last().speed - drive.first().speed;
    let said = format!(
        "after {ticks} ticks it is {:.1} m ahead and {:.2} m aside, faster by {:.1} m/s; our car is faster by {:.1} m/s",
        end.x,
        end.y.abs(),
        gain(theirs),
        gain(ours)
    );
    if is_near(gain(ours), gain(theirs), GAIN) {
        Ok(said)
    } else {
        Err(format!("{said}: use `throttle`, or `acceleration`"))
    }
}

fn brakes(ours: &Drive, theirs: &Drive) -> Found {
    let speed = theirs.first().speed;
    let (stop, wanted) = (theirs.way(), ours.way());
    if theirs.last().speed > STANDING {
        return Err(format!(
            "after {} ticks of full brake from {speed:.1} m/s it still drives {:.1} m/s, and our car stops after {wanted:.1} m: use `brake`, or `acceleration`",
            BRAKE.1,
            theirs.last().speed
        ));
    }
    let said = format!("from {speed:.1} m/s it stops after {stop:.1} m, our car after {wanted:.1} m");
    if is_near(wanted, stop, STOP) { Ok(said) } else { Err(format!("{said}: use `brake`, or `acceleration`")) }
}

/// Compares the way of a car with the circle on which its wheels put it, at its own speeds.
fn turns(scenario: &Scenario, theirs: &Drive) -> Found {
    let car = &scenario.cast.ego().blueprint;
    let pairs: Vec<_> = theirs.states.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let as_told = |[before, _]: &[VehicleState; 2]| before.step(LEFT.0, car, scenario.episode.tick);
    let wanted: f64 = pairs.iter().map(|pair| wrap_angle(as_told(pair).pose.yaw - pair[0].pose.yaw)).sum();
    let end = theirs.end();
    let direction =
        |[before, after]: &[VehicleState; 2]| before.pose.yaw + before.pose.bearing_to(after.pose.position());
    let moved: f64 = pairs.windows(2).map(|two| wrap_angle(direction(&two[1]) - direction(&two[0]))).sum();
    let radius = |angle: f64| theirs.way() / angle.abs().max(1e-3);
    let said = format!(
        "with the wheel to the left it moves {:.1} m ahead and {:.1} m to the left, on a circle of {:.0} m; with the wheelbase of our car that is one of {:.0} m",
        end.x,
        end.y,
        radius(moved),
        radius(wanted)
    );
    if end.y < 0.0 || moved < 0.0 {
        return Err(format!("steer and yaw are positive to the left, y is north; {said}"));
    }
    if !is_near(wanted, moved, TURN) {
        return Err(format!("{said}: use `steer`, or `wheel_angle`, which is in rad"));
    }
    Ok(said)
}

/// Lets a car pass somebody who stands beside its way, and run into somebody in its way.
fn meets(behind: &Scenario, ahead: &Scenario, beside: &Scenario) -> Found {
    let ends = |drive: &Drive, whom: &str| match drive
        .outcome
        .as_ref()
        .map(|outcome| (outcome.fault(), outcome.least_gap))
    {
        Some((Some(Fault::EndedEarly), gap)) => Err(format!(
            "it ended the episode {gap:.2} m from somebody {whom}; collisions are judged from the poses that come back, so go on"
        )),
        Some((Some(fault), _)) => Err(told(fault)),
        _ => Ok(()),
    };
    let manoeuvre = (STRAIGHT.0, PAST);
    let (alone, past, onto) = (drive(behind, manoeuvre).whole()?, drive(beside, manoeuvre), drive(ahead, manoeuvre));
    for (drive, whom) in [(&past, "beside its way"), (&onto, "in its way")] {
        ends(drive, whom)?;
        // The last tick of a touch may show what the touch does.
        let free = drive.states.len() - 1 - usize::from(drive.outcome.is_some());
        let off = (0..=free).map(|ticks| (drive.place(ticks) - alone.place(ticks)).norm()).fold(0.0, f64::max);
        if off > UNTOUCHED {
            return Err(format!("somebody {whom} moves the car by {off:.1} m, before they touch"));
        }
    }
    match (past.outcome, onto.outcome) {
        (None, Some(_)) => Ok("it passes somebody 0.6 m beside its way, and reaches somebody in it".into()),
        _ => Err("it touches somebody 0.6 m beside its way, or does not reach somebody in it".into()),
    }
}
