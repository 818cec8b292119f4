mod stored;

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use clap::Args;
use indicatif::FormattedDuration;
use serde::Serialize;

use crate::cli::console;
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::cli::output::Output;
use crate::cli::progress::Learnt;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Error, NewestUpdate, Session};
use base::choice;
use results::jobs::{KINDS, Kind};
use results::report::StoredReport;
use results::store::{CampaignStatus, Store, TaskStatus};
use stored::stored;

/// Maximum number of tasks under way that are named.
const MAX_SHOWN: usize = 8;

pub const EXAMPLES: &str = "\
Examples:
  falsify status                             the campaigns of reports/
  falsify status reports/my                  one of them
  falsify status --format json --out shared  one JSON object for each campaign, for programs
  falsify status --stored                    what is stored in reports/.falsify, by campaign
  falsify status --prune                     remove what no campaign needed in its last run
  falsify status --cache /scratch/cache --prune --gone
                                             in a shared folder; also what belongs to deleted reports

Exit codes: 0 finished or running   2 nothing was run there   9 something is missing and no process works on it";

/// Options of `falsify status`.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The folder for the reports, or one of its reports, instead of `--out`.
    #[arg(value_name = "DIR")]
    pub folder: Option<PathBuf>,
    /// The folder for the reports, or one of its reports.
    #[arg(long, short, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub out: PathBuf,
    /// The folder that `run` was given as --cache.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Form of the output; `json` is one object for each campaign.
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT")]
    pub format: Output,
    /// Show how much finished work is stored for each campaign instead.
    #[arg(long)]
    pub stored: bool,
    /// Remove stored tasks that no campaign needed in its last run, for any folder for reports.
    #[arg(long)]
    pub prune: bool,
    /// Also remove tasks of folders for reports that do not exist, or cannot be seen from here.
    #[arg(long, requires = "prune")]
    pub gone: bool,
}

impl StatusArgs {
    /// The folder for the reports as it was given, or one of its reports.
    fn given(&self) -> &Path {
        self.folder.as_deref().unwrap_or(&self.out)
    }

    /// The folder for the reports, and the name of the report in it that was given.
    fn place(&self) -> (PathBuf, Option<String>) {
        let given = self.given();
        let report = StoredReport::open(given).ok().and_then(|_| given.canonicalize().ok());
        let place = |report: &Path| Some((report.parent()?.to_owned(), report.file_name()?.to_string_lossy().into()));
        match report.as_deref().and_then(place) {
            Some((out, name)) => (out, Some(name)),
            None => (given.to_owned(), None),
        }
    }
}

/// The progress of a campaign; its JSON is one object for each campaign.
#[derive(Debug, Serialize)]
struct CampaignProgress {
    campaign: String,
    /// Whether it is finished or running.
    state: CampaignState,
    /// Processes that work on the folder.
    processes: usize,
    /// The progress of each kind of task.
    #[serde(rename = "tasks")]
    kinds: Vec<KindProgress>,
    /// The tasks that are under way, for people.
    in_hand: Vec<String>,
    /// The newest update of each training that is under way.
    learning: Vec<NewestUpdate>,
    /// Estimated time of the remaining work on one thread (s); `None` until each kind has a measurement.
    left_thread_s: Option<f64>,
    /// The same without the kinds that have no measurement (s).
    #[serde(skip)]
    measured_s: f64,
    /// The kinds that have no measurement.
    #[serde(skip)]
    unmeasured: Vec<&'static str>,
    /// Estimated remaining time with as many tasks under way as now (s); `None` if no task is under way.
    left_s: Option<f64>,
    /// The error of the task that failed last.
    last_error: Option<String>,
    /// The command that it was last run with; empty when it is not known.
    command: String,
    /// Whether that command has nothing left to do, though the campaign may have: a finished shard.
    is_command_done: bool,
    /// The tasks under way, as the store has them.
    #[serde(skip)]
    under_way: Vec<TaskStatus>,
}

