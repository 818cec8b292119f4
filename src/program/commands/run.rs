mod shard;
mod gate;
mod list;
mod summary;

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use clap::{Args, ValueEnum};

use crate::cli::failure::{failed, misused};
use crate::cli::input::{GivenArgs, refuse_overwriting, session};
use crate::cli::output::Output;
use crate::cli::progress::{EventLine, Progress, Showing, heartbeat};
use crate::cli::{console, failure, interrupt};
use crate::exit_code::{Ended, ExitCode};
use crate::session::{
    self, CampaignOutcome, CampaignReport, Error, Event, Notice, Observer, RunReport, Session, ShardReport,
};
use gate::GateArgs;
use results::campaign::Shard;
use shard::{NamedShard, ShardOptions};
pub(crate) use summary::quoted;

/// Maximum number of seeds of a call.
const MAX_SEEDS: u64 = 1_000;

pub const EXAMPLES: &str = "\
Examples:
  falsify run scenarios/*.scn                run all campaigns, reports go to reports/
  falsify run --smoke my.scn                 see in seconds whether everything works
  falsify run --seeds 1..4 my.scn            run it at four seeds and pool them
  falsify run --list my.scn                  list what would be run and why, and what is stored
  falsify run --set 'ppo_paper.steps=10000' my.scn
  falsify run --only first_look my.scn       run one campaign of several
  falsify run --fail-if 'preventable_rate > 0.05' --junit out.xml my.scn

Exit codes: see falsify --help";

/// Options of `falsify run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Scenario files; their campaigns are run in order.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Replacements of parts of the files.
    #[command(flatten)]
    pub given: GivenArgs,
    /// What a session does with them.
    #[command(flatten)]
    pub run: session::RunOptions,
    /// Run it at several seeds, as 1..4, and pool their reports, which are called NAME-seed-N; intervals come from four seeds on.
    #[arg(long, value_name = "A..B", value_parser = seeds, conflicts_with_all = ["shard", "seed"], help_heading = "What runs", display_order = 6)]
    pub seeds: Option<RangeInclusive<u64>>,
    /// Form of the output; `json` is one event a line (reports/README.md).
    // The help lists it behind --formats.
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT", help_heading = "Output", display_order = 8)]
    pub format: Output,
    /// Form of the progress on the error stream.
    #[arg(long, value_enum, default_value_t = Showing::Auto, env = "FALSIFY_PROGRESS", value_name = "HOW", help_heading = "Output", display_order = 9)]
    pub progress: Showing,
    /// Print all tables at the end, not only the drivers.
    #[arg(long, help_heading = "Output", display_order = 9)]
    pub details: bool,
    /// List what would be run and why, and what is stored already; then stop.
    // Behind --seed.
    #[arg(long, help_heading = "What runs", display_order = 6)]
    pub list: bool,
    /// Run one of several parts, as 3/16, and write no report; `auto/16` takes the number from SLURM_ARRAY_TASK_ID or
    /// JOB_COMPLETION_INDEX.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["fresh", "list", "fail_if", "junit"], help_heading = "What runs")]
    pub shard: Option<NamedShard>,
    /// Of a shard, run only these tasks; other shards then find their results.
    #[arg(long, value_enum, value_name = "TASKS", requires = "shard", help_heading = "What runs")]
    pub tasks: Option<OnlyTasks>,
    /// Conditions under which it fails.
    #[command(flatten)]
    pub gate: GateArgs,
    /// Print help.
    #[arg(long, short, action = clap::ArgAction::HelpShort)]
    pub help: Option<bool>,
}

/// The part of a shard that is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OnlyTasks {
    /// Its trainings, each in one shard.
    Trainings,
}

impl RunArgs {
    /// The same options for a session.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn wanted(&self) -> Result<session::RunOptions, ExitCode> {
        let threads = match self.run.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads.into(),
        };
        if let Some(reason) = process::refusal(threads) {
            return Err(misused(reason));
        }
        Ok(session::RunOptions {
            input: self.given.input(&self.files),
            seeds: self.seeds.clone(),
            gates: self.gate.gates()?,
            command: command_line(),
            ..self.run.clone()
        })
    }

    /// The observer of a run with these options.
    pub fn reporter(&self) -> RunReporter {
        let progress = Arc::default();
        heartbeat(&progress, |progress: &mut Option<Progress>| progress.iter_mut().for_each(Progress::beat));
        RunReporter { output: self.format, showing: self.progress, details: self.details, progress }
    }
}

/// Reads the first and the last of some seeds.
///
/// # Errors
/// Another text, as clap shows it to the user.
fn seeds(text: &str) -> Result<RangeInclusive<u64>, String> {
    let ends = text.split_once("..").map(|(first, last)| (first.parse::<u64>(), last.parse::<u64>()));
    match ends {
        Some((Ok(first), Ok(last))) if first < last && last <= i64::MAX as u64 && last - first < MAX_SEEDS => {
            Ok(first..=last)
        }
        _ => Err(format!("write the first and the last of two seeds or more, as 1..4, at most {MAX_SEEDS} of them")),
    }
}

/// The command of this process as a user would type it again.
fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy()));
    std::iter::once("falsify".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}

pub fn run(options: &RunArgs) -> Ended {
    ended(options.format, run_or_list(options))
}

/// Reports the exit code of a command to programs.
pub fn ended(output: Output, ended: Ended) -> Ended {
    if output == Output::Json {
        let (Ok(code) | Err(code)) = ended;
        EventLine::RunEnded { exit_code: code as u8 }.tell();
    }
    ended
}

fn run_or_list(options: &RunArgs) -> Ended {
    let wanted = options.wanted()?;
    refuse_overwriting(&[options.gate.junit.as_ref()], &options.files)?;
    let session = session(options.given.allow_external).with_observer(Arc::new(options.reporter()));
    if options.list {
        let seeds = wanted.seeds.clone().unwrap_or(wanted.seed..=wanted.seed);
        let mut each = seeds.map(|seed| session::RunOptions { seed, ..wanted.clone() });
        each.try_for_each(|wanted| list::list(&session, &wanted)).map_err(failed)?;
        return Ok(ExitCode::Done);
    }
    let Some(shard) = options.shard else {
        let run = session.run(&wanted).map_err(failed)?;
        return finished(options, &run);
    };
    let shard = shard.resolve(|name| std::env::var(name).ok()).map_err(misused)?;
    let ended = run_shard(options, &session, &wanted, shard).map_err(failed)?;
    failure::programs(None);
    Ok(ended)
}

/// Writes the report for a server of continuous integration, and chooses the exit code of a run.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn finished(options: &RunArgs, run: &RunReport) -> Ended {
    options.gate.write(run)?;
    if let Some(overview) = &run.overview {
        match options.format {
            Output::Human => summary::show_overview(overview),
            Output::Json => EventLine::OverviewWritten { page: &overview.page }.tell(),
        }
    }
    failure::programs(Some(run.reports().map(|report| report.manifest.errors).sum()));
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
    Ok(ended.or(compared))
}

fn run_shard(
    options: &RunArgs,
    session: &Session,
    wanted: &session::RunOptions,
    shard: Shard,
) -> Result<ExitCode, Error> {
    let part = ShardOptions { shard, only_trainings: options.tasks == Some(OnlyTasks::Trainings) };
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
    /// Whether all tables are printed.
    details: bool,
    /// The progress of the tasks that are under way.
    progress: Arc<Mutex<Option<Progress>>>,
}

impl Observer for RunReporter {
    fn event(&self, event: &Event<'_>) {
        match *event {
            Event::Diagnostics(diagnostics, sources) => console::show(diagnostics, sources),
            Event::Notice(notice) => self.notice(notice),
            Event::Begun => interrupt::listen(),
            Event::TasksBegun(campaign, tasks) => {
                let progress = Progress::new(campaign, tasks, self.showing, self.output, interrupt::stop());
                *self.progress() = Some(progress);
                process::allow_to_stop(true);
            }
            Event::CurvesGrow(folder) => self.progress().iter().for_each(|progress| progress.curves_grow(folder)),
            Event::Campaign(event) => self.progress().iter_mut().for_each(|progress| progress.follow(event)),
            Event::TasksEnded => {
                process::allow_to_stop(false);
                *self.progress() = None;
            }
            Event::Played { .. } => {}
            Event::ShardEnded(report) => {
                if self.output == Output::Human {
                    let ShardReport { shard: Shard { index, count }, name, finished, all } = report;
                    let said = match all {
                        0 => "it has no task, since the campaign has fewer tasks than shards".to_owned(),
                        _ => format!("{finished} of {all} tasks are there"),
                    };
                    console::say(&format!("{name}, shard {index} of {count}: {said}"));
                }
            }
            Event::Ended(CampaignOutcome::Empty { interrupted, .. }) => console::fail(if *interrupted {
                "nothing was finished, so there is no report yet; the same command goes on from here"
            } else {
                "nothing was finished, so there is no report"
            }),
            Event::Ended(CampaignOutcome::Reported(report)) => self.reported(report),
        }
    }
}

impl RunReporter {
    fn notice(&self, notice: &Notice) {
        failure::notice(notice);
        if let Notice::Unpaid { campaign, .. }
        | Notice::EpisodesInError { campaign, .. }
        | Notice::DoubtfulTraining { campaign, .. }
        | Notice::Caution { campaign, .. } = notice
            && self.output == Output::Json
        {
            EventLine::Warning { campaign, message: &notice.to_string() }.tell();
        }
    }

    fn progress(&self) -> MutexGuard<'_, Option<Progress>> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For people, prints the cells of a report, narrow enough for a terminal; for programs, prints its folder.
    fn reported(&self, report: &CampaignReport) {
        let &CampaignReport { ref name, ref folder, ref manifest, tasks, reused, .. } = report;
        match self.output {
            Output::Human => summary::show(report, self.details),
            Output::Json => {
                EventLine::ReportWritten { campaign: name, folder, complete: manifest.complete, tasks, reused }.tell();
            }
        }
        gate::show(report);
        if reused > 0 {
            console::note(&format!(
                "{reused} of {tasks} results were stored before and not made by this run; --fresh makes them again"
            ));
        }
    }
}
