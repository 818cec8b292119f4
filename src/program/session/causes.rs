use std::sync::atomic::{AtomicU64, Ordering};

use super::{Event, Repeated, Session, Stage};
use verdict::cause::{Cause, Questions, RunLimit};

/// Finds the causes of some failures, and reports each episode that this takes to the observer of a session.
pub(crate) struct Causes<'a> {
    session: &'a Session,
    max_runs: u32,
    done: AtomicU64,
    all: u64,
}

impl<'a> Causes<'a> {
    /// Of this number of failures, with at most this number of episodes for each.
    pub fn new(session: &'a Session, failures: usize, max_runs: u32) -> Self {
        let causes = Self { session, max_runs, done: AtomicU64::new(0), all: failures as u64 * u64::from(max_runs) };
        causes.tell(0);
        causes
    }

    /// That of one of the failures, whatever its driver is. `None` if it is not a failure, or not as in the report.
    pub fn of(&self, repeated: &Repeated) -> Option<Cause> {
        let ran = || self.tell(self.done.fetch_add(1, Ordering::Relaxed) + 1);
        let cause = repeated.cause(Questions::All, RunLimit { max_runs: self.max_runs, ran: &ran });
        // The first episode repeats the failure.
        let left = self.max_runs - cause.as_ref().map_or(0, |cause| cause.runs - 1);
        self.tell(self.done.fetch_add(left.into(), Ordering::Relaxed) + u64::from(left));
        cause
    }

    fn tell(&self, done: u64) {
        self.session.tell(Event::Played { stage: Stage::Causes, done, all: self.all });
    }
}

impl Drop for Causes<'_> {
    fn drop(&mut self) {
        self.tell(self.all);
    }
}
