use std::path::PathBuf;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::ending::quoted;
use super::exit_code::ExitCode;
use super::gate::GateOptions;
use super::input::{GivenOptions, session};
use super::output::Output;
use super::progress::{EventLine, Progress, Showing};
use super::seconds::seconds;
use super::shard::NamedShard;
use super::{console, ending, failure, gate, interrupt, list};
use crate::session::{
    self, CampaignOutcome, CampaignReport, Error, Event, Notice, Observer, RunReport, Session, ShardOptions,
    ShardReport, Ticks,
};
use results::campaign::Shard;
use results::report::Formats;
use results::store::Limits;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify run scenarios/*.scn                run all campaigns, reports go to reports/
  falsify run --smoke my.scn                 see in seconds whether everything works
  falsify run --list my.scn                  list what would be run and why, and what is stored
  falsify run --set 'ppo_paper.steps=10000' my.scn
  falsify run --fail-if 'preventable_rate > 0.05' --junit out.xml my.scn

Exit codes: see falsify --help";

/// Options of `falsify run`.
#[derive(Debug, Args)]
pub struct RunOptions {
    /// Scenario files; their campaigns are run in order.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Replacements of parts of the files.
    #[command(flatten)]
    pub given: GivenOptions,
    /// Folder for the reports, one folder in it for each campaign.
    #[arg(long, short, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR", help_heading = "Output")]
    pub out: PathBuf,
    /// Folder for finished and unfinished work, which several folders for reports may share. Without it, OUT/.falsify.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR", help_heading = "Work")]
    pub cache: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1, env = "FALSIFY_SEED", value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64), help_heading = "What runs")]
    pub seed: u64,
    /// Number of threads; results do not depend on it. 0: one for every core.
    #[arg(long, short = 'j', default_value_t = 0, env = "FALSIFY_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(..=256), allow_negative_numbers = true, help_heading = "Work")]
    pub threads: u16,
    /// File formats of the tables of a report.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TableFormat::Csv, TableFormat::Parquet], env = "FALSIFY_FORMATS", value_name = "FORMATS", help_heading = "Output")]
    pub formats: Vec<TableFormat>,
    /// Form of the output; `json` is one event a line (reports/README.md).
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT", help_heading = "Output")]
    pub format: Output,
    /// Form of the progress on the error stream.
    #[arg(long, value_enum, default_value_t = Showing::Auto, env = "FALSIFY_PROGRESS", value_name = "HOW", help_heading = "Output")]
    pub progress: Showing,
    /// List what would be run and why, and what is stored already; then stop.
    #[arg(long, help_heading = "What runs")]
    pub list: bool,
    /// Run only a quick check of the whole pipeline: one run, two updates, five episodes. Reports go to NAME-smoke.
    #[arg(long, help_heading = "What runs")]
    pub smoke: bool,
    /// Repeat all work, also what is stored.
    #[arg(long, help_heading = "What runs")]
    pub fresh: bool,
    /// Replace a finished report of another scenario, setting or seed. Without it such a report is an error.
    #[arg(long, help_heading = "Output")]
    pub replace: bool,
    /// Run one of several parts, as 3/16, and write no report; `auto/16` takes the number from SLURM_ARRAY_TASK_ID or
    /// JOB_COMPLETION_INDEX.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["fresh", "list", "ticks", "fail_if", "junit"], help_heading = "What runs")]
    pub shard: Option<NamedShard>,
    /// Of a shard, run only these tasks; other shards then find their results.
    #[arg(long, value_enum, value_name = "TASKS", requires = "shard", help_heading = "What runs")]
    pub only: Option<Only>,
    /// Seconds between saves of unfinished work: at most this much is lost when the program is killed.
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS", value_parser = seconds, help_heading = "Work")]
    pub checkpoint: f64,
    /// Stop a training, 10,000 episodes or a search after this time (s). It is then in error, and the next run continues it. With 0 it ends
    /// after one update, if that takes less than a second, or one episode.
    #[arg(long, alias = "cell-time", value_name = "SECONDS", help_heading = "Work")]
    pub task_time: Option<u64>,
    /// Stop them after this number of simulator ticks.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Work")]
    pub max_ticks: Option<u64>,
    /// Which episodes are also written tick by tick, as ticks.parquet; they are simulated once more for it.
    #[arg(long, value_enum, default_value_t = TickChoice::None, value_name = "WHICH", help_heading = "Output")]
    pub ticks: TickChoice,
    /// Also write the learning curves as event files for TensorBoard, a folder in DIR/CAMPAIGN for each training.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub tensorboard: Option<PathBuf>,
    /// Conditions under which it fails.
    #[command(flatten)]
    pub gate: GateOptions,
    /// Print help.
    #[arg(long, short, action = clap::ArgAction::HelpShort)]
    pub help: Option<bool>,
}

/// The part of a shard that is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Only {
    /// Its trainings, each in one shard.
    Trainings,
}

/// File formats of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
}

/// Which episodes a report holds tick by tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TickChoice {
    /// None.
    None,
    /// The collisions.
    Failures,
    /// All.
    All,
}

impl RunOptions {
    /// The same options for a session.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn wanted(&self) -> Result<session::RunOptions, ExitCode> {
        let threads = match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads.into(),
        };
        if let Some(reason) = process::refusal(threads) {
            console::fail(&reason);
            return Err(ExitCode::Usage);
        }
        let named = |format| self.formats.contains(&format);
        Ok(session::RunOptions {
            input: self.given.input(&self.files),
            out: self.out.clone(),
            cache: self.cache.clone(),
            seed: self.seed,
            threads: self.threads,
            formats: Formats { csv: named(TableFormat::Csv), parquet: named(TableFormat::Parquet) },
            smoke: self.smoke,
            fresh: self.fresh,
            replace: self.replace,
            limits: Limits {
                checkpoint: Duration::from_secs_f64(self.checkpoint),
                seconds: self.task_time,
                ticks: self.max_ticks,
            },
            ticks: match self.ticks {
                TickChoice::None => Ticks::None,
                TickChoice::Failures => Ticks::Failures,
                TickChoice::All => Ticks::All,
            },
            tensorboard: self.tensorboard.clone(),
            gates: self.gate.gates()?,
            command: command_line(),
        })
    }

    /// The observer of a run with these options.
    pub fn reporter(&self) -> RunReporter {
        RunReporter { output: self.format, showing: self.progress, progress: RwLock::default() }
    }
}

/// The command of this process as a user would type it again.
fn command_line() -> String {
    let words = std::env::args().skip(1).map(|word| quoted(&word));
    std::iter::once("falsify".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}

/// `falsify run`
pub fn run(options: &RunOptions) -> ExitCode {
    ended(options.format, run_or_list(options).unwrap_or_else(|code| code))
}

/// Reports the exit code of a command to programs.
pub fn ended(output: Output, code: ExitCode) -> ExitCode {
    if output == Output::Json {
        EventLine::RunEnded { exit_code: code as u8 }.tell();
    }
    code
}

fn run_or_list(options: &RunOptions) -> Result<ExitCode, ExitCode> {
    let wanted = options.wanted()?;
    let session = session(options.given.allow_external).with_observer(Arc::new(options.reporter()));
    let failed = |error: Error| failure::failed(&error);
    if options.list {
        session.list(&wanted).map_err(failed)?.iter().for_each(list::list);
        return Ok(ExitCode::Done);
    }
    let Some(shard) = options.shard else {
        let run = session.run(&wanted).map_err(failed)?;
        return finished(options, &run);
    };
    let shard = shard.resolve(|name| std::env::var(name).ok()).map_err(|error| {
        console::fail(&error.to_string());
        ExitCode::Usage
    })?;
    run_shard(options, &session, &wanted, shard).map_err(failed)
}

/// Writes the report for a server of continuous integration, and chooses the exit code of a run.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn finished(options: &RunOptions, run: &RunReport) -> Result<ExitCode, ExitCode> {
    options.gate.write(run)?;
    if let Some(overview) = &run.overview {
        match options.format {
            Output::Human => ending::show_overview(overview),
            Output::Json => EventLine::OverviewWritten { page: &overview.page }.tell(),
        }
    }
    if run.interrupted {
        return Ok(ExitCode::Interrupted);
    }
    let mut codes = run.campaigns.iter().map(|outcome| match outcome {
        CampaignOutcome::Empty { interrupted: true, .. } => ExitCode::Interrupted,
        CampaignOutcome::Empty { interrupted: false, .. } => ExitCode::RunFailed,
        CampaignOutcome::Reported(report) if !report.is_sound() => ExitCode::RunFailed,
        CampaignOutcome::Reported(report) if !report.passes() => ExitCode::GateFailed,
        CampaignOutcome::Reported(_) => ExitCode::Done,
    });
    // The last campaign that did not pass decides the exit code.
    let ended = codes.rfind(|code| *code != ExitCode::Done).unwrap_or(ExitCode::Done);
    let compared = options.gate.compare(run, options.format);
    Ok(if ended == ExitCode::Done { compared } else { ended })
}

fn run_shard(
    options: &RunOptions,
    session: &Session,
    wanted: &session::RunOptions,
    shard: Shard,
) -> Result<ExitCode, Error> {
    let part = ShardOptions { shard, only_trainings: options.only == Some(Only::Trainings) };
    let reports = session.run_shard(wanted, &part)?;
    let whole = reports.iter().all(|report| report.finished == report.all);
    Ok(match (interrupt::stop().is_asked(), whole) {
        (true, _) => ExitCode::Interrupted,
        (false, true) => ExitCode::Done,
        (false, false) => ExitCode::RunFailed,
    })
}

/// Shows the progress of a run, its problems and its reports.
pub struct RunReporter {
    output: Output,
    showing: Showing,
    /// The progress of the tasks that are under way.
    progress: RwLock<Option<Progress>>,
}

impl Observer for RunReporter {
    fn event(&self, event: &Event<'_>) {
        match *event {
            Event::Diagnostics(diagnostics, sources) => console::show(diagnostics, sources),
            Event::Notice(notice) => self.notice(notice),
            Event::Begun => interrupt::listen(),
            Event::TasksBegun(campaign, tasks) => {
                let progress = Progress::new(campaign, tasks, self.showing, self.output, interrupt::stop());
                self.set_progress(Some(progress));
            }
            Event::CurvesGrow(folder) => self.progress(|progress| progress.curves_grow(folder)),
            Event::Campaign(event) => self.progress(|progress| progress.follow(event)),
            Event::TasksEnded => self.set_progress(None),
            Event::ShardEnded(report) => {
                if self.output == Output::Human {
                    let ShardReport { shard: Shard { index, count }, name, finished, all } = report;
                    console::say(&format!("{name}, shard {index} of {count}: {finished} of {all} tasks are there"));
                }
            }
            Event::Ended(CampaignOutcome::Empty { .. }) => console::fail("nothing was finished, so there is no report"),
            Event::Ended(CampaignOutcome::Reported(report)) => self.reported(report),
        }
    }
}

impl RunReporter {
    fn notice(&self, notice: &Notice) {
        failure::notice(notice);
        if let Notice::Unpaid { campaign, .. }
        | Notice::EpisodesInError { campaign, .. }
        | Notice::DoubtfulTraining { campaign, .. } = notice
            && self.output == Output::Json
        {
            EventLine::Warning { campaign, message: &notice.to_string() }.tell();
        }
    }

    fn set_progress(&self, progress: Option<Progress>) {
        *self.progress.write().unwrap_or_else(PoisonError::into_inner) = progress;
    }

    fn progress(&self, follow: impl FnOnce(&Progress)) {
        self.progress.read().unwrap_or_else(PoisonError::into_inner).as_ref().map(follow);
    }

    /// For people, prints the cells of a report, narrow enough for a terminal; for programs, prints its folder.
    fn reported(&self, report: &CampaignReport) {
        let CampaignReport { name, folder, manifest, .. } = report;
        match self.output {
            Output::Human => ending::show(report),
            Output::Json => EventLine::ReportWritten { campaign: name, folder, complete: manifest.complete }.tell(),
        }
        gate::show(report);
    }
}
