use std::ops::Range;

use super::StoppingRule;
use crate::compile::{Campaign, ControllerKind, Evaluation};
use crate::falsifier::TrainError;
use crate::statistics::Weighted;

/// Number of episodes of an evaluation in one task.
pub const CHUNK: u32 = 10_000;

/// A task of a campaign, by its place in the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Task {
    /// A training.
    Training(usize),
    /// Some episodes of an evaluation.
    Chunk {
        /// The evaluation.
        evaluation: usize,
        /// Which of its chunks, from 0.
        chunk: u32,
    },
    /// A search.
    Search(usize),
}

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
            ControllerKind::Trained(training) | ControllerKind::Sampled(training) => Some(training),
            _ => None,
        }
    }
}

/// All tasks of a campaign, in its order: trainings, chunks of evaluations, searches.
pub fn tasks(campaign: &Campaign) -> impl Iterator<Item = Task> {
    let chunks = |(evaluation, planned): (usize, &Evaluation)| {
        (0..planned.chunks()).map(move |chunk| Task::Chunk { evaluation, chunk })
    };
    (0..campaign.trainings.len())
        .map(Task::Training)
        .chain(campaign.evaluations.iter().enumerate().flat_map(chunks))
        .chain((0..campaign.searches.len()).map(Task::Search))
}

/// Why a task failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// A training could not continue.
    #[error(transparent)]
    Training(#[from] TrainError),
    /// The training of the pedestrian that was to be evaluated failed.
    #[error("its training failed: {0}")]
    Untrained(Box<TaskError>),
    /// The driver or the controller failed in this number of episodes in a row, so no more were run.
    #[error("not run, since the driver or the controller had failed in ten episodes in a row")]
    Hopeless,
    /// It reached its time limit.
    #[error("not finished within the {seconds} s that a task may take")]
    Time {
        /// The limit (s).
        seconds: u64,
    },
    /// It needs more simulator ticks than its limit.
    #[error("not finished within the {ticks} ticks that a task may use")]
    Ticks {
        /// The limit.
        ticks: u64,
    },
}
