//! What must be true of the verdict, whatever the encounter.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::{Seed, Stream};
use compile::{Catalog, compile};
use episode::walker::{Homing, Intercept, Natural, Random, WalkPolicy};
use episode::{Scenario, Trace, evaluate_observed};
use rand::RngExt;
use rayon::prelude::*;
use road::geometry::{Point, Pose, Vector};
use verdict::{Encountered, Recording, Verdict, judge};
use world::av::reference_drivers::{BrakeProfile, DelayedBrake, Gate, OwnMotion, Threat};
use world::sim::{PedestrianState, VehicleState};

use crate::samples::samples;

const DT: f64 = 0.05;
/// The street: the car drives east from `x = 0`, its lane is around `y = 0`.
const MEETING: f64 = 100.0;

/// A pedestrian near the place where the car is expected at the time of the meeting.
#[derive(Clone)]
struct Walk {
    states: Vec<PedestrianState>,
}

/// A pedestrian that changes its mind up to three times, with a body's accelerations.
fn any_walk(stream: &mut Stream, ticks: usize, speed: f64) -> Walk {
    let meeting = (MEETING / speed / DT) as usize;
    let mut legs: Vec<(usize, Vector)> = (0..stream.random_range(1..4))
        .map(|_| {
            let (heading, pace) = (stream.random_range(-3.2..3.2_f64), stream.random_range(0.0..2.2));
            let from = stream.random_range(0..meeting + 1).max(meeting.saturating_sub(120));
            (from, Vector::new(libm::cos(heading), libm::sin(heading)) * pace)
        })
        .collect();
    legs[0].0 = 0;
    let at = Point::new(MEETING + stream.random_range(-1.0..4.0), stream.random_range(-1.6..1.6));
    walk(&legs, ticks, meeting, at, 1.6)
}

/// A pedestrian with these velocities (m/s) from these ticks on, who is at a place at a tick.
fn walk(legs: &[(usize, Vector)], ticks: usize, meeting: usize, at: Point, gait: f64) -> Walk {
    let target = |tick: usize| {
        let begun = legs.iter().filter(|leg| leg.0 <= tick);
        begun.max_by_key(|leg| leg.0).map_or(Vector::zeros(), |leg| leg.1)
    };
    let mut velocity = target(0);
    let mut place = Point::origin();
    let mut states: Vec<PedestrianState> = Vec::new();
    for tick in 0..ticks {
        let missing = target(tick) - velocity;
        velocity += missing * (gait * DT / missing.norm().max(1e-9)).min(1.0);
        let pose = Pose::new(place.x, place.y, libm::atan2(velocity.y, velocity.x));
        states.push(PedestrianState { velocity, ..PedestrianState::standing(pose) });
        place += velocity * DT;
    }
    let shift = at - states[meeting.min(ticks - 1)].pose.position();
    for state in &mut states {
        (state.pose.x, state.pose.y) = (state.pose.x + shift.x, state.pose.y + shift.y);
    }
    Walk { states }
}

/// The car's states for decelerations (m/s²) that a driver chooses from its speed and its position in each tick.
fn drive(speed: f64, ticks: usize, mut braking: impl FnMut(usize, f64, f64) -> f64) -> Vec<VehicleState> {
    let (mut speed, mut way) = (speed, 0.0);
    let states = (0..ticks).map(|tick| {
        let here = VehicleState { pose: Pose::new(way, 0.0, 0.0), speed, age: 0.0, ..VehicleState::default() };
        let slower = braking(tick, speed, way) * DT;
        way += speed * DT;
        speed = (speed - slower).max(0.0);
        here
    });
    states.collect()
}

fn judged(scenario: &Scenario, car: Vec<VehicleState>, walk: &Walk) -> Encountered {
    Recording::new(DT, car, walk.states.clone()).unwrap().judged_without_obstacles(scenario)
}

/// A careful human with faults: it sees a pedestrian only nearby and reacts later or brakes less.
#[derive(Debug, Clone, Copy)]
struct Human {
    speed: f64,
    wait: f64,
    full: f64,
    sight: f64,
}

impl Human {
    const CAREFUL: f64 = 1.15;
    const FULL: f64 = 0.774 * 9.81;

    fn careful(speed: f64) -> Self {
        Self { speed, wait: Self::CAREFUL, full: Self::FULL, sight: 200.0 }
    }

