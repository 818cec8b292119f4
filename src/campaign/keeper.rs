use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::{Cell, CellError, SearchResult};
use crate::falsifier::TrainingRun;
use crate::record::{EpisodeRow, Tally};
use crate::rl::Trained;

/// What somebody holds while nobody else may work on the same cell.
pub type Claim = Box<dyn Send>;

/// Keeps what a campaign has finished, and gives it back when it is run again. Called from many threads.
///
/// A cell is claimed, asked for, worked on, handed over, and let go, in this order. Whoever cannot keep something says so by
/// [`Keeper::stop`] and tells its user why.
pub trait Keeper: Sync {
    /// Takes a cell in hand; none while somebody else has it.
    fn claim(&self, cell: Cell) -> Option<Claim> {
        let _ = cell;
        Some(Box::new(()))
    }

    /// A training that is finished.
    fn training(&self, training: usize) -> Option<Trained> {
        let _ = training;
        None
    }

    /// A training that was begun, as [`TrainingRun::state`] wrote it.
    fn begun(&self, training: usize) -> Option<Vec<u8>> {
        let _ = training;
        None
    }

    /// Hears of a training between two updates, of the last one before it is given up for now too (`last`).
    fn checkpoint(&self, training: usize, run: &TrainingRun, last: bool) {
        let _ = (training, run, last);
    }

    /// Keeps a training that is finished.
    fn keep_training(&self, training: usize, trained: &Trained) {
        let _ = (training, trained);
    }

    /// What is there of a chunk: its first episodes.
    fn episodes(&self, evaluation: usize, chunk: u32) -> Tally {
        let _ = (evaluation, chunk);
        Tally::default()
    }

    /// Hears of the episodes of a chunk that have followed those that were there, all of them every time. With the last ones
    /// comes why there are no more, unless all are there or somebody asked to stop.
    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>);

    /// A search that is finished.
    fn search(&self, search: usize) -> Option<SearchResult> {
        let _ = search;
        None
    }

    /// Keeps a search that is finished.
    fn keep_search(&self, search: usize, result: &SearchResult) {
        let _ = (search, result);
    }

    /// Whether a cell has had its share of time, or of ticks.
    fn limit(&self, cell: Cell, ticks: u64) -> Option<CellError> {
        let _ = (cell, ticks);
        None
    }

    /// Whether nothing can be kept any more.
    fn stop(&self) -> bool {
        false
    }
}

/// How far a chunk has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// More episodes follow.
    UnderWay,
    /// No more follow now: all are there, or somebody asked to stop.
    Ended,
    /// No more are needed: the stopping rule is met.
    Enough,
    /// No more follow, for this reason.
    Failed(&'a CellError),
}

/// Keeps episodes in memory and nothing else, for few of them.
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

impl Keeper for InMemory {
    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>) {
        if end != Progress::UnderWay {
            let mut chunks = self.chunks.lock().unwrap_or_else(PoisonError::into_inner);
            chunks.insert((evaluation, chunk), rows.to_vec());
        }
    }
}
