//! Covers in a plan: boxes of starts in which the absence of failures is shown.

use std::fmt;
use std::sync::Arc;

use super::{Fingerprint, Programs, RunId};
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
            (Criterion::Collision, Blame::Fault) => super::campaign::FAULT,
            (Criterion::Collision, _) => super::campaign::COLLISION,
            (Criterion::Violation(place), _) => self.scenario.requirements.get(place).map_or("", |named| &*named.name),
        }
    }

    /// The seed of all that it draws: the same for all drivers.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("cover").child(&self.key.town).index(self.key.block.into())
    }
}