choice! {
    /// The state of a campaign.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    enum CampaignState {
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
struct KindProgress {
    /// Several of them, such as `trainings`.
    kind: &'static str,
    /// The number of finished tasks.
    finished: usize,
    /// The number of all tasks.
    all: usize,
    /// Share of the work that is done, 0 to 1, including tasks under way.
    share: f64,
}

pub fn status(options: &StatusArgs) -> Ended {
    if options.stored || options.prune {
        return stored(options);
    }
    let campaigns = campaigns(&session(false), options).map_err(failed)?;
    for campaign in &campaigns {
        match options.format {
            Output::Json => console::say_object(campaign),
            Output::Human => tell(campaign),
        }
    }
    let stopped = campaigns.iter().any(|campaign| campaign.state == CampaignState::Stopped);
    Ok(if stopped { ExitCode::Incomplete } else { ExitCode::Done })
}

/// Reads the progress of the campaigns of a folder.
///
/// # Errors
/// A cache folder with other contents, and a folder in which nothing was run.
fn campaigns(session: &Session, options: &StatusArgs) -> Result<Vec<CampaignProgress>, Error> {
    let (out, name) = options.place();
    let store = Store::look(&out, options.cache.as_deref(), session.note())?;
    let mut campaigns = store.campaigns();
    campaigns.retain(|campaign| name.as_ref().is_none_or(|name| campaign == name));
    if campaigns.is_empty() {
        let out = options.given().display();
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

/// Prints the progress for people.
fn tell(campaign: &CampaignProgress) {
    let processes = match campaign.processes {
        0 => String::new(),
        1 => ", one process works on the folder".into(),
        several => format!(", {several} processes work on the folder"),
    };
    console::say(&format!("{}: {}{processes}", campaign.campaign, campaign.state.name()));
    for kind in &campaign.kinds {
        console::say(&format!(
            "  {:11} {:>width$} of {} tasks, {:.0} % of the work",
            kind.kind,
            kind.finished,
            kind.all,
            (100.0 * kind.share).floor(),
            width = kind.all.to_string().len()
        ));
    }
    for task in campaign.under_way.iter().take(MAX_SHOWN) {
        let newest = campaign.learning.iter().find(|newest| task.what.strip_prefix("train ") == Some(&newest.training));
        let learnt = newest.and_then(|newest| Learnt::from(newest).told()).map(|learnt| format!(", {learnt}"));
        console::say(&format!("  under way: {}{}{}", task.what, saved(task), learnt.unwrap_or_default()));
    }
    if campaign.in_hand.len() > MAX_SHOWN {
        console::say(&format!("  … and {} more under way", campaign.in_hand.len() - MAX_SHOWN));
    }
    if let Some(error) = &campaign.last_error {
        console::say(&format!("  last error: {error}"));
    }
    if campaign.state == CampaignState::Finished {
        return;
    }
    match (campaign.left_s, campaign.left_thread_s) {
        (Some(left), _) => {
            console::say(&format!("  about {} left with {} tasks under way", clock(left), campaign.in_hand.len()));
        }
        (None, Some(left)) => console::say(&format!("  about {} left for one thread", clock(left))),
        (None, None) if campaign.measured_s > 0.0 => {
            let known = clock(campaign.measured_s);
            let unknown = campaign.unmeasured.join(" and ");
            console::say(&format!("  about {known} left for one thread, and the {unknown}, of which none is done yet"));
        }
        (None, None) => console::say("  too little is done to say how long the rest will take"),
    }
    if campaign.state == CampaignState::Stopped && !campaign.command.is_empty() {
        // A shard makes a part of the tasks, and other shards may write elsewhere.
        let of_shard = campaign.command.split(' ').any(|word| word.starts_with("--shard"));
        let command = &campaign.command;
        console::say(&match (of_shard, campaign.is_command_done) {
            (true, true) => {
                format!("  the shard of `{command}` is finished; `falsify merge` names the shards that are missing")
            }
            (true, false) => {
                format!("  go on with this shard: {command}; `falsify merge` names the shards that are missing")
            }
            (false, _) => format!("  go on with: {command}"),
        });
    }
}

/// What is stored of a task, and how long ago it was saved.
fn saved(task: &TaskStatus) -> String {
    let ago = task.written.and_then(|written| SystemTime::now().duration_since(written).ok());
    match ago {
        Some(ago) => {
            let share = (100 * task.done()).checked_div(task.amount).unwrap_or(0);
            format!(", {share} % of it saved {} s ago", ago.as_secs())
        }
        None => ", nothing saved yet".into(),
    }
}

fn clock(seconds: f64) -> FormattedDuration {
    FormattedDuration(Duration::from_secs_f64(seconds.max(0.0).ceil()))
}
