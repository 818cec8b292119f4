//! Causes of failures whose defect is known: it was planted in a driver that is otherwise as it was, and that avoids the same encounters without it.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::{Seed, Stream};
use compile::{Catalog, ControllerKind, Plan, compile};
use world::av::{Actor, DrivingMode, DrivingPolicy, Perception, Weakness};
use world::cause::{Incident, Reruns, explain};
use world::env::{Criterion, DriverParts, Outcome, Scenario, Trace};
use world::falsifier::{evaluate_observed, recorded_commands};
use world::geometry::Vector;
use world::judge::{Blame, Judged};
use world::sim::Control;

use crate::samples::samples;

/// The drivers, in the order of the evaluations of [`plan`].
const DRIVERS: [&str; 6] = ["idm()", "predictive()", "aeb()", "rss_guarded()", "behavior_agent()", "lav()"];

/// A defect of a driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Defect {
    /// Its commands take effect 0.6 s later.
    Delay,
    /// It sees nobody to its right.
    BlindSide,
    /// It sees nobody farther than 9 m from its middle.
    Range,
    /// It sees nobody in every second half second.
    Dropouts,
    /// It sees nobody beside its own width.
    Corridor,
    /// It takes people for standing ones.
    NoAnticipation,
    /// It takes its speed for half of what it is.
    StoppingDistance,
    /// It brakes with a third of the force that it means.
    WeakBrake,
    /// It lets go of the brake after half a second, for a second.
    LetsGo,
    /// An exception is swallowed: it sees nobody.
    Ignores,
    /// Held out: once the car has lost a third of its speed it lets go of the brake, and brakes no more for 1.5 s.
    Hysteresis,
    /// Held out: its tracker loses people for half a second, again and again, at times that differ from start to start.
    Tracker,
    /// Held out: an exception in the planner is swallowed if somebody is within 20 m, and the pedals stay as they were.
    Stale,
}

impl Defect {
    /// Defects that were planted after the rules were frozen.
    const HELD_OUT: [Self; 3] = [Self::Hysteresis, Self::Tracker, Self::Stale];

    const ALL: [Self; 10] = [
        Self::Delay,
        Self::BlindSide,
        Self::Range,
        Self::Dropouts,
        Self::Corridor,
        Self::NoAnticipation,
        Self::StoppingDistance,
        Self::WeakBrake,
        Self::LetsGo,
        Self::Ignores,
    ];

    /// The weakness that names it.
    fn weakness(self) -> Weakness {
        match self {
            Self::Delay => Weakness::Delay,
            Self::BlindSide => Weakness::BlindSide,
            Self::Range => Weakness::Range,
            Self::Dropouts | Self::Tracker => Weakness::Dropouts,
            Self::Corridor => Weakness::Corridor,
            Self::NoAnticipation => Weakness::Anticipation,
            Self::StoppingDistance => Weakness::Distance,
            Self::WeakBrake => Weakness::WeakBrake,
            Self::LetsGo | Self::Hysteresis => Weakness::LetsGo,
            Self::Ignores | Self::Stale => Weakness::Ignores,
        }
    }
}

/// A driver with a defect.
struct Defective {
    driver: Box<dyn DrivingPolicy>,
    defect: Defect,
    tick: u32,
    braked: u32,
    waiting: Vec<Control>,
    seen: Vec<Actor>,
    /// Speed when it began to brake (m/s).
    before: f64,
    /// A number of its start.
    phase: u32,
}

impl Defective {
    fn look(&mut self, perception: &Perception<'_>) -> Vector {
        let (defect, tick, phase, ego) = (self.defect, self.tick, self.phase, &perception.ego);
        let mut slower = ego.velocity;
        if defect == Defect::StoppingDistance {
            slower /= 2.0;
        }
        let sees = |actor: &&Actor| {
            let local = ego.pose.to_local(actor.pose.position());
            match defect {
                Defect::Ignores => false,
                Defect::BlindSide => local.y > -0.5,
                Defect::Range => local.norm() < 9.0,
                Defect::Dropouts => (tick / 10).is_multiple_of(2),
                Defect::Tracker => (tick + phase) % (17 + phase % 7) < 7 + phase % 5,
                Defect::Corridor => local.y.abs() < ego.half.y,
                _ => true,
            }
        };
        self.seen.clear();
        self.seen.extend(perception.pedestrians.iter().filter(sees));
        if defect == Defect::NoAnticipation {
            self.seen.iter_mut().for_each(|actor| actor.velocity = Vector::zeros());
        }
        slower
    }
}

