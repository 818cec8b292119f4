use std::sync::Arc;

use crate::env::{Outcome, PedestrianEnv, Scenario};
use crate::seed::Seed;
use crate::sim::WalkCommand;

/// A collision that a falsifier found, with all that is needed to see it again.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Failure {
    /// Number of its beginning under the seed of the search.
    pub beginning: u64,
    /// Ticks that the search had used when it was found, those of this episode included.
    pub ticks: u64,
    /// The commands, one a decision.
    pub commands: Vec<WalkCommand>,
    /// What became of it.
    pub outcome: Outcome,
}

impl Failure {
    /// Simulates it again under the seed of the search; none when the commands do not lead to an end.
    pub fn replay(&self, scenario: &Arc<Scenario>, seed: Seed) -> Option<Outcome> {
        let mut env = PedestrianEnv::new(scenario.clone(), seed);
        env.begin(self.beginning);
        for command in &self.commands {
            env.walk(*command);
        }
        env.outcome().copied()
    }
}
