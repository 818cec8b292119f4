use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::choice::choice;
use crate::cli::console;
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{self, FoundFailure};
use results::report::{self, FailureFilter, FailureOrder, ListedFailure};

/// The number of failures that a table shows by default.
const SHOWN: usize = 20;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify failures                           the worst failures of reports/, fault ones first
  falsify failures reports/first_look --driver behavior --verdict preventable --top 5
                                             the five worst preventable ones of a driver
  falsify failures reports/first_look --distinct --names --top 5 | falsify replay -
                                             repeat the worst of five starts
  falsify failures reports/first_look --format csv > failures.csv
                                             all of them as a table

Exit codes: 0 done, also when there is none   2 no report";

/// Options of `falsify failures`.
#[derive(Debug, Args)]
pub struct FailuresArgs {
    /// Reports, or folders of reports.
    #[arg(value_name = "REPORT")]
    pub reports: Vec<PathBuf>,
    /// A report, or a folder of reports, where none is named.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR", conflicts_with = "reports")]
    pub report: PathBuf,
    /// Only failures with one of these verdicts: fault, foreseeable, preventable, contested, machine_preventable, unpreventable,
    /// bump, violation, no_verdict.
    #[arg(long, value_delimiter = ',', value_name = "VERDICT", value_parser = verdict)]
    pub verdict: Vec<String>,
    /// Only failures of these driving policies.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub driver: Vec<String>,
    /// Only failures that these controllers or falsifiers found.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub controller: Vec<String>,
    /// Only failures whose kind has all of these words, as front,occluded,cruise.
    #[arg(long, value_delimiter = ',', value_name = "WORDS")]
    pub kind: Vec<String>,
    /// Only violations of these requirements of the campaign.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub requirement: Vec<String>,
    /// Only failures in which the car was at least this fast at the touch (m/s).
    #[arg(long, default_value_t = 0.0, value_name = "SPEED")]
    pub min_speed: f64,
    /// The order.
    #[arg(long, default_value = "severity", value_name = "ORDER", value_parser = choice([
        ("severity", FailureOrder::Severity, "Fault first, then by verdict; in each the fastest first"),
        ("speed", FailureOrder::Speed, "The fastest first"),
        ("time", FailureOrder::Time, "The shortest time to the touch first"),
        ("report", FailureOrder::Report, "As in the report"),
    ]))]
    pub sort: FailureOrder,
    /// The number of failures; a table has 20 without it, other forms have all.
    #[arg(long, value_name = "N")]
    pub top: Option<usize>,
    /// Only the first failure of each start of a town and driver.
    #[arg(long)]
    pub distinct: bool,
    /// Form of the list.
    #[arg(long, value_enum, default_value_t = Form::Table, value_name = "FORMAT")]
    pub format: Form,
    /// Print one `REPORT/RUN:EPISODE` a line, for other commands.
    #[arg(long, conflicts_with = "format")]
    pub names: bool,
}

/// The form of a list of failures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// A table for people.
    Table,
    /// One JSON object a line.
    Json,
    /// Comma-separated values.
    Csv,
}

fn verdict(text: &str) -> Result<String, String> {
    let known: Vec<&str> = FailureFilter::verdict_names().collect();
    if known.contains(&text) { Ok(text.into()) } else { Err(format!("write one of {}", known.join(", "))) }
}

/// `falsify failures`
pub fn failures(options: &FailuresArgs) -> Ended {
    let named = !options.reports.is_empty();
    let wanted = session::FailuresOptions {
        reports: if named { options.reports.clone() } else { vec![options.report.clone()] },
        filter: FailureFilter {
            verdicts: options.verdict.clone(),
            drivers: options.driver.clone(),
            controllers: options.controller.clone(),
            kind: options.kind.clone(),
            requirements: options.requirement.clone(),
            min_speed: options.min_speed,
        },
        distinct: options.distinct,
        order: options.sort,
    };
    let found = session(false).failures(&wanted).map_err(failed)?;
    let is_table = options.format == Form::Table && !options.names;
    let shown = options.top.unwrap_or(if is_table { SHOWN } else { usize::MAX });
    let all = found.len();
    let listed = found.into_iter().take(shown).map(|FoundFailure { report, failure }| (report, failure));
    let listed: Vec<(PathBuf, ListedFailure)> = listed.collect();
    match options.format {
        _ if options.names => {
            listed
                .iter()
                .for_each(|(folder, failure)| console::say(&folder.join(failure.name()).display().to_string()));
        }
        Form::Table => tell(&listed, all),
        Form::Json => console::say_objects(&report::json_rows(&report::failure_list(&listed))),
        Form::Csv => console::say(report::csv_text(&report::failure_list(&listed)).trim_end()),
    }
    Ok(ExitCode::Done)
}

/// Prints a table for people, how much it leaves out, and how to see the first failure again.
fn tell(listed: &[(PathBuf, ListedFailure)], all: usize) {
    let Some((folder, first)) = listed.first() else {
        return console::say("no failure");
    };
    console::say(report::failures_for_terminal(listed, console::width()).trim_end());
    if listed.len() < all {
        console::say(&format!("{} of {all} failures; --top N shows more", listed.len()));
    }
    let options = report::StoredReport::open(folder).map_or("", |report| report.manifest().call.replay_options());
    console::say(&format!("falsify replay {options}{}", folder.join(first.name()).display()));
}