impl DrivingPolicy for Defective {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        (self.tick, self.braked, self.before) = (0, 0, 0.0);
        self.phase = (perception.ego.pose.x.abs() * 100.0) as u32 % 1000;
        self.waiting = vec![Control::default(); if self.defect == Defect::Delay { 12 } else { 0 }];
        let velocity = self.look(perception);
        let ego = Actor { velocity, ..perception.ego };
        self.driver.reset(&Perception { pedestrians: &self.seen, ego, ..*perception }, stream);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let velocity = if perception.pedestrians.is_empty() { perception.ego.velocity } else { self.look(perception) };
        let ego = Actor { velocity, ..perception.ego };
        let mut control = self.driver.drive(&Perception { pedestrians: &self.seen, ego, ..*perception });
        self.tick += 1;
        match self.defect {
            Defect::Delay => {
                self.waiting.push(control);
                control = self.waiting.remove(0);
            }
            Defect::WeakBrake => control.brake /= 3.0,
            Defect::LetsGo => {
                self.braked = if control.brake > 0.02 || self.braked > 10 { self.braked + 1 } else { 0 };
                if self.braked > 10 {
                    control.brake = 0.0;
                }
                if self.braked > 30 {
                    self.braked = 0;
                }
            }
            Defect::Hysteresis => {
                let speed = perception.ego.speed();
                self.before = if control.brake > 0.1 { self.before.max(speed) } else { 0.0 };
                self.braked = if speed < self.before * 2.0 / 3.0 { 30 } else { self.braked.saturating_sub(1) };
                if self.braked > 0 && speed > 1.0 {
                    (control.brake, self.before) = (0.0, 0.0);
                }
            }
            Defect::Stale => {
                let near = |actor: &Actor| (actor.pose.position() - perception.ego.pose.position()).norm() < 20.0;
                let last = self.waiting.pop().filter(|_| perception.pedestrians.iter().any(near));
                control = last.map_or(control, |last| Control { steer: control.steer, ..last });
                self.waiting.push(control);
            }
            _ => {}
        }
        control
    }

    fn mode(&self) -> DrivingMode {
        self.driver.mode()
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        let (driver, waiting, seen) = (self.driver.snapshot()?, self.waiting.clone(), self.seen.clone());
        Some(Box::new(Self { driver, waiting, seen, ..*self }))
    }
}

