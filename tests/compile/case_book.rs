//! The case book of the verdict: `tests/suite/cases.toml`.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use base::seed::Seed;
use compile::{Catalog, compile};
use episode::Scenario;
use rand::RngExt;
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector};
use serde::Deserialize;
use verdict::{ContactSide, Encountered, Recording};
use world::av::reference_drivers::DelayedBrake;
use world::sim::{PedestrianState, VehicleState};

/// Seconds between two instants of a recording, and its ends, before and after the planned meeting (s).
const DT: f64 = 0.05;
const BEFORE: f64 = 9.0;
const AFTER: f64 = 1.5;

#[derive(Deserialize)]
struct Book {
    family: Vec<Family>,
}

/// One encounter at several speeds.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Family {
    name: String,
    label: String,
    counts_as: Option<String>,
    verdict: Option<String>,
    speeds: Vec<f64>,
    why: String,
    source: String,
    car: Car,
    walker: Walker,
    #[serde(default)]
    walls: Vec<[f64; 4]>,
    /// Why the verdict cannot give this label.
    cannot: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Car {
    #[serde(default)]
    #[allow(dead_code, reason = "it says that the other keys are absent")]
    keeps: bool,
    brakes: Option<Braking>,
    brakes_to: Option<BrakingTo>,
    gains: Option<Braking>,
    #[serde(default)]
    reverses: bool,
    turns: Option<Turn>,
}

#[derive(Deserialize)]
struct Braking {
    with: f64,
    r#for: f64,
}

#[derive(Deserialize)]
struct BrakingTo {
    with: f64,
    speed: f64,
    #[serde(default)]
    stands: f64,
}

#[derive(Deserialize)]
struct Turn {
    radius: f64,
    r#for: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Walker {
    meets: Option<[f64; 2]>,
    flank: Option<f64>,
    flank_left: Option<f64>,
    legs: Vec<Leg>,
    gait: Option<f64>,
}

#[derive(Deserialize)]
struct Leg {
    from: Instant,
    v: [f64; 2],
}

/// Seconds before the meeting.
#[derive(Deserialize)]
#[serde(untagged)]
enum Instant {
    Seconds(f64),
    Named(String),
}

