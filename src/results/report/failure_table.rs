//! The table of failures, of evaluations and searches alike, and failures as a list.

use std::collections::BTreeMap;
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsError, PolarsResult};

use super::aggregate::{INSTANT, PART, ROBUSTNESS, ROBUSTNESS_UNIT};
use crate::failure::{Failure, FoundBy, Violation};
use crate::record::columns::{
    COUNTS_AS, DIGEST, DRIVER, DRIVING_MODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, IN_SIGHT,
    LATEST_REACTION, NUMBER, ON_CROSSWALK, PEDESTRIAN, RESTS_ON, REWARD, RUN_ID, STATE_HASHES, TOWN, TRAIN_DRIVER,
    TRAIN_TOWN, VERDICT, WORLD,
};
use crate::record::{Column, Entry, RunKey, Signed, Table, columns, entries};
use crate::tables::REQUIREMENT;
use compile::{NoRunId, RunId};
use episode::Impact;
use verdict::cause::{Around, Cause};
use verdict::{Class, Label, RestsOn};
use world::av::DrivingMode;
use world::sim::WalkCommand;

/// The stem of the files of the table of failures.
pub const FAILURES: &str = "failures";

columns! {
    /// number of its start: that of the episode, or that which a search gave it
    START: Column<u64> = "start_number";
    /// simulator ticks that the search had used, the failure's own included; missing of an evaluation
    FOUND_AFTER: Column<u64> = "found_after_ticks";
    /// of a search `heading@speed` in rad and m/s, one for each decision, in the world frame; equal seeds, starts and commands give equal digests
    COMMANDS: Column<String> = "commands";
    /// rank of the requirement; 1 is the most important
    PRIORITY: Column<u32> = "priority";
    /// of a violation, whether a collision decides, which is a failure by itself
    AT_COLLISION: Column<bool> = "at_collision";
    /// of a violation, whether all careful drivers satisfy the requirement from the start of the danger on; missing where the requirement has no verdict
    PREVENTABLE: Column<bool> = "preventable";
}
/// The table of failures: collisions and bumps of evaluations and violations in them, then what searches found.
pub fn failure_table() -> Table<'static, Failure> {
    let doc = "One row for each collision and each bump of an evaluation that counts, each violation of a requirement, and each failure that a search found, with the commands that lead to it. \
               Its `run_id` and `number` are `run_id` and `episode` in `episodes`; the `run_id` of a search is in `searches`.";
    Table::new(FAILURES, doc)
        .columns(entries! { row: &Failure;
            RUN_ID = row.key.id.to_string();
            NUMBER = row.number;
            TOWN = row.key.cell.town.clone();
            DRIVER = row.key.cell.policy.clone();
            WORLD = row.key.cell.simulator().to_owned();
        })
        .columns(what_happened(|row| row))
        .columns(entries! { row: &Failure;
            START = row.start;
            FOUND_AFTER = row.is_of_search().then_some(row.found_after);
            COMMANDS = row.is_of_search().then(|| commands_text(&row.commands));
            DIGEST = (row.digest != 0).then(|| format!("{:016x}", row.digest));
            STATE_HASHES = row.state_hashes.clone();
        })
}

