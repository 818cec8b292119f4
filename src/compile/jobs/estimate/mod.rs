mod block;

use std::sync::Arc;

use super::{Origin, Planned};
use base::seed::Seed;
pub(super) use block::BLOCK;
use episode::walker::Controller;
use episode::{Criterion, Scenario};
use verdict::Blame;

/// An estimate of how likely failures of a driver are in a town.
#[derive(Debug, Clone)]
pub struct Estimation {
    pub origin: Origin,
    pub pedestrian: String,
    /// The requirement whose violations are estimated; empty for collisions.
    pub requirement: String,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    pub scenario: Arc<Scenario>,
    /// The pedestrian.
    pub walker: Controller,
    pub criterion: Criterion,
    /// What the relative error is about.
    pub event: Blame,
    pub relative_error: f64,
    /// The number of simulator ticks after which it ends.
    pub budget: u64,
    /// Encounters per hour and per 1,000 km, as far as the user states them.
    pub exposure: [Option<f64>; 2],
}

impl Estimation {
    /// The seed of what it draws. Equal pedestrians have equal starts against all drivers.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        let place = seed.child("estimate").child(&self.town).child(&self.pedestrian);
        place.child("monte_carlo").index(self.origin.block.into()).index(self.origin.run.into())
    }
}

impl Planned for Estimation {
    /// `natural in harbour against idm, run 0`.
    fn title(&self) -> String {
        let Self { pedestrian, town, policy, origin, .. } = self;
        format!("{pedestrian} in {town} against {policy}, run {}", origin.run)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.town, &self.scenario)]
    }

    fn units(&self, _: u32) -> u64 {
        self.budget
    }

    fn inputs(&self) -> String {
        format!("{:?} {} {:?}", self.names(None), self.event.name(), self.relative_error)
    }

    fn shorten(&mut self) {
        self.budget = self.budget.min(10 * self.scenario.longest());
    }

    fn names(&self, _: Option<&dyn Planned>) -> Vec<String> {
        let Self { origin, pedestrian, requirement, town, policy, budget, .. } = self;
        let Origin { block, run, fingerprint, .. } = origin;
        let all: [&dyn ToString; 9] =
            [&"estimate", block, pedestrian, requirement, town, policy, run, fingerprint, budget];
        all.map(ToString::to_string).into()
    }
}
