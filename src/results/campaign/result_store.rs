use serde::{Deserialize, Serialize};

use super::{Task, TaskError};

/// A claim on a task; while it is held, no other thread or process works on that task.
pub type Claim = Box<dyn Send>;

/// The progress of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// It is complete.
    Finished,
    /// It can be continued.
    Begun,
    /// It failed, or a part is missing; it is run again from its start.
    Failed,
}

/// What is stored of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    pub state: State,
    /// Number of its units.
    pub done: u64,
    /// Why it ended early; empty without a reason.
    pub error: String,
    /// The form that its kind gives it.
    pub bytes: Vec<u8>,
}

/// Stores the tasks of a campaign, and returns them when it is run again. Called from many threads.
///
/// A task is claimed, asked for, worked on, stored and released, in this order. An implementation that can no longer store returns
/// `true` from [`ResultStore::stop`] and reports the cause to its user.
pub trait ResultStore: Sync {
    /// Claims a task; None while another worker has it.
    fn claim(&self, _task: Task) -> Option<Claim> {
        Some(Box::new(()))
    }

    /// What is stored of a task that has not failed. It may be of a shorter job which this one continues; then it is begun.
    fn get(&self, _task: Task) -> Option<Stored> {
        None
    }

    fn put(&self, _task: Task, _stored: &Stored) {}

    /// What was stored of a task has another form than its kind gives it.
    fn damaged(&self, _task: Task) {}

    /// Whether a checkpoint of a task is due. If so, the clock for the next one restarts.
    fn is_due(&self, _task: Task) -> bool {
        false
    }

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

/// Stores nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoStore;

impl ResultStore for NoStore {}