    /// Whether it notices a pedestrian in this tick: now, or when the tick ends.
    fn notices(&self, scenario: &Scenario, state: &PedestrianState, speed: f64, way: f64) -> bool {
        let (half, radius) = (scenario.cast.ego().blueprint.half_length, scenario.cast.pedestrian().body.radius);
        let reach = scenario.cast.ego().blueprint.half_width + radius;
        let human = DelayedBrake::new(Some(Gate::CAREFUL), BrakeProfile::careful_human(self.wait));
        let brake = scenario.cast.ego().blueprint.greatest_deceleration();
        let own = OwnMotion { speed, acceleration: 0.0, intended: 0.0, length: 2.0 * half, brake };
        [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].into_iter().any(|share| {
            let place = state.pose.position() + state.velocity * (share * DT);
            let (ahead, aside) = (place.x - way - speed * share * DT, place.y);
            let side = if aside > 0.0 { 1.0 } else { -1.0 };
            let threat = Threat {
                gap: ahead - radius - half,
                length: 2.0 * radius,
                offset: aside.abs(),
                reach,
                along: state.velocity.x,
                towards: -side * state.velocity.y,
            };
            ahead + radius > -half && threat.gap < self.sight && human.notices(&own, &threat)
        })
    }

    /// Its states in an encounter with a walk.
    fn drive(&self, scenario: &Scenario, walk: &Walk) -> Vec<VehicleState> {
        let mut noticed: Option<usize> = None;
        let profile = BrakeProfile { full: self.full, ..BrakeProfile::careful_human(self.wait) };
        let brake = scenario.cast.ego().blueprint.greatest_deceleration();
        drive(self.speed, walk.states.len(), |tick, speed, way| {
            if noticed.is_none() && self.notices(scenario, &walk.states[tick], speed, way) {
                noticed = Some(tick);
            }
            noticed.map_or(0.0, |noticed| profile.reached((tick - noticed + 1) as f64 * DT).min(brake))
        })
    }
}

fn stream(name: &str) -> Stream {
    Seed::root(34).child(name).stream()
}

