use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use serde_json::json;

use super::episode::RepeatArgs;
use super::failures::FailuresArgs;
use crate::cli::console;
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{EpisodeName, EpisodePath, Error, RepeatOptions, Repeated, Session, Source};
use results::parallel;
use verdict::cause::{Limit, MAX_RUNS, Plan, Shrunk};

/// Number of failures of a report that are shrunk by default.
const SHOWN: usize = 20;

pub const EXAMPLES: &str = "\
Examples:
  falsify shrink reports/first_look          the 20 worst failures of a report with the fewest commands
  falsify shrink 1a2b3c4d:17                 a failure of a report in reports/
  falsify replay 1a2b3c4d:17 --shrunk        repeat it so
  falsify export 1a2b3c4d:17 --shrunk --as xosc-1.3
                                             and give it away

A shrunk failure is of the same kind: it violates the same requirement, counts against the driver as much, and the car hits with the same side while the
driver does the same. No single removal of a command or another actor, no merge of commands and no step of one towards the natural walk (5 degrees or
0.1 m/s) keeps it.

Exit codes: 0 done   2 no such failure or report   8 a failure does not fail again";

/// Options of `falsify shrink`.
#[derive(Debug, Args)]
pub struct ShrinkArgs {
    /// Failures, or reports whose worst failures are meant.
    #[arg(value_name = "REPORT|[PATH/]RUN:EPISODE", required = true)]
    pub which: Vec<Which>,
    /// The report, or the folder of reports, of names without a path.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// The number of failures of each report, the worst first.
    #[arg(long, default_value_t = SHOWN, value_name = "N")]
    pub top: usize,
    /// Maximum number of runs for a failure.
    #[arg(long, default_value_t = MAX_RUNS, value_name = "N")]
    pub max_runs: u32,
    /// Print one JSON object a failure, for programs.
    #[arg(long)]
    pub json: bool,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

/// An argument of `falsify shrink`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Which {
    Failure(EpisodePath),
    Report(PathBuf),
}

impl FromStr for Which {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.parse().map_or_else(|_| Self::Report(text.into()), Self::Failure))
    }
}

impl Session {
    /// Shrinks failures, each with its report or a folder of reports, with at most this number of runs for each; a failure that cannot be repeated has
    /// the reason.
    ///
    /// # Errors
    /// A report cannot be read, or its scenario files cannot be compiled.
    pub fn shrink(
        &self,
        failures: &[(PathBuf, EpisodeName)],
        options: &RepeatOptions,
        max_runs: u32,
    ) -> Result<Vec<Result<Shrunk, Error>>, Error> {
        self.each_repeated(failures, options, |repeated| repeated.shrink(max_runs))
    }

    /// What a function makes of repeated failures, each with its report or a folder of reports. A failure that cannot be repeated has the reason.
    ///
    /// # Errors
    /// A report cannot be read, or its scenario files cannot be compiled.
    pub(crate) fn each_repeated<T: Send>(
        &self,
        failures: &[(PathBuf, EpisodeName)],
        options: &RepeatOptions,
        of: impl Fn(Repeated) -> Result<T, Error> + Sync,
    ) -> Result<Vec<Result<T, Error>>, Error> {
        let mut sources: Vec<Source> = Vec::new();
        let mut places = Vec::new();
        for (folder, name) in failures {
            let has = |source: &Source| source.report.folder() == folder;
            let place = match sources.iter().position(has) {
                Some(place) => place,
                None => {
                    let report = self.find(folder, *name)?;
                    report.check_for_repetition()?;
                    match sources.iter().position(|source| source.report.folder() == report.folder()) {
                        Some(place) => place,
                        None => {
                            sources.push(self.reopen(report, options)?);
                            sources.len() - 1
                        }
                    }
                }
            };
            places.push((place, *name));
        }
        Ok(parallel::map(&places, |(place, name)| of(sources[*place].repeat(*name)?)))
    }
}