/// The columns of a failure that tell what happened.
fn what_happened<'t, R: 't>(failure: impl Fn(&R) -> &Failure + Copy + 't) -> Vec<Entry<'t, R>> {
    let violation = move |row: &R| failure(row).violation.clone();
    let has_verdict = move |row: &R| violation(row).is_none_or(|found| found.preventable.is_some());
    vec![
        VERDICT.of(move |row| failure(row).verdict.map(Label::name)),
        FORESEEABLE.of(move |row| (has_verdict(row) && !failure(row).is_bump()).then_some(failure(row).foreseeable)),
        FAULT.of(move |row| has_verdict(row).then_some(failure(row).fault)),
        COUNTS_AS.of(move |row| failure(row).counts_as.map(Class::name)),
        RESTS_ON.of(move |row| failure(row).rests_on.map(RestsOn::name)),
        LATEST_REACTION.of(move |row| failure(row).latest_reaction),
        IN_SIGHT.of(move |row| failure(row).in_sight),
        IMPACT.of(move |row| failure(row).impact.map(Impact::name)),
        IMPACT_SPEED.of(move |row| failure(row).impact.map(|_| failure(row).impact_speed)),
        ON_CROSSWALK.of(move |row| failure(row).on_crosswalk),
        DRIVING_MODE.of(move |row| failure(row).driving_mode.map(DrivingMode::name)),
        EPISODE_LENGTH.of(move |row| failure(row).episode_length),
        REQUIREMENT.of(move |row| violation(row).map(|found| found.requirement)),
        PRIORITY.of(move |row| violation(row).map(|found| found.priority)),
        ROBUSTNESS.of(move |row| Signed(violation(row).map(|found| found.robustness))),
        ROBUSTNESS_UNIT.of(move |row| violation(row).map(|found| found.unit)),
        INSTANT.of(move |row| violation(row).map(|_| failure(row).length)),
        PART.of(move |row| violation(row).map(|found| found.part)),
        AT_COLLISION.of(move |row| violation(row).map(|found| found.at_collision)),
        PREVENTABLE.of(move |row| violation(row)?.preventable),
    ]
}

/// Commands as `heading@speed` (rad, m/s), with all digits that are needed to read the same numbers back.
fn commands_text(commands: &[WalkCommand]) -> String {
    let each = commands.iter().map(|command| format!("{}@{}", command.heading, command.speed));
    each.collect::<Vec<_>>().join(" ")
}

/// Commands as a table has them; `None` if they are damaged.
fn commands(text: &str) -> Option<Vec<WalkCommand>> {
    let finite = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
    let command = |text: &str| {
        let (heading, speed) = text.split_once('@')?;
        Some(WalkCommand { heading: finite(heading)?, speed: finite(speed)? })
    };
    text.split_whitespace().map(command).collect()
}

/// The failures of a part of the table, with the keys of evaluations and searches; those of an unknown run are a search's, with its name alone.
///
/// # Errors
/// A column is missing or holds something else.
pub fn read_failures(rows: &DataFrame, keys: &BTreeMap<RunId, (RunKey, FoundBy)>) -> PolarsResult<Vec<Failure>> {
    (0..rows.height()).map(|row| Row(rows, row).failure(keys)).collect()
}

/// A row of a table.
#[derive(Clone, Copy)]
pub(super) struct Row<'a>(pub &'a DataFrame, pub usize);

