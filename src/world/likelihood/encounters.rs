use std::sync::Arc;

use super::{Encounter, Event, Events};
use crate::env::{Outcome, PedestrianEnv, Scenario, Trace};
use crate::falsifier::WalkPolicy;
use crate::judge::{ViolationVerdict, judge};
use crate::requirement::Degree;
use crate::sim::WalkCommand;
use base::seed::Seed;

/// What is asked about encounters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Collisions.
    Collision,
    /// Violations of the requirement in this place of the scenario's.
    Requirement(usize),
}

/// Encounters of a scenario's driver and a walker in our simulator.
pub struct Encounters {
    env: PedestrianEnv,
    walker: Box<dyn WalkPolicy>,
    question: Question,
    commands: Vec<WalkCommand>,
    trace: Trace,
}

impl Encounters {
    pub fn new(scenario: &Arc<Scenario>, walker: Box<dyn WalkPolicy>, question: Question) -> Self {
        let env = PedestrianEnv::new(scenario.clone(), Seed::root(0));
        let commands = vec![WalkCommand::default(); scenario.cast.pedestrian_count()];
        Self { trace: Trace::new(scenario), env, walker, question, commands }
    }

    /// Runs the encounter with a number and a seed. The number chooses the cell if the spawn rule goes through cells in turn.
    pub fn run(&mut self, number: u64, seed: &Seed) -> Encounter {
        self.begin(number, seed);
        let mut ticks = u64::from(self.env.run_up_ticks());
        while self.env.outcome().is_none() {
            if self.choose() {
                self.env.carry_out(&self.commands);
            }
        }
        ticks += u64::from(self.env.world().ticks);
        let counts = self.env.outcome().is_some_and(Outcome::counts);
        let mut events = [false; Event::COUNT];
        if counts && self.has_failed() {
            events = self.judge(number, seed);
            ticks += u64::from(self.env.run_up_ticks()) + u64::from(self.env.world().ticks);
        }
        Encounter { counts, events, ticks }
    }

    fn begin(&mut self, number: u64, seed: &Seed) {
        self.env.begin_drawn(number, seed.child("start").wide_stream(), seed.child("drivers"));
        self.walker.begin(seed.child("walk").wide_stream());
    }

    /// Lets the walker choose; false if it failed as a program, which ends the encounter.
    fn choose(&mut self) -> bool {
        self.walker.choose(&self.env.scene(), &mut self.commands);
        match self.walker.fault() {
            Some(fault) => self.env.abandon(fault),
            None => return true,
        }
        false
    }

    fn has_failed(&self) -> bool {
        match self.question {
            Question::Collision => self.env.outcome().is_some_and(Outcome::is_collision),
            Question::Requirement(place) => self.env.degrees().get(place).is_some_and(Degree::is_violated),
        }
    }

    /// Repeats the encounter with a trace and judges it.
    fn judge(&mut self, number: u64, seed: &Seed) -> Events {
        self.begin(number, seed);
        let mut trace = std::mem::replace(&mut self.trace, Trace::new(self.env.scenario()));
        trace.begin(self.env.world());
        while self.env.outcome().is_none() {
            if self.choose() {
                trace.watch_decision(&mut self.env, &self.commands);
            }
        }
        let mut events = [false; Event::COUNT];
        // A driver that is not deterministic may not fail again.
        if self.env.outcome().is_some_and(Outcome::counts) && self.has_failed() {
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
}