impl Car {
    /// The instant at which it begins to brake (s before the meeting).
    fn brake(&self, speed: f64) -> f64 {
        let to = self.brakes_to.as_ref().map(|to| (speed - to.speed) / to.with + to.stands);
        to.or(self.brakes.as_ref().map(|braking| braking.r#for)).unwrap_or(0.0)
    }

    /// Its speed at a time (s), where the meeting is at 0.
    fn speed_at(&self, speed: f64, time: f64) -> f64 {
        let since = (time + self.brake(speed)).max(0.0);
        if let Some(to) = &self.brakes_to {
            return (speed - to.with * since).max(to.speed);
        }
        if let Some(braking) = &self.brakes {
            return (speed - braking.with * since).max(0.0);
        }
        match &self.gains {
            Some(gain) => (gain.with * (time + gain.r#for)).clamp(0.0, speed),
            None => speed,
        }
    }

    /// Its states; at the meeting its bumper is at the origin.
    fn states(&self, speed: f64, half_length: f64) -> Vec<VehicleState> {
        let times = || (0..).map(|step| f64::from(step) * DT - BEFORE).take_while(|time| *time <= AFTER + 1e-9);
        let mut way = 0.0;
        let ways: Vec<f64> = times()
            .map(|time| {
                let here = way;
                way += self.speed_at(speed, time) * DT;
                here
            })
            .collect();
        let at_meeting = ways[(BEFORE / DT).round() as usize];
        let states = times().zip(ways).map(|(time, way)| {
            let (along, speed) = (way - at_meeting, self.speed_at(speed, time));
            let pose = self.pose(speed, along - half_length);
            let state = VehicleState { pose, speed, age: 0.0, ..VehicleState::default() };
            if self.reverses { state.reversed() } else { state }
        });
        states.collect()
    }

    /// The pose of its middle at a way along its path (m), 0 at the origin.
    fn pose(&self, speed: f64, along: f64) -> Pose {
        let Some(turn) = &self.turns else { return Pose::new(along, 0.0, 0.0) };
        // A left turn that ends where the bumper arrives: before it, the heading is more to the right.
        let back = (-along).clamp(0.0, speed * turn.r#for);
        let angle = -back / turn.radius;
        let before = Pose::new(turn.radius * libm::sin(angle), turn.radius * (1.0 - libm::cos(angle)), angle);
        let rest = along.min(0.0) + back + along.max(0.0);
        let place = before.position() + before.forward() * rest;
        Pose::new(place.x, place.y, angle)
    }
}

/// The stopping time (s) of UN R157's careful human from a speed (m/s).
fn stopping_time(speed: f64) -> f64 {
    DelayedBrake::careful_human().profile.stopping_distance(speed) / speed
}

impl Family {
    fn instant(&self, instant: &Instant, speed: f64) -> f64 {
        let text = match instant {
            Instant::Seconds(seconds) => return *seconds,
            Instant::Named(text) => text,
        };
        let (name, rest) = text.split_once(' ').unwrap_or((text, "+ 0"));
        let rest: f64 = rest.replace(' ', "").parse().expect("a number follows the name");
        rest + match name {
            "stop" => stopping_time(speed),
            "brake" => self.car.brake(speed),
            other => panic!("`{other}` is no instant"),
        }
    }

    /// The states of the pedestrian, whose middle is at a place at the meeting.
    fn walked(&self, speed: f64, place: Point) -> Vec<PedestrianState> {
        let gait = self.walker.gait.unwrap_or(1.5);
        let leg = |time: f64| {
            let mut begun = self.walker.legs.iter().filter(|leg| -self.instant(&leg.from, speed) <= time + 1e-9);
            begun.next_back().map_or(Vector::zeros(), |leg| Vector::new(leg.v[0], leg.v[1]))
        };
        let mut velocity = leg(-BEFORE);
        let mut here = Point::origin();
        let mut walked = Vec::new();
        for step in 0..((BEFORE + AFTER) / DT).round() as usize + 1 {
            let missing = leg(step as f64 * DT - BEFORE) - velocity;
            velocity += missing * (gait * DT / missing.norm().max(1e-9)).min(1.0);
            walked.push((here, velocity));
            here += velocity * DT;
        }
        let shift = place - walked[(BEFORE / DT).round() as usize].0;
        let states = walked.into_iter().map(|(position, velocity)| {
            let position = position + shift;
            let yaw = libm::atan2(velocity.y, velocity.x);
            PedestrianState { velocity, ..PedestrianState::standing(Pose::new(position.x, position.y, yaw)) }
        });
        states.collect()
    }

    fn judged(&self, speed: f64, scenario: &Scenario) -> Encountered {
        let (cars, walkers, walls) = self.tracks(speed, scenario);
        Recording::new(DT, cars, walkers).unwrap().judged(scenario, walls)
    }

    /// The states of both, and what hides the pedestrian.
    fn tracks(&self, speed: f64, scenario: &Scenario) -> (Vec<VehicleState>, Vec<PedestrianState>, Arc<Obstacles>) {
        let (car, radius) = (&scenario.cast.ego().blueprint, scenario.cast.pedestrian().body.radius);
        let walker = &self.walker;
        let beside = car.half_width + radius;
        let place = match (walker.meets, walker.flank, walker.flank_left) {
            (Some([x, y]), None, None) => Point::new(x + radius, y),
            (None, Some(behind), None) => Point::new(-behind, -beside),
            (None, None, Some(behind)) => Point::new(-behind, beside),
            _ => panic!("{}: one of `meets`, `flank` and `flank_left`", self.name),
        };
        let walls: Vec<OrientedBox> = self
            .walls
            .iter()
            .map(|[left, right, low, high]| OrientedBox {
                pose: Pose::new((left + right) / 2.0, (low + high) / 2.0, 0.0),
                half: Vector::new((right - left) / 2.0, (high - low) / 2.0),
            })
            .collect();
        (self.car.states(speed, car.half_length), self.walked(speed, place), Arc::new(Obstacles::new(&walls)))
    }
}

/// A scenario with the paper's car and pedestrian; the rest of it does not matter.
pub fn scenario() -> Arc<Scenario> {
    const TEXT: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
campaign judged {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour] drivers: [blind] pedestrians: [random] episodes: 1 }
}
"#;
    let root = crate::repository().join("scenarios/judged.scn");
    let read = |path: &Path| if path == root { Ok(TEXT.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap().campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

fn book() -> Vec<Family> {
    let path = crate::repository().join("tests/suite/cases.toml");
    toml::from_str::<Book>(&std::fs::read_to_string(path).unwrap()).unwrap().family
}

#[test]
fn every_case_is_the_encounter_that_it_describes() {
    let scenario = scenario();
    let mut cases = 0;
    for family in book() {
        assert!(!family.why.is_empty() && !family.source.is_empty(), "{}", family.name);
        for speed in &family.speeds {
            cases += 1;
            let found = family.judged(speed / 3.6, &scenario);
            let what = format!("{}, {speed} km/h: {found:?}", family.name);
            let touch = found.touch.unwrap_or_else(|| panic!("no touch: {what}"));
            assert!((touch - BEFORE).abs() < 0.6, "{what}");
            let verdict = found.verdict.expect("they touched");
            let at_side = family.walker.flank.or(family.walker.flank_left).is_some();
            let behind = family.walker.meets.is_some_and(|[x, _]| x < -1.0);
            let side = match (at_side, behind) {
                (true, _) => ContactSide::Side,
                // A car that reverses leads with its rear.
                (_, is_rear) if is_rear != family.car.reverses => ContactSide::Rear,
                _ => ContactSide::Front,
            };
            assert_eq!(verdict.side, side, "{what}");
            let last = family.car.speed_at(speed / 3.6, touch - BEFORE);
            assert!((verdict.impact_speed - last).abs() < 0.5, "{last} m/s: {what}");
            let quick = family.counts_as.as_deref() == Some("unforeseeable");
            assert_eq!(verdict.foreseeable, !quick, "{what}");
        }
    }
    assert!(cases >= 150, "the case book has shrunk to {cases} cases");
}

#[test]
fn every_case_has_the_label_that_leaves_no_doubt() {
    let scenario = scenario();
    let mut wrong = Vec::new();
    for family in book() {
        for speed in &family.speeds {
            let verdict = family.judged(speed / 3.6, &scenario).verdict.expect("they touched");
            let label = if verdict.is_fault() { "fault" } else { "no fault" };
            let named = family.verdict.as_ref().is_none_or(|name| verdict.label.name() == name)
                && family.counts_as.as_ref().is_none_or(|name| verdict.class().name() == name);
            if (label == family.label && named) == family.cannot.is_some() {
                let counts_as = verdict.class().name();
                wrong.push(format!("{}, {speed} km/h: {label}, {:?}, {counts_as}", family.name, verdict.label));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Noise of positions, and the rate and the form of a recording, change no label.
#[test]
fn noise_and_rate_of_a_recording_change_no_label() {
    let scenario = scenario();
    let mut wrong = Vec::new();
    let mut stream = Seed::root(50).stream();
    let mut judged = 0;
    for family in book().into_iter().filter(|family| family.cannot.is_none() && family.walls.is_empty()) {
        for speed in &family.speeds {
            for (noise, every) in [(0.001, 1), (0.005, 2), (0.01, 1), (0.01, 2), (0.03, 1), (0.03, 2)] {
                let (mut cars, walkers, walls) = family.tracks(speed / 3.6, &scenario);
                let mut draw = |middle: f64| {
                    let (radius, angle) = (stream.random_range(1e-12..1.0_f64), stream.random_range(0.0..TAU));
                    middle + noise * (-2.0 * libm::log(radius)).sqrt() * libm::cos(angle)
                };
                for car in &mut cars {
                    (car.pose.x, car.pose.y) = (draw(car.pose.x), draw(car.pose.y));
                }
                let cars: Vec<_> = cars.into_iter().step_by(every).collect();
                let walkers = walkers.iter().step_by(every);
                let places: Vec<_> = walkers.map(|state| Point::new(draw(state.pose.x), draw(state.pose.y))).collect();
                let dt = DT * every as f64;
                let recording = Recording::of_positions(dt, cars, &places);
                let found = recording.map(|recording| recording.judged(&scenario, walls));
                let verdict = found.as_ref().map(|found| found.verdict.as_ref().map(|verdict| verdict.class().name()));
                let is_fault = matches!(verdict, Ok(Some("fault" | "runner")));
                judged += 1;
                if is_fault != (family.label == "fault") {
                    wrong.push(format!("{}, {speed} km/h, {noise} m every {dt} s: {verdict:?}", family.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {judged} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