fn scenario(town: &str, policy: &str) -> Arc<Scenario> {
    let text = format!(
        r#"edition 1
import "lib/paper.scn"
import "lib/pedestrians.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}
episode until_passed {{ ticks: 240  hold: 10  end_when: ahead < -6 m }}
campaign judged {{
  vehicle: model3  body: plausible  spawn: near  episode: until_passed
  evaluate {{ towns: [{town}] drivers: [{policy}] pedestrians: [random] episodes: 1 }}
}}"#
    );
    let root = crate::repository().join("scenarios/judged.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.expect("it is valid").campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

#[test]
fn drivers_that_brake_as_early_and_hard_as_the_careful_human_are_never_at_fault() {
    let scenario = scenario("harbour", "blind");
    let mut stream = stream("early");
    let mut touches = 0;
    let all = samples(2_000, 20_000);
    for number in 0..all {
        let speed = stream.random_range(5.0..60.0) / 3.6;
        let ticks = ((MEETING / speed + 2.0) / DT) as usize;
        let walk = any_walk(&mut stream, ticks, speed);
        let human = Human::careful(speed).drive(&scenario, &walk);
        let (earlier, harder) = (stream.random_range(0..20), stream.random_range(1.0..1.4));
        let braking = |tick: usize| (human[tick].speed - human[tick + 1].speed) / DT;
        let begins = (0..ticks - 1).find(|tick| braking(*tick) > 0.0).unwrap_or(ticks);
        let profile = BrakeProfile::careful_human(0.0);
        let car = drive(speed, ticks, |tick, _, _| {
            let since = (tick + earlier + 1) as f64 - begins as f64;
            if since > 0.0 { harder * profile.reached((since + 1.0) * DT) } else { 0.0 }
        });
        let found = judged(&scenario, car, &walk);
        let Some(verdict) = found.verdict else { continue };
        touches += 1;
        assert!(!verdict.is_fault(), "{number}: {earlier} ticks earlier, {harder} times as hard: {verdict:?}");
    }
    assert!(touches > all / 25, "only {touches} touches of {all}");
}

#[test]
fn the_careful_human_as_a_driver_under_test_has_no_fault() {
    let mut walkers: [(&str, Box<dyn WalkPolicy>); 4] = [
        ("intercept", Box::new(Intercept)),
        ("homing", Box::new(Homing)),
        ("random", Box::new(Random::default())),
        ("natural", Box::new(Natural::default())),
    ];
    let mut touches = 0;
    let all = samples(100, 400);
    for town in ["harbour", "village"] {
        let scenario = scenario(town, "careful_human");
        for (name, walker) in &mut walkers {
            let seed = Seed::root(1);
            let note = &mut |_: u32, _: &_, trace: &Trace| judge(&trace.main_pair(&scenario));
            let go_on = &mut |_: u32| ControlFlow::Continue(());
            let found =
                evaluate_observed(walker.as_mut(), &scenario, 0..all as u32, &seed, &seed.child(name), note, go_on);
            for (episode, verdict) in found.into_iter().enumerate() {
                let Some(verdict) = verdict else { continue };
                touches += 1;
                assert!(!verdict.is_fault(), "{town}, {name}, {episode}: {verdict:?}");
            }
        }
    }
    assert!(touches > all / 2, "only {touches} touches");
}

/// The states in another frame: mirrored at the axis of the lane, then turned and moved.
fn moved(car: &[VehicleState], walk: &Walk, mirror: f64, frame: &Pose) -> (Vec<VehicleState>, Walk) {
    let place = |pose: &Pose| {
        let there = frame.to_world(Vector::new(pose.x, mirror * pose.y));
        Pose::new(there.x, there.y, frame.yaw + mirror * pose.yaw)
    };
    let cars = car.iter().map(|state| VehicleState { pose: place(&state.pose), ..*state }).collect();
    let turned = |velocity: &Vector| frame.to_world(Vector::new(velocity.x, mirror * velocity.y)) - frame.position();
    let states = walk.states.iter();
    let states =
        states.map(|state| PedestrianState { pose: place(&state.pose), velocity: turned(&state.velocity), ..*state });
    (cars, Walk { states: states.collect() })
}

/// The states with as many ticks before them, in which both keep their first velocity.
fn delayed(car: &[VehicleState], walk: &Walk, ticks: usize) -> (Vec<VehicleState>, Walk) {
    let back = (1..=ticks).rev().map(|tick| tick as f64 * DT);
    let cars = back.clone().map(|time| {
        let pose = car[0].pose;
        VehicleState { pose: Pose::new(pose.x - car[0].speed * time, pose.y, pose.yaw), ..car[0] }
    });
    let first = walk.states[0];
    let walkers = back.map(|time| {
        let pose = first.pose;
        let place = Pose::new(pose.x - first.velocity.x * time, pose.y - first.velocity.y * time, pose.yaw);
        PedestrianState { pose: place, ..first }
    });
    let states = walkers.chain(walk.states.iter().copied()).collect();
    (cars.chain(car.iter().copied()).collect(), Walk { states })
}

#[test]
fn mirroring_shifting_and_delaying_a_scene_changes_nothing() {
    let scenario = scenario("harbour", "blind");
    let mut stream = stream("moved");
    let mut faults = [0, 0];
    let all = samples(300, 1500);
    for number in 0..all {
        let speed = stream.random_range(5.0..60.0) / 3.6;
        let ticks = ((MEETING / speed + 2.0) / DT) as usize;
        let walk = any_walk(&mut stream, ticks, speed);
        let human = Human { wait: stream.random_range(1.15..4.0), ..Human::careful(speed) };
        let car = human.drive(&scenario, &walk);
        let Some(verdict) = judged(&scenario, car.clone(), &walk).verdict else { continue };
        // A disc that is as near as rounding to a limit may be on either side of it.
        let margins = verdict.trials.map(|trial| trial.least_gap);
        if margins.iter().any(|margin| (margin - 0.1).abs() < 1e-3 || *margin < 1e-3 && *margin > 0.0) {
            continue;
        }
        faults[usize::from(verdict.is_fault())] += 1;
        let away = Pose::new(stream.random_range(-500.0..500.0), 300.0, stream.random_range(-3.0..3.0));
        let same = |(car, walk): (Vec<VehicleState>, Walk), what: &str| {
            let found = judged(&scenario, car, &walk).verdict;
            let class = found.as_ref().map(Verdict::class);
            assert_eq!(class, Some(verdict.class()), "{number}, {what}: {verdict:?}, {found:?}");
        };
        same(moved(&car, &walk, -1.0, &Pose::new(0.0, 0.0, 0.0)), "mirrored");
        same(moved(&car, &walk, 1.0, &away), "moved");
        same(delayed(&car, &walk, 40), "delayed");
    }
    assert!(faults.iter().all(|count| *count > all / 15), "{faults:?}");
}

/// Seconds until the car's middle is where the pedestrian crosses.
const ARRIVAL: f64 = 7.0;

/// One pedestrian who walks steadily across, in view and under way for three seconds or more when the car arrives, from either side.
fn crossing(stream: &mut Stream, ticks: usize) -> Walk {
    let (pace, side) = (stream.random_range(0.7..2.0), if stream.random_range(0..2) == 0 { 1.0 } else { -1.0 });
    let slant: f64 = stream.random_range(-0.4..0.4);
    let velocity = Vector::new(libm::sin(slant), -side * libm::cos(slant)) * pace;
    let arrival = (ARRIVAL / DT) as usize;
    let sets_off = arrival - (stream.random_range(3.5..6.0) / DT) as usize;
    let aside = stream.random_range(-3.0..3.0);
    let at = Point::new(MEETING + stream.random_range(0.0..3.0), aside);
    walk(&[(0, Vector::zeros()), (sets_off, velocity)], ticks, arrival, at, 1.5)
}

/// The numbers of faults and touches of a driver in the crossings.
fn faults(scenario: &Scenario, crossings: &[Walk], human: Human) -> usize {
    let count = |walk: &Walk| {
        // The same pedestrian at the same time, whatever the car's speed.
        let shift = Vector::new(human.speed * ARRIVAL - MEETING, 0.0);
        let frame = Pose::new(shift.x, shift.y, 0.0);
        let (_, walk) = moved(&[], walk, 1.0, &frame);
        let car = human.drive(scenario, &walk);
        let near = |(car, walker): (&VehicleState, &PedestrianState)| {
            (car.pose.position() - walker.pose.position()).norm() < 4.0
        };
        let meets = car.iter().zip(&walk.states).any(near);
        meets && judged(scenario, car, &walk).verdict.is_some_and(|verdict| verdict.is_fault())
    };
    crossings.par_iter().filter(|walk| count(walk)).count()
}

#[test]
fn a_driver_that_is_made_worse_has_no_fewer_faults() {
    let scenario = scenario("harbour", "blind");
    let mut stream = stream("crossings");
    let ticks = ((ARRIVAL + 2.5) / DT) as usize;
    let crossings: Vec<Walk> = (0..samples(1_000, 10_000)).map(|_| crossing(&mut stream, ticks)).collect();
    let n = crossings.len() as f64;
    // A count may be smaller by what chance makes of two of them (95 %).
    let slack = |a: usize, b: usize| 1.96 * ((a + b) as f64 * (1.0 - (a + b) as f64 / (2.0 * n))).sqrt();
    let rises = |counts: &[usize], what: &str| {
        for pair in counts.windows(2) {
            assert!(pair[1] as f64 >= pair[0] as f64 - slack(pair[0], pair[1]), "{what}: {counts:?}");
        }
    };
    let mut table = Vec::new();
    for kmh in [20.0, 40.0, 60.0] {
        let careful = Human::careful(kmh / 3.6);
        let of = |human| faults(&scenario, &crossings, human);
        let none = of(careful);
        let blind = of(Human { sight: -100.0, ..careful });
        let late = [1.9, 2.5].map(|wait| of(Human { wait, ..careful }));
        let weak = [5.0, 3.0].map(|full| of(Human { full, ..careful }));
        let narrow = [30.0, 10.0].map(|sight| of(Human { sight, ..careful }));
        for (worse, what) in [(late, "later"), (weak, "weaker"), (narrow, "less sight")] {
            rises(&[&[none], &worse[..], &[blind]].concat(), &format!("{kmh} km/h, {what}"));
        }
        assert_eq!(none, 0, "{kmh} km/h");
        table.push([late[0], weak[0], narrow[0], blind]);
    }
    for column in 0..4 {
        rises(&table.iter().map(|row| row[column]).collect::<Vec<usize>>(), "faster");
    }
}
