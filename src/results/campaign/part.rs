use std::any::Any;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Event, Observer, ResultStore, State, Stored, Task, TaskError};
use crate::jobs::JobResult;
use base::seed::Seed;
use learn::UpdateLog;

/// The results of the jobs of a campaign, by their places.
pub(super) type Results = Vec<OnceLock<Box<dyn JobResult>>>;

/// A part of a job that is run, and all that it may use.
#[derive(Clone, Copy)]
pub struct Part<'a> {
    pub task: Task,
    /// The user's seed.
    pub seed: &'a Seed,
    pub results: &'a dyn ResultStore,
    pub(super) observer: &'a dyn Observer,
    pub(super) ended: &'a Results,
}

impl<'a> Part<'a> {
    /// Reports that it begins, with this number of units that an earlier run has stored.
    pub fn begin(&self, units: u64) {
        self.observer.event(&Event::Begun { task: self.task, units });
    }

    /// Reports the number of units that are done, those of earlier runs included.
    pub fn progress(&self, units: u64) {
        self.observer.event(&Event::Progress { task: self.task, units });
    }

    /// Reports the learning curve of a training.
    pub fn curve(&self, curve: &[UpdateLog], has_grown: bool) {
        self.observer.event(&Event::Curve { task: self.task, curve, has_grown });
    }

    /// Stores its whole result.
    pub(super) fn finish(&self, done: u64, bytes: Vec<u8>) {
        self.put(&Stored { state: State::Finished, done, error: String::new(), bytes });
    }

    pub fn put(&self, stored: &Stored) {
        self.results.put(self.task, stored);
    }

    /// Whether no further work starts.
    pub fn stop(&self) -> bool {
        self.observer.stop() || self.results.stop()
    }

    /// The limit of time or of ticks that it has reached, if any.
    pub fn limit(&self, ticks: u64) -> Option<TaskError> {
        self.results.limit(self.task, ticks)
    }

    /// The limit of time that it has reached; `None` if the user asked to stop before.
    pub fn own_limit(&self) -> Option<TaskError> {
        self.limit(0).filter(|_| !self.stop())
    }

    /// Reports simulator ticks as progress, each time a number of further ones.
    pub fn counter(&self) -> impl Fn(u64) + Sync {
        let used = AtomicU64::new(0);
        move |ticks| self.progress(used.fetch_add(ticks, Ordering::Relaxed) + ticks)
    }

    /// Whether it stops, for the user or for its limit of time.
    pub fn is_late(&self) -> bool {
        self.stop() || self.limit(0).is_some()
    }

    /// The result of a job that has ended; `None` if there is none, or it is of another kind.
    pub fn result_of<T: JobResult>(&self, job: usize) -> Option<&'a T> {
        let result: &dyn Any = self.ended[job].get()?.as_ref();
        result.downcast_ref()
    }
}
