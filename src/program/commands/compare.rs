use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::json;

use super::causes;
use super::condition::{self, Condition, Subject};
use super::episode::RepeatArgs;
use crate::cli::console;
use crate::cli::failure::{failed, misused, unwritten};
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{EpisodeName, Error};
use results::record::TableReference;
use results::report::{
    self, Caveat, ComparedCell, ComparedSearch, FailureChange, PlayedPair, ReportComparison, Side, StoredReport,
};

/// Maximum number of failures in each list for people.
const MAX_SHOWN: usize = 3;
/// Maximum number of changes that a page plays.
const MAX_PLAYED: usize = 12;

pub const EXAMPLES: &str = "\
Examples:
  falsify compare old/my new/my              two reports: rates, and which failures are new, worse, fixed, better, the same
  falsify compare reports/my --drivers v1 v2 two drivers of one report
  falsify compare reports/my --worlds here metadrive
                                             two simulators of one report: rates from the same starts
  falsify compare old/my new/my --page diff.html
                                             a page with both episodes of a change side by side
  falsify compare old/my new/my --fail-if 'fault_rate_p_holm < 0.05 and fault_rate_difference > 0'
                                             block a regression; a driver that did not change fails in at most 2.5 %
  falsify compare old/my new/my --fail-if 'worse_rate_p_holm < 0.05 and worse_rate_difference > 0'
                                             the same for collisions of both that are faster, or have become faults
  falsify compare old/my new/my --fail-if 'found_p_holm < 0.05 and found_difference > 0'
                                             the same for searches

Exit codes: 0 done   2 no report, or nothing can be compared   7 a --fail-if condition is true   8 an episode for the page differs";

/// Options of `falsify compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The report before and the report after; one report with --drivers or --worlds.
    #[arg(required = true, num_args = 1..=2, value_name = "REPORT")]
    pub reports: Vec<PathBuf>,
    /// The driver before and the one after.
    #[arg(long, num_args = 2, value_names = ["BEFORE", "AFTER"])]
    pub drivers: Option<Vec<String>>,
    /// The simulator before and the one after.
    #[arg(long, num_args = 2, value_names = ["BEFORE", "AFTER"])]
    pub worlds: Option<Vec<String>>,
    /// Form of the output; `json` is one object.
    #[arg(long, value_enum, default_value_t = Form::Text, value_name = "FORMAT")]
    pub format: Form,
    /// Also write a page (HTML) with both episodes of the worst changes side by side.
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
    /// Fail (exit code 7) when this is true of a place, driver and pedestrian, as 'fault_rate_p_holm < 0.05 and
    /// fault_rate_difference > 0', or of a search, as 'found_p_holm < 0.05 and found_difference > 0'; may be given several times. Columns
    /// `…_p_holm`, `…_low` and `…_high` are adjusted for all rows.
    #[arg(long, value_name = "CONDITION")]
    pub fail_if: Vec<String>,
    /// Let a row pass that a condition cannot judge, since a column has no value there; without it such a row fails.
    #[arg(long)]
    pub allow_unjudged: bool,
    /// Options of the repetition for the page.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

/// The form of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// Tables for people.
    Text,
    /// One JSON object.
    Json,
}

/// The tables of a comparison that conditions are about, with the columns of the requirements that these name.
pub fn tables(conditions: &[String]) -> [TableReference; 2] {
    let named: Vec<&str> = conditions.iter().flat_map(|text| report::requirements_in(text)).collect();
    [report::comparison_reference(&named), report::compared_search_table().reference()]
}

pub fn compare(options: &CompareArgs) -> Ended {
    let conditions =
        Condition::parse_all(&options.fail_if, &tables(&options.fail_if), "comparison", options.allow_unjudged)?;
    let two = |names: &Option<Vec<String>>| names.clone().and_then(|names| <[String; 2]>::try_from(names).ok());
    let [drivers, worlds] = [two(&options.drivers), two(&options.worlds)];
    let reports = match options.reports.as_slice() {
        [before, after] => [before.clone(), after.clone()],
        [one] if drivers.is_some() || worlds.is_some() => [one.clone(), one.clone()],
        _ => return Err(misused("name two reports, or one report and --drivers or --worlds BEFORE AFTER")),
    };
    let comparison = compared(&reports, [drivers.as_ref(), worlds.as_ref()]).map_err(failed)?;
    match options.format {
        Form::Text => console::say(&text(&comparison)),
        Form::Json => console::say(&as_json(&comparison).to_string()),
    }
    if let Some(path) = &options.page {
        write_page(&comparison, path, &options.repeat)?;
    }
    let failed = judge(&conditions, &comparison)?;
    tell_causes(&failed, &comparison, &options.repeat);
    tell_worse(&conditions, &failed, &comparison);
    Ok(ExitCode::of_gate(failed.is_empty()))
}

/// What people read in a terminal.
pub fn text(comparison: &ReportComparison) -> String {
    let width = console::width();
    let text = report::change_text(&report::comparison_report(comparison), MAX_SHOWN, width);
    console::broken(&text, width).trim_end().into()
}

/// Says that a driver is worse which no condition refuses.
pub fn tell_worse(conditions: &[Condition], failed: &[String], comparison: &ReportComparison) {
    let worse = report::worsening(comparison).filter(|_| !conditions.is_empty() && failed.is_empty());
    worse.iter().for_each(|answer| console::note(&format!("the conditions pass, but: {answer}")));
}

