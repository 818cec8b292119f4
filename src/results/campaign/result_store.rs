use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::{SearchResult, Task, TaskError};
use crate::record::{EpisodeRow, Tally};
use learn::Trained;
use world::falsifier::TrainingRun;

/// A claim on a task; while it is held, no other thread or process works on that task.
pub type Claim = Box<dyn Send>;

/// Stores the finished tasks of a campaign, and returns them when it is run again. Called from many threads.
///
/// A task is claimed, asked for, worked on, stored and released, in this order. An implementation that can no longer store returns
/// `true` from [`ResultStore::stop`] and reports the cause to its user.
pub trait ResultStore: Sync {
    /// Claims a task; none while another worker has it.
    fn claim(&self, task: Task) -> Option<Claim> {
        let _ = task;
        Some(Box::new(()))
    }

    /// A finished training.
    fn training(&self, training: usize) -> Option<Trained> {
        let _ = training;
        None
    }

    /// The state of an unfinished training, or of a finished one that this one continues with more steps, as [`TrainingRun::state`] wrote it.
    fn begun(&self, training: usize) -> Option<Vec<u8>> {
        let _ = training;
        None
    }

    /// Called between two updates of a training, and after the last update before it stops for now (`last`).
    fn checkpoint(&self, training: usize, run: &TrainingRun, last: bool) {
        let _ = (training, run, last);
    }

    /// Stores a finished training.
    fn keep_training(&self, training: usize, run: &TrainingRun) {
        let _ = (training, run);
    }

    /// Counts the stored episodes of a chunk, its first ones.
    fn episodes(&self, evaluation: usize, chunk: u32) -> Tally {
        let _ = (evaluation, chunk);
        Tally::default()
    }

    /// Called with the episodes of a chunk that follow the stored ones, each time with all of them. `end` says whether more follow, and if
    /// not, why.
    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>);

    /// A finished search.
    fn search(&self, search: usize) -> Option<SearchResult> {
        let _ = search;
        None
    }

    /// Stores a finished search.
    fn keep_search(&self, search: usize, result: &SearchResult) {
        let _ = (search, result);
    }

    /// The limit of time or of ticks that a task has reached, if any.
    fn limit(&self, task: Task, ticks: u64) -> Option<TaskError> {
        let _ = (task, ticks);
        None
    }

    /// Whether a training ends in the middle of an update: its limit of time, or the moment at which the user asked to `stop`, is too long
    /// ago. Called at every decision.
    fn is_overdue(&self, task: Task, stop: bool) -> bool {
        let _ = task;
        stop
    }

    /// Whether nothing can be stored any more.
    fn stop(&self) -> bool {
        false
    }
}

/// The progress of a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// More episodes follow.
    UnderWay,
    /// No more follow now: all episodes are there, or the user asked to stop.
    Ended,
    /// No more are needed: the stopping rule is met.
    Enough,
    /// No more follow, for this reason.
    Failed(&'a TaskError),
}

/// Stores episodes in memory and nothing else; for a small number.
#[derive(Debug, Default)]
pub struct InMemory {
    chunks: Mutex<BTreeMap<(usize, u32), Vec<EpisodeRow>>>,
}

impl InMemory {
    /// All episodes, in the plan's order.
    pub fn into_rows(self) -> Vec<EpisodeRow> {
        self.chunks.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().flatten().collect()
    }
}

impl ResultStore for InMemory {
    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>) {
        if end != Progress::UnderWay {
            let mut chunks = self.chunks.lock().unwrap_or_else(PoisonError::into_inner);
            chunks.insert((evaluation, chunk), rows.to_vec());
        }
    }
}
