mod driver_pairs;
mod encounters;
mod meeting;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, value_parser};
use serde_json::json;

use super::causes::MAX_TOLD;
use super::compare::{Form, changes};
use super::condition::{self, Condition, Subject};
use super::episode::RepeatArgs;
use crate::cli::failure::{failed, misused, unwritten};
use crate::cli::input::{Reporter, session};
use crate::cli::progress::Showing;
use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
use crate::session::seconds;
use driver_pairs::DriverPair;
use results::report::{
    self, CrossedStarts, Encounter, Encounters, FailureChange, Gate, Judged, Recheck, RecheckNote, RecheckedFailures,
};
use verdict::cause::explain_any;

/// Maximum number of encounters in each list for people.
const MAX_SHOWN: usize = 3;

/// Starts in each town of the fixed list.
const STARTS: u32 = 20;
/// The smallest number of them that a gate may be about.
const MIN_GATED: u32 = 10;

pub const EXAMPLES: &str = "\
Examples:
  falsify recheck reports/my new.scn         the drivers of new.scn in the failures of a report, and in a fixed list
  falsify recheck reports/my --driver v1=v2  another driver of the same report
  falsify recheck reports/my --set 'v1.margin=1 m' --driver v1
                                             a driver of the report with another key
  falsify recheck reports/my --allow-external
                                             a program that was edited since the report was made
  falsify recheck reports/my --world metadrive
                                             the same drivers in another simulator: which faults survive
  falsify recheck reports/my new.scn --fail-if 'still_faults > 0' --fail-if 'faults_new > 0'
                                             block what is not fixed, and what is new
  falsify recheck reports/my new.scn --fail-if 'still_collisions_worse > 0' --fail-if 'injury_difference > 0'
                                             block what hits faster, and what injures more

Exit codes: 0 done   2 no report, or no such driver   3 errors in a scenario   5 a driver, a pedestrian or the world failed as a program
  7 a --fail-if condition is true, and nothing failed as a program   130 stopped by Ctrl-C: what was met up to then is shown";

/// Options of `falsify recheck`.
#[derive(Debug, Args)]
pub struct RecheckArgs {
    /// The old report.
    #[arg(value_name = "REPORT")]
    pub report: PathBuf,
    /// Scenario files whose campaigns have the new drivers and their cars; those of the report without any. Starts and pedestrians stay
    /// those of the report.
    #[arg(id = "new", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// A driver of the report and its new version, or one name for both; may be given several times. All drivers of equal names without it.
    #[arg(long = "driver", value_name = "OLD=NEW", value_parser = str::parse::<DriverPair>)]
    pub drivers: Vec<DriverPair>,
    /// Give a parameter or a key of the new drivers another value, as `v1.margin=1 m`.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub settings: Vec<String>,
    /// Another simulator in which the new drivers drive: a name of the Python package, as metadrive, or the command of a bridge.
    #[arg(long, value_name = "WORLD")]
    pub world: Option<String>,
    /// Time limit of the answer of `--world` to a tick, in seconds.
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = seconds, requires = "world")]
    pub timeout: f64,
    /// Time limit of its greeting, of loading a town and of the start of an episode, in seconds.
    #[arg(long, default_value_t = 300.0, value_name = "SECONDS", value_parser = seconds, requires = "world")]
    pub start_timeout: f64,
    /// Meet at most N faults, and N collisions that are no fault or near misses, of each driver in each town, spread evenly over the report. A near miss
    /// is an episode without a touch whose smallest gap is below 1 m. Without it all collisions are met.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=100_000))]
    pub sample: Option<u32>,
    /// Meet this collision or near miss again, and no others; may be given several times.
    #[arg(long, value_name = "RUN:EPISODE")]
    pub only: Vec<String>,
    /// The number of starts in each town from which both drivers drive 120 episodes; 0 leaves these out. 20 by default, and 0 in another simulator.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(0..=100_000))]
    pub starts: Option<u32>,
    /// Form of the output; `json` is one object.
    #[arg(long, value_enum, default_value_t = Form::Text, value_name = "FORMAT")]
    pub format: Form,
    /// Also write a page (HTML).
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
    /// Form of the progress on the error stream.
    #[arg(long, value_enum, default_value_t = Showing::Auto, env = "FALSIFY_PROGRESS", value_name = "HOW")]
    pub progress: Showing,
    /// Fail (exit code 7) when this is true of failures that were met again, as 'still_collisions_worse > 0', or of the fixed list in a town, as
    /// 'faults_new > 0'; may be given several times.
    #[arg(long, value_name = "CONDITION")]
    pub fail_if: Vec<String>,
    /// Let a row pass that a condition cannot judge, since a column has no value there; without it such a row fails.
    #[arg(long)]
    pub allow_unjudged: bool,
    /// Options of the repetition of the report.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

