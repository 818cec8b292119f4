use std::path::Path;

use super::{Task, TaskError};
use compile::{Evaluation, Training};
use learn::UpdateLog;

/// Observes a running campaign. Its methods are called from many threads.
pub trait Observer: Sync {
    /// A training starts. The number is its place in the campaign.
    fn training_begun(&self, training: usize) {
        let _ = training;
    }

    /// The learning curves of the campaign grow in files of this folder. Called before the first training that has updates to make.
    fn curves_grow(&self, folder: &Path) {
        let _ = folder;
    }

    /// A training continues from this learning curve, or an earlier run has finished it with this one. The curve is empty for a new
    /// training. The number is its place in the campaign.
    fn curve_before(&self, training: usize, plan: &Training, curve: &[UpdateLog]) {
        let _ = (training, plan, curve);
    }

    /// A training has taken this number of decisions in this run; called more often than [`Observer::trained`].
    fn deciding(&self, training: usize, decisions: u64) {
        let _ = (training, decisions);
    }

    /// A training has finished an update. The number is its place in the campaign; the curve holds the reports of all updates up to now,
    /// also of earlier runs.
    fn trained(&self, training: usize, plan: &Training, curve: &[UpdateLog]) {
        let _ = (training, plan, curve);
    }

    /// A training has ended, with or without an error.
    fn training_ended(&self, training: usize, result: &super::TrainingResult) {
        let _ = (training, result);
    }

    /// An evaluation has finished an episode. The number is its place in the campaign.
    fn tried(&self, evaluation: usize, plan: &Evaluation) {
        let _ = (evaluation, plan);
    }

    /// A chunk of an evaluation has ended. All its episodes are stored, unless there is an error or the user asked to stop.
    fn chunk_ended(&self, evaluation: usize, chunk: u32, error: Option<&TaskError>) {
        let _ = (evaluation, chunk, error);
    }

    /// A task was finished in an earlier run, so it is not run again.
    fn reused(&self, task: Task) {
        let _ = task;
    }

    /// A task starts. An earlier run has stored this number of its episodes, or of the decisions of a training.
    fn continued(&self, task: Task, units: u64) {
        let _ = (task, units);
    }

    /// A search starts. The number is its place in the campaign.
    fn search_begun(&self, search: usize) {
        let _ = search;
    }

    /// A search has used this number of simulator ticks of its budget. It is called before every episode.
    fn searching(&self, search: usize, ticks: u64) {
        let _ = (search, ticks);
    }

    /// A search has ended. The number is its place in the campaign.
    fn searched(&self, search: usize, result: &super::SearchResult) {
        let _ = (search, result);
    }

    /// Whether to stop after the current update or episode.
    fn stop(&self) -> bool {
        false
    }
}

/// Ignores everything and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}
