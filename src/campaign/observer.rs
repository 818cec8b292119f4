use super::{Task, TaskError};
use crate::compile::{Evaluation, Training};
use crate::rl::UpdateLog;

/// Hears what a running campaign does; called from many threads.
pub trait Observer: Sync {
    /// A training begins. The number is its place in the campaign.
    fn training_begun(&self, training: usize) {
        let _ = training;
    }

    /// A training has finished an update. The number is its place in the campaign.
    fn trained(&self, training: usize, plan: &Training, log: &UpdateLog) {
        let _ = (training, plan, log);
    }

    /// A training has ended, well or not.
    fn training_ended(&self, training: usize, result: &super::TrainingResult) {
        let _ = (training, result);
    }

    /// An evaluation has finished an episode. The number is its place in the campaign.
    fn tried(&self, evaluation: usize, plan: &Evaluation) {
        let _ = (evaluation, plan);
    }

    /// A chunk of an evaluation has ended; all its episodes are there unless something is said to have gone wrong, or
    /// somebody asked to stop.
    fn chunk_ended(&self, evaluation: usize, chunk: u32, error: Option<&TaskError>) {
        let _ = (evaluation, chunk, error);
    }

    /// A task was finished before, so nothing is done.
    fn reused(&self, task: Task) {
        let _ = task;
    }

    /// A chunk is begun, of which so many episodes were there before.
    fn continued(&self, task: Task, episodes: u32) {
        let _ = (task, episodes);
    }

    /// A search has ended. The number is its place in the campaign.
    fn searched(&self, search: usize, result: &super::SearchResult) {
        let _ = (search, result);
    }

    /// Whether to stop after the work in hand.
    fn stop(&self) -> bool {
        false
    }
}

/// Hears nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}