/// Says why the worst failures happened that are new or have become faults in rows that failed a gate.
pub fn tell_causes(failed: &[String], comparison: &ReportComparison, options: &RepeatArgs) {
    let searched = comparison.searches.iter().flat_map(|search| &search.changes);
    let all = comparison.changes.iter().chain(searched).filter(|change| failed.contains(&change.place));
    let all: Vec<FailureChange> = all.cloned().collect();
    let new = ["new", "worse"].into_iter().flat_map(|word| FailureChange::of_word(&all, word));
    causes::tell(&comparison.folders[1], new.map(|change| change.sides[1].name.clone()).collect(), options);
}

/// Judges a comparison, reports which conditions are true, and returns the titles of the rows of which one is.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn judge(conditions: &[Condition], comparison: &ReportComparison) -> Result<Vec<String>, ExitCode> {
    let is_alone = |caveat: &&Caveat| matches!(caveat, Caveat::LoneDrivers { .. });
    for caveat in comparison.caveats.iter().filter(is_alone).filter(|_| !conditions.is_empty()) {
        console::warn(&format!("--fail-if: {caveat}"));
    }
    if !conditions.is_empty() && comparison.caveats.contains(&Caveat::Same) {
        return Err(misused(format!("--fail-if: nothing can be judged, since {}", Caveat::Same)));
    }
    let cells = Subject {
        judge: &|gate| gate.judge(&report::compared_cells(comparison)),
        titles: comparison.cells.iter().map(ComparedCell::title).collect(),
        things: "place, driver and pedestrian",
        is_idle: false,
    };
    let searches = Subject {
        judge: &|gate| gate.judge(&report::compared_search_table().frame(&comparison.searches)),
        titles: comparison.searches.iter().map(ComparedSearch::title).collect(),
        things: "search",
        is_idle: false,
    };
    let mut failed = condition::judge(conditions, [cells, searches], "comparison")?;
    let errors = comparison.caveats.iter().find(|caveat| matches!(caveat, Caveat::Errors { .. }));
    if let Some(errors) = errors.filter(|_| failed.is_empty() && !conditions.is_empty()) {
        console::fail(&format!("--fail-if: {errors}"));
        failed.push(errors.to_string());
    }
    Ok(failed)
}

/// Compares two reports, or two drivers, or two simulators, over the starts that they share.
///
/// # Errors
/// A report cannot be read, or nothing can be compared.
pub fn compared(reports: &[PathBuf; 2], chosen: [Option<&[String; 2]>; 2]) -> Result<ReportComparison, Error> {
    let [before, after] = [StoredReport::open(&reports[0])?, StoredReport::open(&reports[1])?];
    for report in [&before, &after] {
        report.check_manifest()?;
        report.check_tables()?;
    }
    let [driver, world] = chosen.map(|names| move |side: usize| names.map(|names| names[side].as_str()));
    let first = Side { report: &before, driver: driver(0), world: world(0) };
    let second = Side { report: &after, driver: driver(1), world: world(1) };
    report::compare_reports(first, second).map_err(|error| Error::Usage(error.to_string()))
}

/// Writes a page that plays both episodes of the worst changes side by side.
fn write_page(comparison: &ReportComparison, path: &Path, options: &RepeatArgs) -> Result<(), ExitCode> {
    let chosen = FailureChange::worst(&comparison.changes, MAX_PLAYED);
    let pairs = played(comparison, &chosen, options).map_err(failed)?;
    let page = report::change_page(&report::comparison_report(comparison), &pairs);
    report::write_file(path, page.as_bytes()).map_err(unwritten)?;
    console::note(&path.display().to_string());
    Ok(())
}

/// Repeats both episodes of some changes.
fn played(
    comparison: &ReportComparison,
    changes: &[&FailureChange],
    options: &RepeatArgs,
) -> Result<Vec<PlayedPair>, Error> {
    if changes.is_empty() {
        return Ok(Vec::new());
    }
    let session = session(options.allow_external);
    let reopened = |folder: &PathBuf| session.reopen(StoredReport::open(folder)?, &options.repeat);
    let sources = [reopened(&comparison.folders[0])?, reopened(&comparison.folders[1])?];
    let play = |change: &&FailureChange| {
        let side = |side: usize| -> Result<report::Replay, Error> {
            let name = EpisodeName::of_table(change.sides[side].name.clone())?;
            let again = sources[side].repeat(name)?;
            Ok(report::Replay::of_episode(&again.scenario, &again.trace, &again.judged))
        };
        let command = |side: usize| {
            format!("falsify replay {}", comparison.folders[side].join(&change.sides[side].name).display())
        };
        let (replays, commands) = ([side(0)?, side(1)?], [command(0), command(1)]);
        Ok(PlayedPair { change: (*change).clone(), replays, commands })
    };
    changes.iter().map(play).collect()
}

/// Makes an object of a comparison, for programs.
fn as_json(comparison: &ReportComparison) -> serde_json::Value {
    let [before, after] = comparison.folders.each_ref().map(|folder| folder.display().to_string());
    let notes: Vec<String> = comparison.caveats.iter().map(ToString::to_string).collect();
    let cells = report::json_rows(&report::compared_cells(comparison));
    let searches = report::json_rows(&report::compared_search_table().frame(&comparison.searches));
    let found = comparison.searches.iter().flat_map(|search| &search.changes);
    json!({
        "before": before, "after": after, "notes": notes, "cells": cells, "failures": changes(&comparison.changes),
        "searches": searches, "starts": changes(found),
    })
}

/// Makes a list of changes, for programs.
pub fn changes<'a>(all: impl IntoIterator<Item = &'a FailureChange>) -> Vec<serde_json::Value> {
    let one = |change: &FailureChange| {
        let [before, after] = &change.sides;
        json!({ "change": change.word(), "where": change.place, "before": before, "after": after })
    };
    all.into_iter().map(one).collect()
}
