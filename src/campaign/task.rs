use std::ops::Range;

use super::StoppingRule;
use crate::compile::{Campaign, ControllerKind, Evaluation};
use crate::falsifier::TrainError;
use crate::statistics::Weighted;

/// Episodes of an evaluation that are one piece of work.
pub const CHUNK: u32 = 10_000;

/// A piece of work of a campaign, by its place in the plan.
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
    /// How many pieces of work it is: one when its episodes decide how many there are.
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

    /// Until when it goes on.
    pub fn rule(&self) -> StoppingRule {
        StoppingRule::new(self.halfwidth, self.episodes)
    }

    /// Whether so many of its episodes, so many of which the driver drove to their end, with so many collisions, are all that it needs.
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

/// All pieces of work of a campaign, in its order: trainings, chunks of evaluations, searches.
pub fn tasks(campaign: &Campaign) -> impl Iterator<Item = Task> {
    let chunks = |(evaluation, planned): (usize, &Evaluation)| {
        (0..planned.chunks()).map(move |chunk| Task::Chunk { evaluation, chunk })
    };
    (0..campaign.trainings.len())
        .map(Task::Training)
        .chain(campaign.evaluations.iter().enumerate().flat_map(chunks))
        .chain((0..campaign.searches.len()).map(Task::Search))
}

/// Why a piece of work came to nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// A training could not go on.
    #[error(transparent)]
    Training(#[from] TrainError),
    /// The training of the pedestrian that was to be tried came to nothing.
    #[error("its training failed: {0}")]
    Untrained(Box<TaskError>),
    /// The driver failed in so many episodes in a row that no more were tried.
    #[error("not tried, since the driver had failed in ten episodes in a row")]
    Hopeless,
    /// It took longer than it may.
    #[error("not finished within the {seconds} s that a task may take")]
    Time {
        /// The limit (s).
        seconds: u64,
    },
    /// It needs more simulator ticks than it may use.
    #[error("not finished within the {ticks} ticks that a task may use")]
    Ticks {
        /// The limit.
        ticks: u64,
    },
}
