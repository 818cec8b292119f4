use std::fmt;
use std::sync::Arc;

use super::{Job, Planned};
use crate::{Fingerprint, Programs, RunId};
use base::seed::Seed;
use world::env::{Criterion, Scenario};
use world::falsifier::Controller;
use world::judge::Blame;

/// The names that distinguish a cover from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct CoverKey {
    /// Its short name.
    pub id: RunId,
    /// Name of the pedestrian that walks.
    pub pedestrian: String,
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Name of the spawn rule.
    pub spawn: String,
    /// Number of the `cover` block in its campaign, from 0.
    pub block: u32,
}

/// `near by natural in harbour against idm`.
impl fmt::Display for CoverKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} by {} in {} against {}", self.spawn, self.pedestrian, self.town, self.policy)
    }
}

/// One box of starts of one policy in one town.
#[derive(Debug, Clone)]
pub struct Cover {
    /// Its names.
    pub key: CoverKey,
    pub scenario: Arc<Scenario>,
    pub walker: Controller,
    /// What it counts.
    pub criterion: Criterion,
    pub blame: Blame,
    /// The share of the box that is small enough.
    pub epsilon: f64,
    /// The greatest number of episodes.
    pub budget: u32,
    /// The parameters of the picture, by their places in [`Scenario::start_parameters`]: one or two.
    pub picture: Vec<usize>,
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

impl Cover {
    /// The name of what it counts.
    pub fn failure_name(&self) -> &str {
        match (self.criterion, self.blame) {
            (Criterion::Collision, Blame::Fault) => crate::campaign::FAULT,
            (Criterion::Collision, _) => crate::campaign::COLLISION,
            (Criterion::Violation(place), _) => self.scenario.requirements.get(place).map_or("", |named| &*named.name),
        }
    }

    /// The seed of all that it draws: the same for all drivers.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("cover").child(&self.key.town).index(self.key.block.into())
    }
}

impl Planned for Cover {
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
        self.budget.into()
    }

    fn ticks(&self, part: u32) -> u64 {
        self.units(part) * u64::from(self.scenario.episode.ticks)
    }

    fn inputs(&self) -> String {
        let Self { key: CoverKey { pedestrian, town, policy, block, .. }, epsilon, budget, fingerprint, .. } = self;
        let failure = self.failure_name();
        format!("cover {pedestrian:?} {town:?} {policy:?} {block} {failure:?} {epsilon:?} {budget} {fingerprint}")
    }

    fn shorten(&mut self) {
        self.budget = self.budget.min(30);
    }

    fn names(&self, _: &[Job]) -> Option<Vec<String>> {
        let Self { key: CoverKey { block, pedestrian, town, policy, .. }, fingerprint, epsilon, budget, .. } = self;
        let (failure, epsilon) = (self.failure_name(), format!("{epsilon:?}"));
        let all: [&dyn ToString; 9] =
            [&"cover", block, pedestrian, town, policy, fingerprint, &failure, &epsilon, budget];
        Some(all.map(ToString::to_string).into())
    }

    fn id(&self) -> Option<RunId> {
        Some(self.key.id)
    }

    fn id_mut(&mut self) -> Option<&mut RunId> {
        Some(&mut self.key.id)
    }
}
