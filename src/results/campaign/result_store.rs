use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::{CoverResult, EstimateResult, HardenResult, SearchResult, Task, TaskError};
use crate::record::EpisodeRow;
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
    fn claim(&self, _task: Task) -> Option<Claim> {
        Some(Box::new(()))
    }

    /// A finished training.
    fn training(&self, _training: usize) -> Option<Trained> {
        None
    }

    /// The state of an unfinished training, or of a finished one that this one continues with more steps, as [`TrainingRun::state`] wrote it.
    fn begun(&self, _training: usize) -> Option<Vec<u8>> {
        None
    }

    /// Called between two updates of a training, and after the last update before it stops for now (`last`).
    fn checkpoint(&self, _training: usize, _run: &TrainingRun, _last: bool) {}

    /// Stores a finished training.
    fn keep_training(&self, _training: usize, _run: &TrainingRun) {}

    /// Counts the stored episodes of a chunk, its first ones.
    fn episodes(&self, _evaluation: usize, _chunk: u32) -> u32 {
        0
    }

    /// Called with the episodes of a chunk that follow the stored ones, each time with all of them. `end` says whether more follow, and if
    /// not, why.
    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>);

    /// A finished search.
    fn search(&self, _search: usize) -> Option<SearchResult> {
        None
    }

    /// Stores a finished search.
    fn keep_search(&self, _search: usize, _result: &SearchResult) {}

    /// A finished estimate.
    fn estimate(&self, _estimation: usize) -> Option<EstimateResult> {
        None
    }

    /// Stores a finished estimate.
    fn keep_estimate(&self, _estimation: usize, _result: &EstimateResult) {}

    /// A finished cover.
    fn cover(&self, _cover: usize) -> Option<CoverResult> {
        None
    }

    /// Stores a finished cover.
    fn keep_cover(&self, _cover: usize, _result: &CoverResult) {}

    /// A finished hardening.
    fn hardened(&self, _harden: usize) -> Option<HardenResult> {
        None
    }

    /// Stores a finished hardening.
    fn keep_hardened(&self, _harden: usize, _result: &HardenResult) {}

    /// The limit of time or of ticks that a task has reached, if any.
    fn limit(&self, _task: Task, _ticks: u64) -> Option<TaskError> {
        None
    }

    /// Whether a training ends in the middle of an update: its limit of time, or the moment at which the user asked to `stop`, is too long
    /// ago. Called at every decision.
    fn is_overdue(&self, _task: Task, stop: bool) -> bool {
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
