use std::ops::Range;

use base::statistics::Weighted;

use crate::{ControllerKind, Evaluation, StoppingRule};

/// Number of episodes of an evaluation in one task.
pub const CHUNK: u32 = 10_000;

impl Evaluation {
    /// The number of its tasks: one when the number of episodes depends on their results.
    pub fn chunks(&self) -> u32 {
        if self.halfwidth.is_some() { 1 } else { self.episodes.div_ceil(CHUNK) }
    }

    /// The episodes of one of its chunks, at most.
    pub fn chunk(&self, chunk: u32) -> Range<u32> {
        if self.halfwidth.is_some() {
            return 0..self.episodes;
        }
        let start = chunk * CHUNK;
        start..self.episodes.min(start.saturating_add(CHUNK))
    }

    /// The rule that ends it.
    pub fn rule(&self) -> StoppingRule {
        StoppingRule::new(self.halfwidth, self.episodes)
    }

    /// Whether these episodes are all that it needs: their number, those that the driver drove to their end, and the collisions.
    pub fn is_finished_with(&self, episodes: u32, valid: impl Into<Weighted>, collisions: impl Into<Weighted>) -> bool {
        let rule = self.rule();
        let early = self.halfwidth.is_some() && rule.looks().contains(&episodes) && rule.is_met(collisions, valid);
        episodes == self.episodes || early
    }

    /// The place of the training that its pedestrian comes from.
    pub fn training(&self) -> Option<usize> {
        match self.controller {
            ControllerKind::Trained(training) | ControllerKind::Stochastic(training) => Some(training),
            ControllerKind::First | ControllerKind::Untrained(_) => None,
        }
    }
}
