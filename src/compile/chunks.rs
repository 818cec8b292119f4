use std::ops::Range;

use crate::{ControllerKind, Evaluation};

/// Number of episodes of an evaluation in one task.
pub const CHUNK: u32 = 10_000;

impl Evaluation {
    /// The number of its tasks.
    pub fn chunks(&self) -> u32 {
        self.episodes.div_ceil(CHUNK)
    }

    /// The episodes of one of its chunks.
    pub fn chunk(&self, chunk: u32) -> Range<u32> {
        let start = chunk * CHUNK;
        start..self.episodes.min(start.saturating_add(CHUNK))
    }

    /// The place of the training that its pedestrian comes from.
    pub fn training(&self) -> Option<usize> {
        match self.controller {
            ControllerKind::Trained(training) | ControllerKind::Stochastic(training) => Some(training),
            ControllerKind::First | ControllerKind::Untrained(_) => None,
        }
    }
}