pub fn shrink(options: &ShrinkArgs) -> Ended {
    let session = session(options.repeat.allow_external);
    let mut wanted = Vec::new();
    for which in &options.which {
        match which {
            Which::Failure(EpisodePath { report, name }) => {
                wanted.push((report.clone().unwrap_or_else(|| options.report.clone()), *name));
            }
            Which::Report(folder) => {
                let listed = FailuresArgs { reports: vec![folder.clone()], ..FailuresArgs::default() };
                for found in session.failures(&listed).map_err(failed)?.into_iter().take(options.top) {
                    let name = EpisodeName::of_table(found.failure.name()).map_err(failed)?;
                    wanted.push((found.report, name));
                }
            }
        }
    }
    if wanted.is_empty() && !options.json {
        console::say("no failure");
    }
    let shrunk = session.shrink(&wanted, &options.repeat.repeat, options.max_runs).map_err(failed)?;
    let mut code = ExitCode::Done;
    for ((_, name), shrunk) in wanted.into_iter().zip(shrunk) {
        match shrunk {
            Ok(shrunk) if options.json => console::say_object(&as_json(name, &shrunk)),
            Ok(shrunk) => tell(name, &shrunk),
            Err(error) => code = code.or(failed(error)),
        }
    }
    Ok(code)
}

/// Prints a failure for people: how it has shrunk, and the walk of each pedestrian.
fn tell(name: EpisodeName, shrunk: &Shrunk) {
    let Shrunk { counts: [before, now], runs, limit, incident, .. } = shrunk;
    let end = match limit {
        Limit::Minimal => "minimal",
        Limit::Budget => "not proved minimal: the budget of runs was used up, --max-runs raises it",
    };
    let likelier = match shrunk.likelier() {
        more if more >= 9.5 => format!("{} times likelier", short(more)),
        more if more > 1.05 => format!("{more:.1} times likelier"),
        more if more > 0.95 => "as likely".to_string(),
        less => format!("{} times less likely", short(1.0 / less)),
    };
    let without = shrunk.without();
    console::say(&format!(
        "{name}  {before} → {now} commands{without}, {likelier} among natural walks, {runs} runs, {end}"
    ));
    let (rule, roles) = (&incident.scenario.episode, &incident.scenario.cast.pedestrians);
    let plan = Plan::new(&incident.commands, roles.len());
    for (number, segments) in plan.pedestrians.iter().enumerate().filter(|(number, _)| !roles[*number].is_absent) {
        let mut time = 0.0;
        for segment in segments {
            let command = segment.command;
            let who = if number == 0 { String::new() } else { format!("pedestrian {number}: ") };
            let heading = command.heading.to_degrees();
            console::say(&format!("  {time:6.2} s  {who}{:.2} m/s towards {heading:.0}°", command.speed));
            time += segment.decisions as f64 * f64::from(rule.hold) * rule.tick;
        }
    }
}

/// A ratio with at most two digits.
fn short(ratio: f64) -> String {
    if ratio < 1e6 { format!("{ratio:.0}") } else { format!("{ratio:.0e}") }
}

/// A failure as an object, for programs.
fn as_json(name: EpisodeName, shrunk: &Shrunk) -> serde_json::Value {
    let Shrunk { counts, log_likelihoods, runs, limit, incident, rerun, .. } = shrunk;
    let commands = incident.commands.iter();
    let commands = commands.map(|command| json!({ "heading_rad": command.heading, "speed_mps": command.speed }));
    let (kind, _) = shrunk.class();
    json!({
        "name": name.to_string(),
        "commands_before": counts[0],
        "commands_now": counts[1],
        "without": shrunk.without.iter().map(|name| &**name).collect::<Vec<_>>(),
        "log_likelihood_before": log_likelihoods[0],
        "log_likelihood_now": log_likelihoods[1],
        "likelier": shrunk.likelier(),
        "runs": runs,
        "minimal": *limit == Limit::Minimal,
        "kind": format!("{kind}"),
        "start": incident.start,
        "impact_speed_mps": rerun.outcome.impact_speed(),
        "digest": format!("{:016x}", rerun.outcome.digest),
        "commands": commands.collect::<Vec<_>>(),
    })
}
