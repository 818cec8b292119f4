mod block;

use std::fmt;
use std::sync::Arc;

use super::{Origin, Planned};
use base::seed::Seed;
pub(super) use block::{BLOCK, Rival};
use episode::Scenario;
use search::Falsifier;

/// The names that distinguish a search from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SearchKey {
    pub falsifier: String,
    /// Its kind.
    pub method: &'static str,
    /// Name of the reward that it maximises; empty for falsifiers without one.
    pub reward: String,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    /// Number of the `search` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

impl SearchKey {
    /// What it shares with searches that differ only in their run: falsifier, town, driver and block.
    pub fn cell(&self) -> (String, String, String, u32) {
        (self.falsifier.clone(), self.town.clone(), self.policy.clone(), self.block)
    }

    /// Whether another search differs only in its run.
    pub fn is_of_same_cell(&self, other: &Self) -> bool {
        self.cell() == other.cell()
    }
}

/// `chance in harbour against idm, run 0`.
impl fmt::Display for SearchKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.falsifier, self.town, self.policy, self.run)
    }
}

/// One falsifier that looks for failures of one policy in one town.
#[derive(Debug, Clone)]
pub struct Search {
    pub origin: Origin,
    pub key: SearchKey,
    /// The scenario of the search.
    pub scenario: Arc<Scenario>,
    pub falsifier: Arc<dyn Falsifier>,
    /// The number of simulator ticks it may use.
    pub budget: u64,
    /// The number of fresh episodes in which its final pedestrian is evaluated, if it has one.
    pub tries: u32,
}

impl Search {
    /// Its names, if it were of this block.
    fn of_block(&self, block: &u32) -> Vec<String> {
        let Self { key: SearchKey { falsifier, town, policy, run, .. }, origin, budget, .. } = self;
        let all: [&dyn ToString; 8] = [&"search", block, falsifier, town, policy, run, &origin.fingerprint, budget];
        all.map(ToString::to_string).into()
    }

    /// The seed of its starts: the same for all falsifiers and all drivers.
    pub fn starts(&self, seed: &Seed) -> Seed {
        seed.child("search").child(&self.key.town).index(self.key.run.into())
    }

    /// The seed of what its falsifier draws.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        self.own(seed).child("search")
    }

    /// The seed of what is its own: what its falsifier draws, and the tries of its controller.
    pub fn own(&self, seed: &Seed) -> Seed {
        let key = &self.key;
        seed.child("falsifier").child(&key.town).child(&key.falsifier).index(key.run.into())
    }
}

impl Planned for Search {
    fn title(&self) -> String {
        self.key.to_string()
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.key.town, &self.scenario)]
    }

    fn units(&self, _: u32) -> u64 {
        self.budget
    }

    /// A search of another block is the same work.
    fn inputs(&self) -> String {
        format!("{:?} {}", self.of_block(&0), self.tries)
    }

    /// Some falsifiers learn.
    fn depends_on_processor(&self) -> bool {
        true
    }

    fn shorten(&mut self) {
        self.budget = self.budget.min(10 * self.scenario.longest());
        self.tries = self.tries.min(5);
    }

    fn names(&self, _: Option<&dyn Planned>) -> Vec<String> {
        self.of_block(&self.origin.block)
    }
}