impl Row<'_> {
    pub fn text(self, column: &Column<String>) -> PolarsResult<String> {
        column.value(self.0, self.1).map(Option::unwrap_or_default)
    }

    pub fn count(self, column: &Column<u64>) -> PolarsResult<u64> {
        column.value(self.0, self.1).map(Option::unwrap_or_default)
    }

    pub fn holds(self, column: &Column<bool>) -> PolarsResult<bool> {
        column.value(self.0, self.1).map(|value| value == Some(true))
    }

    pub fn run_id(self) -> PolarsResult<RunId> {
        let no_run = |error: NoRunId| PolarsError::ComputeError(error.to_string().into());
        self.text(&RUN_ID)?.parse().map_err(no_run)
    }

    /// The key of its run, and which kind that is.
    pub fn key(self, keys: &BTreeMap<RunId, (RunKey, FoundBy)>) -> PolarsResult<(RunKey, FoundBy)> {
        let id = self.run_id()?;
        let unknown = || (RunKey { id, ..RunKey::default() }, FoundBy::Search);
        Ok(keys.get(&id).cloned().unwrap_or_else(unknown))
    }

    fn failure(self, keys: &BTreeMap<RunId, (RunKey, FoundBy)>) -> PolarsResult<Failure> {
        let Self(table, row) = self;
        let (key, found_by) = self.key(keys)?;
        let violation = self.violation()?;
        let episode_length = EPISODE_LENGTH.value(table, row)?;
        let instant = INSTANT.value(table, row)?.filter(|_| violation.is_some());
        Ok(Failure {
            start: self.count(&START)?,
            commands: commands(&self.text(&COMMANDS)?).unwrap_or_default(),
            found_after: self.count(&FOUND_AFTER)?,
            digest: u64::from_str_radix(&self.text(&DIGEST)?, 16).unwrap_or_default(),
            verdict: Label::named(&self.text(&VERDICT)?),
            foreseeable: self.holds(&FORESEEABLE)?,
            fault: self.holds(&FAULT)?,
            counts_as: Class::named(&self.text(&COUNTS_AS)?),
            rests_on: RestsOn::named(&self.text(&RESTS_ON)?),
            latest_reaction: LATEST_REACTION.value(table, row)?,
            in_sight: IN_SIGHT.value(table, row)?,
            on_crosswalk: ON_CROSSWALK.value(table, row)?,
            state_hashes: self.text(&STATE_HASHES)?,
            impact: Impact::named(&self.text(&IMPACT)?),
            driving_mode: DrivingMode::named(&self.text(&DRIVING_MODE)?),
            impact_speed: IMPACT_SPEED.value(table, row)?.unwrap_or_default(),
            length: instant.or(episode_length).unwrap_or_default(),
            episode_length,
            violation,
            ..Failure::new(key, found_by, self.count(&NUMBER)?)
        })
    }

    fn violation(self) -> PolarsResult<Option<Violation>> {
        let Self(table, row) = self;
        let Some(requirement) = REQUIREMENT.value(table, row)? else { return Ok(None) };
        Ok(Some(Violation {
            requirement,
            priority: PRIORITY.value(table, row)?.unwrap_or_default(),
            robustness: ROBUSTNESS.value(table, row)?.unwrap_or_default(),
            unit: self.text(&ROBUSTNESS_UNIT)?,
            part: self.text(&PART)?,
            at_collision: self.holds(&AT_COLLISION)?,
            preventable: PREVENTABLE.value(table, row)?,
        }))
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct ListedFailure {
    /// The folder of its report.
    pub report: PathBuf,
    pub failure: Failure,
    /// The number of failures that shrink to it, itself included; `None` if they are not merged.
    pub merged: Option<u64>,
    /// Why it happened; `None` if that was not asked or is not known.
    pub cause: Option<Cause>,
    /// Which starts around it fail; `None` if that was not asked or is not known.
    pub around: Option<Around>,
}

/// Failures with the folders of their reports as a table, one row each, in the order given.
pub fn failure_list(failures: &[ListedFailure]) -> DataFrame {
    let mut table = Table::new(FAILURES, "One row for each failure.")
        .columns(entries! { row: &ListedFailure;
            /// the path by which other commands find it
            name: String = format!("{}/{}", row.report.display(), row.failure.name());
            /// folder of the report
            report: String = row.report.display().to_string();
            RUN_ID = row.failure.key.id.to_string();
            NUMBER = row.failure.number;
            /// `evaluation` or `search`
            found_by: String = row.failure.found_by.name();
            DRIVER = row.failure.key.cell.policy.clone();
            PEDESTRIAN = row.failure.key.cell.controller.clone();
            REWARD = row.failure.key.cell.reward.clone();
            TRAIN_TOWN = row.failure.key.cell.train_town.clone();
            TRAIN_DRIVER = row.failure.key.cell.train_policy.clone();
            TOWN = row.failure.key.cell.town.clone();
            WORLD = row.failure.key.cell.simulator().to_owned();
        })
        .columns(what_happened(|row: &ListedFailure| &row.failure))
        .columns(entries! { row: &ListedFailure;
            /// number of failures that shrink to it, itself included; missing without --distinct
            merged: u64 = row.merged;
            /// what the driver lacks, a word; missing without --why
            weakness: String = row.cause.as_ref().map(|cause| cause.weakness.name());
            /// the side of the car that it does not watch enough, `left` or `right`; missing of other weaknesses
            side: String = row.cause.as_ref()?.side;
            /// the one or two weaknesses of which the repair of each alone avoids it; missing without --why
            enough: String = {
                let enough = &row.cause.as_ref()?.enough;
                Some(enough.iter().map(|weakness| weakness.name()).collect::<Vec<_>>().join(" "))
            };
            /// why the driver failed, a sentence; missing without --why
            cause: String = row.cause.as_ref().map(Cause::sentence);
            /// which starts around it fail, a sentence; missing without --why
            around: String = row.around.as_ref().map(Around::sentence);
        });
    if failures.iter().any(|each| each.failure.needs.is_some()) {
        table = table.columns(entries! { row: &ListedFailure;
            /// roles of the other actors that it needs, with a blank between two; missing if that was not asked
            needs: String = row.failure.needs.clone();
        });
    }
    table.frame(failures)
}
