use std::sync::Arc;

use super::{Event, Events, Lot, TestBed, Trial};
use crate::env::{Ending, PedestrianEnv, Scenario, Trace};
use crate::falsifier::WalkPolicy;
use crate::judge::{ViolationVerdict, judge};
use crate::requirement::Degree;
use crate::sim::WalkCommand;
use base::seed::Seed;

/// What is asked about encounters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Collisions; the level is [`PedestrianEnv::nearness`], with a minus sign (m).
    Collision,
    /// Violations of the requirement in this place of the scenario's; the level is its robustness, with a minus sign.
    Requirement(usize),
}

/// Encounters of a scenario's driver and a walker in our simulator.
pub struct Encounters {
    env: PedestrianEnv,
    walker: Box<dyn WalkPolicy>,
    question: Question,
    commands: Vec<WalkCommand>,
    trace: Trace,
    decision: usize,
    ticks: u64,
    /// Driver or walker failed as a program in this many encounters in a row.
    failed: usize,
}

/// An encounter before a decision.
pub struct Mark {
    env: PedestrianEnv,
    walker: Box<dyn WalkPolicy>,
    decision: usize,
}

/// The level of an encounter that nearly failed, so that it is below that of a failure.
const NEARLY: f64 = -1e-9;

impl Encounters {
    /// The walker must not have been in an episode yet.
    pub fn new(scenario: &Arc<Scenario>, walker: Box<dyn WalkPolicy>, question: Question) -> Self {
        let env = PedestrianEnv::new(scenario.clone(), Seed::root(0));
        let commands = vec![WalkCommand::default(); scenario.cast.pedestrian_count()];
        Self { trace: Trace::new(scenario), env, walker, question, commands, decision: 0, ticks: 0, failed: 0 }
    }

    /// The number of encounters in a row in which driver or walker failed as a program.
    pub fn failed_in_a_row(&self) -> usize {
        self.failed
    }

    /// Lets the walker choose; whether it failed as a program.
    fn choose(&mut self, lot: &mut Lot) -> bool {
        if let Some(drivers) = lot.turn(self.decision) {
            self.env.reseed(drivers);
        }
        lot.before.push(lot.walk.drawn());
        self.decision += 1;
        self.walker.choose(&self.env.scene(), &mut self.commands);
        if let Some(fault) = self.walker.fault() {
            self.env.abandon(fault);
            return true;
        }
        false
    }

    /// The degree of the requirement that is asked about, once the encounter is over.
    fn degree(&self) -> Option<&Degree> {
        match self.question {
            Question::Collision => None,
            Question::Requirement(place) => self.env.degrees().get(place),
        }
    }
}

impl TestBed for Encounters {
    type Mark = Mark;

    fn begin(&mut self, lot: &mut Lot) {
        self.env.begin_drawn(lot.number, lot.start.stream(0), lot.drivers);
        self.ticks += u64::from(self.env.run_up_ticks());
        self.walker.begin(lot.walk.stream(0));
        lot.before.clear();
        self.decision = 0;
    }

    fn step(&mut self, lot: &mut Lot) -> bool {
        let before = self.env.world().ticks;
        if !self.choose(lot) {
            self.env.carry_out(&self.commands);
            self.ticks += u64::from(self.env.world().ticks - before);
        }
        self.env.outcome().is_none()
    }

    fn level(&self) -> f64 {
        match (self.question, self.env.outcome()) {
            (Question::Collision, Some(outcome)) if outcome.is_collision() => 0.0,
            // A touch of the standing car is no failure.
            (Question::Collision, _) => (-self.env.nearness()).min(NEARLY),
            // The robustness is known at the end.
            (Question::Requirement(_), _) => match self.degree() {
                Some(degree) if degree.is_violated() => 0.0,
                Some(degree) => (-degree.robustness).min(NEARLY),
                None => f64::NEG_INFINITY,
            },
        }
    }

    fn trial(&mut self) -> Trial {
        let outcome = self.env.outcome().expect("the encounter is over");
        let in_error = matches!(outcome.ending, Ending::Error(_) | Ending::ControllerError(_));
        self.failed = if in_error { self.failed + 1 } else { 0 };
        Trial { level: self.level(), counts: outcome.counts() }
    }

    fn mark(&self) -> Option<Mark> {
        Some(Mark { env: self.env.snapshot()?, walker: self.walker.snapshot()?, decision: self.decision })
    }

    fn restore(&mut self, mark: &Mark, lot: &mut Lot) {
        let copies = (mark.env.snapshot(), mark.walker.snapshot());
        let (Some(env), Some(walker)) = copies else { unreachable!("a copy can be copied") };
        (self.env, self.walker, self.decision) = (env, walker, mark.decision);
        let from = lot.before.get(mark.decision).copied().unwrap_or(0);
        self.walker.reseed(lot.walk.stream(from));
        lot.before.truncate(mark.decision);
    }

    fn judge(&mut self, lot: &mut Lot) -> Events {
        self.begin(lot);
        let mut trace = std::mem::replace(&mut self.trace, Trace::new(self.env.scenario()));
        trace.begin(self.env.world());
        while self.env.outcome().is_none() {
            if !self.choose(lot) {
                trace.watch_decision(&mut self.env, &self.commands);
            }
        }
        self.ticks += u64::from(self.env.world().ticks);
        let mut events = [false; Event::COUNT];
        if self.trial().fails() {
            let scenario = self.env.scenario();
            let pair = trace.main_pair(scenario);
            let (preventable, fault) = match self.question {
                Question::Collision => {
                    judge(&pair).map_or((false, false), |verdict| (verdict.is_preventable(), verdict.is_fault()))
                }
                Question::Requirement(place) => {
                    let verdict = self.env.degrees().get(place).and_then(|degree| {
                        ViolationVerdict::new(&pair, &scenario.requirements[place].requirement, degree)
                    });
                    verdict.map_or((false, false), |verdict| (verdict.preventable, verdict.fault))
                }
            };
            events = [true, preventable, fault];
        }
        self.trace = trace;
        events
    }

    fn ticks(&self) -> u64 {
        self.ticks
    }
}
