use std::sync::Arc;

use crate::env::{Outcome, PedestrianEnv, Recording, Scenario};
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
        follow(scenario, seed, self.beginning, &self.commands).map(|(outcome, _)| outcome)
    }
}

/// Walks as these commands say from a beginning under the seed of a search; none when they do not lead to an end.
pub fn follow(
    scenario: &Arc<Scenario>,
    seed: Seed,
    beginning: u64,
    commands: &[WalkCommand],
) -> Option<(Outcome, Recording)> {
    let mut env = PedestrianEnv::new(scenario.clone(), seed);
    let mut recording = Recording::new(&scenario.episode);
    env.begin(beginning);
    recording.begin(env.world());
    for command in commands {
        if env.outcome().is_some() {
            return None;
        }
        recording.decide(*command);
        env.set_out(*command);
        loop {
            let step = env.tick();
            recording.watch(env.world(), env.contact(), env.driven());
            if step.is_some() {
                break;
            }
        }
    }
    env.outcome().map(|outcome| (*outcome, recording))
}
