use super::{CoverResult, EstimateResult, HardenResult, SearchResult, Task, TaskError, TrainingResult};
use compile::Training;
use learn::UpdateLog;

/// What happens in a campaign. Trainings, evaluations, searches and estimates are named by their places in it.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A task starts.
    Begun(Task),
    /// An earlier run has stored this number of the episodes of a task that starts, or of the decisions of a training.
    Continued { task: Task, units: u64 },
    /// A task of this size was finished in an earlier run, so it is not run again.
    Reused { task: Task, units: u64 },
    /// A training continues from this learning curve, or an earlier run has finished it with this one. The curve is empty for a new
    /// training.
    CurveBefore { training: usize, plan: &'a Training, curve: &'a [UpdateLog] },
    /// A training has taken this number of decisions in this run, demonstrations included; more often than [`Event::Updated`].
    Deciding { training: usize, decisions: u64 },
    /// A training has finished an update. The curve holds the reports of all updates up to now, also of earlier runs.
    Updated { training: usize, plan: &'a Training, curve: &'a [UpdateLog] },
    /// A training has ended, with or without an error.
    Trained { training: usize, result: &'a TrainingResult },
    /// An evaluation has finished an episode.
    Tried { evaluation: usize },
    /// A chunk of an evaluation has ended. All its episodes are stored, unless there is an error or the user asked to stop.
    Evaluated { evaluation: usize, chunk: u32, error: Option<&'a TaskError> },
    /// A search has used this number of simulator ticks of its budget; before every episode.
    Searching { search: usize, ticks: u64 },
    /// A search has ended.
    Searched { search: usize, result: &'a SearchResult },
    /// An estimate has used this number of simulator ticks.
    Estimating { estimation: usize, ticks: u64 },
    /// An estimate has ended.
    Estimated { estimation: usize, result: &'a EstimateResult },
    /// A cover has finished this number of episodes.
    Covering { cover: usize, episodes: u64 },
    /// A cover has ended.
    Covered { cover: usize, result: &'a CoverResult },
    /// A hardening has used this number of simulator ticks.
    Hardening { harden: usize, ticks: u64 },
    /// A hardening has ended.
    Hardened { harden: usize, result: &'a HardenResult },
}

/// Observes a running campaign.
pub trait Observer: Sync {
    /// Hears what happens. Called from many threads.
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
