use std::sync::Arc;

use super::Encounter;
use crate::env::{Criterion, Outcome, PedestrianEnv, Scenario, Trace};
use crate::falsifier::WalkPolicy;
use crate::judge::{Blame, Judged};
use crate::sim::WalkCommand;
use base::seed::Seed;

/// Encounters of a scenario's driver and a walker in our simulator.
pub struct Encounters {
    env: PedestrianEnv,
    walker: Box<dyn WalkPolicy>,
    criterion: Criterion,
    commands: Vec<WalkCommand>,
    trace: Trace,
}

impl Encounters {
    pub fn new(scenario: &Arc<Scenario>, walker: Box<dyn WalkPolicy>, criterion: Criterion) -> Self {
        let env = PedestrianEnv::new(scenario.clone(), Seed::root(0));
        let commands = vec![WalkCommand::default(); scenario.cast.pedestrian_count()];
        Self { trace: Trace::new(scenario), env, walker, criterion, commands }
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
        let mut events = [false; Blame::COUNT];
        if self.has_failed() {
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

    /// Whether it counts and is a failure.
    fn has_failed(&self) -> bool {
        self.env.outcome().is_some_and(|outcome| outcome.counts() && self.criterion.is_met(outcome, self.env.degrees()))
    }

    /// Repeats the encounter with a trace and judges it.
    fn judge(&mut self, number: u64, seed: &Seed) -> [bool; Blame::COUNT] {
        self.begin(number, seed);
        self.trace.begin(self.env.world());
        while self.env.outcome().is_none() {
            if self.choose() {
                self.trace.watch_decision(&mut self.env, &self.commands);
            }
        }
        // A driver that is not deterministic may not fail again.
        let outcome = self.env.outcome().filter(|_| self.has_failed());
        outcome.map_or([false; Blame::COUNT], |outcome| {
            Judged::by(self.criterion, outcome, &self.trace.main_pair(self.env.scenario())).blames(self.criterion)
        })
    }
}