/// Each driver meets pedestrians that intercept it.
fn plan() -> Plan {
    let names: Vec<String> = (0..DRIVERS.len()).map(|number| format!("driver_{number}")).collect();
    let policies: String =
        names.iter().zip(DRIVERS).map(|(name, driver)| format!("policy {name} = {driver}\n")).collect();
    let text = format!(
        "edition 1\nimport \"lib/pedestrians.scn\"\nimport \"lib/drivers.scn\"\nimport \"lib/towns.scn\"\n{policies}\
         spawn ahead {{ bearing: -40 deg .. 40 deg distance: 12 m .. 40 m }}\n\
         episode short {{ tick: 0.05 s hold: 20 ticks: 240 end_when: ahead < -6 m }}\n\
         campaign c {{ vehicle: model3 adversary: pursuer spawn: ahead episode: short\n\
         evaluate {{ towns: [village] policies: [{}] pedestrians: [intercept] episodes: 1 }} }}",
        names.join(", ")
    );
    let root = crate::repository().join("scenarios/test_of_causes.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

/// Preventable collisions of a driver with a defect, at starts where it avoids the same commands without the defect.
fn incidents(evaluation: &compile::Evaluation, defect: Defect, episodes: u32) -> Vec<Incident> {
    let sound = &evaluation.scenario;
    let mut planted = Scenario::clone(sound);
    let make = sound.cast.ego().policy.clone();
    planted.cast.vehicles[0].parts = Arc::new(DriverParts::default());
    planted.cast.vehicles[0].policy = Arc::new(move || {
        let (waiting, seen) = (Vec::new(), Vec::new());
        Box::new(Defective { driver: make(), defect, tick: 0, braked: 0, waiting, seen, before: 0.0, phase: 0 })
    });
    let planted = Arc::new(planted);
    let ControllerKind::Untrained(controller) = &evaluation.controller else { panic!("it is not trained") };
    // Rules were chosen on seed 8.
    let seed = Seed::root(samples(8, 9) as u64);
    let mut found = Vec::new();
    let mut note = |start: u32, outcome: &Outcome, trace: &Trace| {
        let judged = Judged::by(Criterion::Collision, outcome, &trace.main_pair(&planted));
        if outcome.counts() && judged.is(Criterion::Collision, Blame::Preventable) {
            found.push((u64::from(start), recorded_commands(trace)));
        }
    };
    let mut walker = controller.walk_policy();
    evaluate_observed(&mut *walker, &planted, 0..episodes, &seed, &seed, &mut note, &mut |_| ControlFlow::Continue(()));
    let incident = |(start, commands)| Incident {
        scenario: planted.clone(),
        seed,
        start,
        commands,
        criterion: Criterion::Collision,
    };
    let is_due_to_it = |incident: &Incident| {
        let mut reruns = Reruns::with(incident, sound.clone());
        reruns.run(&incident.commands).is_some_and(|rerun| rerun.outcome.counts() && !rerun.outcome.is_collision())
    };
    found.into_iter().map(incident).filter(is_due_to_it).collect()
}

/// The number of incidents of each defect, and of each weakness that was named for it.
type Confusion = BTreeMap<Defect, BTreeMap<Weakness, u32>>;

fn confusion(defects: &[Defect], drivers: usize, episodes: u32) -> Confusion {
    let plan = plan();
    let mut table = Confusion::new();
    for evaluation in plan.campaigns[0].all::<compile::Evaluation>().take(drivers) {
        for defect in defects {
            let mut named: BTreeMap<Weakness, u32> = BTreeMap::new();
            for incident in incidents(evaluation, *defect, episodes) {
                let cause = explain(&incident, true).expect("it fails again");
                if cause.weakness != defect.weakness() && std::env::var_os("FALSIFY_PRINT_CAUSES").is_some() {
                    let (driver, start) = (&evaluation.policy, incident.start);
                    loud!("{driver} {defect:?}, start {start}: {} {:?}", cause.weakness.name(), cause);
                }
                *table.entry(*defect).or_default().entry(cause.weakness).or_default() += 1;
                *named.entry(cause.weakness).or_default() += 1u32;
            }
            if std::env::var_os("FALSIFY_PRINT_CAUSES").is_some() {
                loud!("{} {defect:?}: {named:?}", evaluation.policy);
            }
        }
    }
    table
}

/// The share of incidents whose defect is named, and their number.
fn named(table: &Confusion) -> (f64, u32) {
    let (mut right, mut all) = (0, 0);
    for (defect, causes) in table {
        let words: Vec<String> = causes.iter().map(|(cause, count)| format!("{} {count}", cause.name())).collect();
        loud!("{defect:?}: {}", words.join(", "));
        all += causes.values().sum::<u32>();
        right += causes.get(&defect.weakness()).copied().unwrap_or(0);
    }
    (f64::from(right) / f64::from(all.max(1)), all)
}

#[test]
fn planted_defects_are_named() {
    assert_named(&Defect::ALL, 1900, 0.9);
}

#[test]
fn defects_that_were_planted_later_are_named() {
    assert_named(&Defect::HELD_OUT, 600, 0.5);
}

fn assert_named(defects: &[Defect], episodes: usize, least: f64) {
    let table = confusion(defects, samples(2, DRIVERS.len()), samples(8, episodes) as u32);
    let (share, all) = named(&table);
    let right = (share * f64::from(all)).round() as u64;
    let (low, high) = base::statistics::wilson(right, u64::from(all));
    loud!("{:.1} % ({:.1} to {:.1} %) of {all} named", 100.0 * share, 100.0 * low, 100.0 * high);
    assert!(share >= least, "{share}");
}