pub fn recheck(options: &RecheckArgs) -> Ended {
    let tables = [report::rechecked_reference(), report::crossed_reference()];
    let conditions = Condition::parse_all(&options.fail_if, &tables, "recheck", options.allow_unjudged)?;
    check_starts(options)?;
    let reporter = Arc::new(Reporter::new(options.progress));
    interrupt::listen();
    let session = session(options.repeat.allow_external).with_observer(reporter.clone());
    process::allow_to_stop(true);
    let recheck = session.recheck(options).map_err(failed);
    process::allow_to_stop(false);
    reporter.end();
    let recheck = recheck?;
    match options.format {
        Form::Text => {
            let text = report::change_text(&report::recheck_report(&recheck), MAX_SHOWN, console::width());
            console::say(console::broken(&text, console::width()).trim_end());
        }
        Form::Json => console::say(&as_json(&recheck).to_string()),
    }
    if let Some(path) = &options.page {
        let page = report::change_page(&report::recheck_report(&recheck), &[]);
        report::write_file(path, page.as_bytes()).map_err(unwritten)?;
        console::note(&path.display().to_string());
    }
    if recheck.notes.iter().any(RecheckNote::is_stop) {
        if !conditions.is_empty() {
            console::fail("--fail-if: nothing is judged, since the recheck was stopped");
        }
        return Ok(ExitCode::Interrupted);
    }
    let judged = judge(&conditions, &recheck);
    let errors = recheck.errors();
    if errors > 0 {
        console::fail(&format!(
            "a driver, a pedestrian or the world failed as a program in {}, which are left out; `falsify check` tries one",
            console::count(errors as usize, "episode")
        ));
        return Err(ExitCode::RunFailed);
    }
    judged
}

/// Refuses conditions on a fixed list that is left out, or too short to pass any.
fn check_starts(options: &RecheckArgs) -> Result<(), ExitCode> {
    let starts = options.starts.unwrap_or(if options.world.is_some() { 0 } else { STARTS });
    let met = report::rechecked_reference();
    let about_list = options.fail_if.iter().find(|text| Gate::of_table(text, &met).is_err());
    match about_list {
        Some(text) if starts == 0 => Err(misused(format!(
            "--fail-if {text}: there is no fixed list without `--starts N`; failures that are met again have `still_collisions_worse`, \
             `still_faults` and `turned_faults`"
        ))),
        Some(text) if starts < MIN_GATED => Err(misused(format!(
            "--fail-if {text}: {} cannot show that a driver is no worse; give `--starts {MIN_GATED}` or more",
            console::count(starts as usize, "start")
        ))),
        _ => Ok(()),
    }
}

