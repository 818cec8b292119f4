use super::Task;
use crate::jobs::JobResult;
use learn::UpdateLog;

/// What happens in a campaign.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A task begins; an earlier run has stored this number of its units.
    Begun { task: Task, units: u64 },
    /// This number of the units of a task is done, those of earlier runs included.
    Progress { task: Task, units: u64 },
    /// A training continues from this learning curve, which is empty for a new one; or (`has_grown`) an update has ended, and the curve holds
    /// those of all updates up to now.
    Curve { task: Task, curve: &'a [UpdateLog], has_grown: bool },
    /// A task was finished in an earlier run, so it is not run again.
    Reused { task: Task, result: &'a dyn JobResult },
    /// A task has ended, with or without an error. It is stored, unless there is an error or the user asked to stop.
    Ended { task: Task, result: &'a dyn JobResult },
}

/// Observes a running campaign.
pub trait Observer: Sync {
    /// Receives what happens. Called from many threads.
    fn event(&self, event: &Event<'_>);

    /// Whether to stop after the current update or episode.
    fn stop(&self) -> bool {
        false
    }
}

/// Ignores everything and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Event<'_>) {}
}
