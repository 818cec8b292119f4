use std::sync::Arc;

use super::Encounter;
use base::seed::Seed;
use episode::walker::WalkPolicy;
use episode::{Criterion, Draw, Observer, Outcome, Scenario, Simulation, Trace, place, play};
use verdict::{Blame, Judged};

/// Encounters of a scenario's driver and a walker.
pub struct Encounters {
    simulation: Box<dyn Simulation>,
    walker: Box<dyn WalkPolicy>,
    criterion: Criterion,
    trace: Trace,
}

impl Encounters {
    pub fn new(scenario: &Arc<Scenario>, walker: Box<dyn WalkPolicy>, criterion: Criterion) -> Self {
        Self { simulation: scenario.simulation(), walker, criterion, trace: Trace::new(scenario) }
    }

    /// Runs the encounter with a number and a seed. The number chooses the cell if the spawn rule goes through cells in turn.
    pub fn run(&mut self, number: u64, seed: &Seed) -> Encounter {
        let mut ticks = encounter(&mut *self.simulation, self.walker.as_mut(), (number, seed), &mut ());
        let counts = self.simulation.outcome().is_some_and(Outcome::counts);
        let mut events = [false; Blame::COUNT];
        if self.failed().is_some() {
            ticks += encounter(&mut *self.simulation, self.walker.as_mut(), (number, seed), &mut self.trace);
            // A driver that is not deterministic may not fail again.
            if let Some(outcome) = self.failed() {
                let pair = self.trace.main_pair(self.simulation.scenario());
                events = Judged::by(self.criterion, outcome, &pair).blames(self.criterion);
            }
        }
        Encounter { counts, events, ticks }
    }

    /// The outcome of the last encounter if it counts and is a failure.
    fn failed(&self) -> Option<&Outcome> {
        let is_failure =
            |outcome: &&Outcome| outcome.counts() && self.criterion.is_met(outcome, self.simulation.degrees());
        self.simulation.outcome().filter(is_failure)
    }
}

/// Plays an encounter; returns its ticks.
fn encounter(
    simulation: &mut dyn Simulation,
    walker: &mut dyn WalkPolicy,
    (number, seed): (u64, &Seed),
    observer: &mut dyn Observer,
) -> u64 {
    walker.begin(seed.child("walk").wide_stream());
    let draw = Draw { number, start: seed.child("start").wide_stream(), drivers: seed.child("drivers") };
    place(simulation, draw, observer);
    play(simulation, walker, observer);
    u64::from(simulation.run_up_ticks()) + u64::from(simulation.scene().world.ticks)
}