/// Judges a recheck and reports which conditions are true.
fn judge(conditions: &[Condition], recheck: &Recheck) -> Ended {
    let failures = Subject {
        judge: &|gate| {
            let judged = gate.judge(&report::rechecked_table(&recheck.failures));
            unless_in_error(judged, recheck.failures.iter().map(|row| &row.encounters))
        },
        titles: recheck.failures.iter().map(RecheckedFailures::title).collect(),
        things: "failures",
        // A report without failures has none that could be there still.
        is_idle: recheck.failures.is_empty(),
    };
    let crossings = Subject {
        judge: &|gate| {
            let judged = gate.judge(&report::crossed_table(&recheck.crossings));
            unless_in_error(judged, recheck.crossings.iter().map(|row| &row.encounters))
        },
        titles: recheck.crossings.iter().map(CrossedStarts::title).collect(),
        things: "fixed list",
        is_idle: false,
    };
    let failed = condition::judge(conditions, [failures, crossings], "recheck")?;
    tell_causes(&failed, recheck);
    let unsure = recheck.notes.iter().find(|note| matches!(note, RecheckNote::OtherNow { .. }));
    match unsure.filter(|_| failed.is_empty() && !conditions.is_empty()) {
        Some(note) => {
            console::fail(&format!(
                "--fail-if: nothing can be judged, since the old driver is not the one of the report: {note}"
            ));
            Ok(ExitCode::GateFailed)
        }
        None => Ok(ExitCode::of_gate(failed.is_empty())),
    }
}

/// Says why the new drivers have their worst faults in the rows that failed a gate: those that the old ones do not have first.
fn tell_causes(failed: &[String], recheck: &Recheck) {
    let met = recheck.failures.iter().map(|row| (row.title(), &row.encounters));
    let crossed = recheck.crossings.iter().map(|row| (row.title(), &row.encounters));
    let rows = met.chain(crossed).filter(|(title, _)| failed.contains(title));
    let mut faults: Vec<(String, &Encounter)> = rows
        .flat_map(|(title, encounters)| {
            encounters.valid().filter(|each| each.after.fault).map(move |each| (each.in_row(&title), each))
        })
        .collect();
    let speed = |encounter: &Encounter| encounter.after.impact_speed.unwrap_or(0.0);
    let was_fault = |encounter: &Encounter| encounter.before.is_some_and(|before| before.fault);
    faults.sort_by(|(_, one), (_, other)| {
        was_fault(one).cmp(&was_fault(other)).then(speed(other).total_cmp(&speed(one)))
    });
    // A failure is met by its pedestrian and by its commands.
    let mut names = BTreeSet::new();
    faults.retain(|(name, _)| names.insert(name.clone()));
    for (name, encounter) in faults.into_iter().take(MAX_TOLD) {
        let why = match &encounter.incident {
            None => "not asked why, since it happened in another simulator.".into(),
            Some(incident) => {
                explain_any(incident).map_or_else(|| "the failure does not repeat.".into(), |cause| cause.sentence())
            }
        };
        console::note(&format!("{name}: {why}"));
    }
}

/// What a gate finds in rows; one with episodes in error does not pass.
fn unless_in_error<'a>(judged: Vec<Judged>, rows: impl Iterator<Item = &'a Encounters>) -> Vec<Judged> {
    let known = |(judged, row): (Judged, &Encounters)| match (judged.fails(), row.errors()) {
        (false, errors @ 1..) if judged != Judged::Elsewhere => Judged::InError(errors),
        _ => judged,
    };
    judged.into_iter().zip(rows).map(known).collect()
}

/// Makes an object of a recheck, for programs.
fn as_json(recheck: &Recheck) -> serde_json::Value {
    let notes: Vec<String> = recheck.notes.iter().map(ToString::to_string).collect();
    let failures: Vec<FailureChange> = recheck.failures.iter().flat_map(RecheckedFailures::changes).collect();
    let crossings: Vec<FailureChange> = recheck.crossings.iter().flat_map(CrossedStarts::changes).collect();
    json!({
        "report": recheck.report.display().to_string(),
        "files": recheck.files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "notes": notes,
        "failures": report::json_rows(&report::rechecked_table(&recheck.failures)),
        "crossings": report::json_rows(&report::crossed_table(&recheck.crossings)),
        "failure_changes": changes(&failures),
        "crossing_changes": changes(&crossings),
    })
}
