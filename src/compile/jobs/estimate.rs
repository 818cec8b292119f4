use std::fmt;
use std::sync::Arc;

use super::{Job, Planned};
use crate::{Fingerprint, Programs, RunId};
use base::seed::Seed;
use world::env::{Criterion, Scenario};
use world::falsifier::Controller;
use world::judge::Blame;

/// The names that distinguish an estimate from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct EstimationKey {
    /// Its short name.
    pub id: RunId,
    /// Name of the pedestrian.
    pub walker: String,
    /// The requirement whose violations are estimated; empty for collisions.
    pub requirement: String,
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Number of the `estimate` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

/// `natural in harbour against idm, run 0`.
impl fmt::Display for EstimationKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { walker, town, policy, run, .. } = self;
        write!(f, "{walker} in {town} against {policy}, run {run}")
    }
}

/// An estimate of how likely failures of a driver are in a town.
#[derive(Debug, Clone)]
pub struct Estimation {
    /// Its names.
    pub key: EstimationKey,
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
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

impl Estimation {
    /// The seed of what it draws. Equal pedestrians have equal starts against all drivers.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        let key = &self.key;
        let place = seed.child("estimate").child(&key.town).child(&key.walker);
        place.child("monte_carlo").index(key.block.into()).index(key.run.into())
    }
}

impl Planned for Estimation {
    fn run_number(&self) -> u32 {
        self.key.run
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.key.town, &self.scenario)]
    }

    fn programs(&self) -> &Programs {
        &self.programs
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn units(&self, _: u32) -> u64 {
        self.budget
    }

    fn inputs(&self) -> String {
        let Self { key, event, relative_error, budget, fingerprint, .. } = self;
        let EstimationKey { walker, town, policy, block, run, .. } = key;
        format!(
            "estimate {walker:?} {town:?} {policy:?} {block} {run} {} {relative_error:?} {budget} {fingerprint}",
            event.name()
        )
    }

    fn shorten(&mut self) {
        let episode = self.scenario.episode.ticks + self.scenario.most_run_up();
        self.budget = self.budget.min(10 * u64::from(episode));
    }

    fn names(&self, _: &[Job]) -> Option<Vec<String>> {
        let Self { key, fingerprint, budget, .. } = self;
        let EstimationKey { block, walker, requirement, town, policy, run, .. } = key;
        let all: [&dyn ToString; 9] = [&"estimate", block, walker, requirement, town, policy, run, fingerprint, budget];
        Some(all.map(ToString::to_string).into())
    }

    fn id(&self) -> Option<RunId> {
        Some(self.key.id)
    }

    fn id_mut(&mut self) -> Option<&mut RunId> {
        Some(&mut self.key.id)
    }
}
