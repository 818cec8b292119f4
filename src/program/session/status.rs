use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::growing_curves::NewestUpdate;
use super::{Error, Session};
use base::choice;
use results::jobs::{KINDS, Kind};
use results::report::StoredReport;
use results::store::{CampaignStatus, Store, TaskStatus};

/// Options of [`Session::status`].
#[derive(Debug, Clone, Default, Args)]
pub struct StatusOptions {
    /// The folder for the reports, or one of its reports.
    #[arg(long, short, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub out: PathBuf,
    /// The folder that `run` was given as --cache.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR")]
    pub cache: Option<PathBuf>,
}

/// The progress of a campaign; its JSON is one object for each campaign.
#[derive(Debug, Serialize)]
pub struct CampaignProgress {
    pub campaign: String,
    /// Whether it is finished or running.
    pub state: CampaignState,
    /// Processes that work on the folder.
    pub processes: usize,
    /// The progress of each kind of task.
    #[serde(rename = "tasks")]
    pub kinds: Vec<KindProgress>,
    /// The tasks that are under way, for people.
    pub in_hand: Vec<String>,
    /// The newest update of each training that is under way.
    pub learning: Vec<NewestUpdate>,
    /// Estimated time of the remaining work on one thread (s); none until each kind has a measurement.
    pub left_thread_s: Option<f64>,
    /// The same without the kinds that have no measurement (s).
    #[serde(skip)]
    pub measured_s: f64,
    /// The kinds that have no measurement.
    #[serde(skip)]
    pub unmeasured: Vec<&'static str>,
    /// Estimated remaining time with as many tasks under way as now (s); none when no task is under way.
    pub left_s: Option<f64>,
    /// The error of the task that failed last.
    pub last_error: Option<String>,
    /// The command that it was last run with; empty when it is not known.
    pub command: String,
    /// Whether that command has nothing left to do, though the campaign may have: a finished shard.
    pub is_command_done: bool,
    /// The tasks under way, as the store has them.
    #[serde(skip)]
    pub under_way: Vec<TaskStatus>,
}

choice! {
    /// The state of a campaign.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum CampaignState {
        /// All tasks are finished.
        Finished = "finished",
        /// A process works on the folder.
        Running = "running",
        /// Tasks are missing, and no process works on the folder.
        Stopped = "stopped",
    }
}

/// The progress of the tasks of a kind.
#[derive(Debug, Serialize)]
pub struct KindProgress {
    /// Several of them, such as `trainings`.
    pub kind: &'static str,
    /// The number of finished tasks.
    pub finished: usize,
    /// The number of all tasks.
    pub all: usize,
    /// Share of the work that is done, 0 to 1, including tasks under way.
    pub share: f64,
}

impl Session {
    /// Reads the progress of the campaigns of a folder. It changes nothing.
    ///
    /// # Errors
    /// A cache folder with other contents, and a folder in which nothing was run.
    pub fn status(&self, options: &StatusOptions) -> Result<Vec<CampaignProgress>, Error> {
        // A report shows its own campaign.
        let of_report = StoredReport::open(&options.out).ok().and_then(|_| options.out.canonicalize().ok());
        let (out, name) = match of_report.as_ref().and_then(|report| Some((report.parent()?, report.file_name()?))) {
            Some((out, name)) => (out, Some(name.to_string_lossy())),
            None => (options.out.as_path(), None),
        };
        let store = Store::look(out, options.cache.as_deref(), self.note())?;
        let mut campaigns = store.campaigns();
        campaigns.retain(|campaign| name.as_ref().is_none_or(|name| campaign == name));
        if campaigns.is_empty() {
            let out = options.out.display();
            return Err(Error::Usage(match &options.cache {
                Some(cache) => format!("no campaign was run for `{out}` with the cache `{}`", cache.display()),
                None => {
                    format!("no campaign was run in `{out}`; if it was run with --cache, name that folder here too")
                }
            }));
        }
        let processes = store.processes();
        campaigns.iter().map(|name| Ok(progress(store.status(name)?, processes, &store.learning(name)))).collect()
    }
}

fn progress(campaign: CampaignStatus, processes: usize, curves: &Path) -> CampaignProgress {
    let CampaignStatus { name, command, is_command_done, tasks } = campaign;
    let state = match tasks.iter().all(TaskStatus::is_finished) {
        true => CampaignState::Finished,
        false if processes > 0 => CampaignState::Running,
        false => CampaignState::Stopped,
    };
    let (measured_s, unmeasured) = left(&tasks);
    let left = unmeasured.is_empty().then_some(measured_s);
    let failed = |task: &TaskStatus| {
        let header = task.header.as_ref().filter(|header| !header.error.is_empty())?;
        Some((task.written?, header.error.clone()))
    };
    let last = tasks.iter().filter_map(failed).max_by_key(|(when, _)| *when);
    let kinds = KINDS.iter().filter_map(|kind| count(&tasks, kind)).collect();
    let under_way: Vec<TaskStatus> = tasks.into_iter().filter(|task| task.is_in_hand).collect();
    CampaignProgress {
        campaign: name,
        state,
        processes,
        kinds,
        left_thread_s: left,
        measured_s,
        unmeasured,
        left_s: left.filter(|_| !under_way.is_empty()).map(|left| left / under_way.len() as f64),
        learning: of_kind(&under_way, "train")
            .filter_map(|task| NewestUpdate::read(curves, task.what.strip_prefix("train ")?))
            .collect(),
        in_hand: under_way.iter().map(|task| task.what.clone()).collect(),
        last_error: last.map(|(_, error)| error),
        command,
        is_command_done,
        under_way,
    }
}

fn of_kind<'a>(tasks: &'a [TaskStatus], word: &str) -> impl Iterator<Item = &'a TaskStatus> {
    tasks.iter().filter(move |task| task.what.split(' ').next() == Some(word))
}

fn count(tasks: &[TaskStatus], kind: &Kind) -> Option<KindProgress> {
    let word = kind.verb;
    let all = of_kind(tasks, word).count();
    let amount: u64 = of_kind(tasks, word).map(|task| task.amount).sum();
    let done: u64 = of_kind(tasks, word).map(TaskStatus::done).sum();
    let finished = of_kind(tasks, word).filter(|task| task.is_finished()).count();
    (all > 0).then(|| KindProgress { kind: kind.plural, finished, all, share: done as f64 / amount.max(1) as f64 })
}

/// The time of the remaining work on one thread (s), estimated from the finished part, and the kinds without a measurement.
fn left(tasks: &[TaskStatus]) -> (f64, Vec<&'static str>) {
    let mut seconds = 0.0;
    let mut unmeasured = Vec::new();
    for &Kind { verb: word, plural: kind, .. } in KINDS {
        let left: u64 = of_kind(tasks, word).map(|task| task.amount - task.done()).sum();
        if left == 0 {
            continue;
        }
        let done: u64 = of_kind(tasks, word).map(TaskStatus::done).sum();
        let took: f64 = of_kind(tasks, word)
            .filter(|task| task.done() > 0)
            .filter_map(|task| Some(task.header.as_ref()?.seconds))
            .sum();
        if done == 0 {
            unmeasured.push(kind);
        } else {
            seconds += took / done as f64 * left as f64;
        }
    }
    (seconds, unmeasured)
}
