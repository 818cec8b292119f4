//! The failures of a report, of evaluations and searches alike, from its tables, and as a list.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsError, PolarsResult};

use super::{ReadError, StoredReport};
use crate::failure::{Failure, FoundBy, Violation, is_occluded};
use crate::record::columns::{
    CONTROLLER, DIGEST, DRIVING_MODE, EPISODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, IN_SIGHT,
    MIN_GAP, POLICY, REWARD, RUN_ID, TOWN, TRAIN_POLICY, TRAIN_TOWN, VERDICT,
};
use crate::record::{CellKey, Column, EPISODES, EpisodeTable, RunKey, Signed, Table};
use crate::report::actors::{ACTORS, NEEDED, NUMBER, ROLE};
use crate::report::aggregate::{
    APPLIES, AT_COLLISION, COMMANDS, COUNTS, FAILURE, FAILURES, FALSIFIER, FOUND_AFTER, GOAL_FAULT, GOAL_FORESEEABLE,
    GOAL_PREVENTABLE, INSTANT, NO_VERDICT, PART, PREVENTABLE, PRIORITY, REQUIREMENT, REQUIREMENTS, ROBUSTNESS,
    ROBUSTNESS_UNIT, SEARCH_BLOCK, SEARCH_RUN, SEARCHES, START, VIOLATED, VIOLATION_FAULT, VIOLATION_FORESEEABLE,
};
use compile::{NoRunId, RunId};
use world::av::DrivingMode;
use world::cause::{Around, Cause};
use world::env::Impact;
use world::judge::Label;
use world::sim::WalkCommand;

/// The number of rows of a table that are read at once.
const ROWS: usize = 1 << 17;

impl StoredReport {
    /// The names of the requirements that its table has degrees of: those of its evaluations, and the goals of its searches.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn requirements(&self) -> Result<BTreeSet<String>, ReadError> {
        let mut names = BTreeSet::new();
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            names.extend(REQUIREMENT.read(rows)?.iter().flatten().map(String::from));
            Ok(())
        })?;
        Ok(names)
    }

    /// The names of those that applied in an episode.
    ///
    /// # Errors
    /// As [`StoredReport::requirements`].
    pub fn applied_requirements(&self) -> Result<BTreeSet<String>, ReadError> {
        let mut names = BTreeSet::new();
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            let (requirement, applies) = (REQUIREMENT.read(rows)?, APPLIES.read(rows)?);
            let applied = requirement.iter().zip(applies.iter()).filter(|(_, applies)| *applies == Some(true));
            names.extend(applied.filter_map(|(name, _)| name.map(String::from)));
            Ok(())
        })?;
        Ok(names)
    }

    /// All failures: collisions of evaluations, those of searches, violations of requirements, each in the order of its table. Bumps are among them, and
    /// violations at the touch of a collision.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn failures(&self) -> Result<Vec<Failure>, ReadError> {
        let mut found = Vec::new();
        self.each_part(EPISODES, ROWS, |rows| {
            let table = EpisodeTable::new(rows)?;
            for row in table.rows().filter(|row| table.counts(*row) && table.is_touch(*row)) {
                found.push(Failure::of_row(&table, row, RunKey::read(rows, row)?));
            }
            Ok(())
        })?;
        let mut keys = BTreeMap::new();
        self.each_part(SEARCHES, ROWS, |rows| {
            (0..rows.height())
                .try_for_each(|row| search_key_of(Row(rows, row)).map(|key| drop(keys.insert(key.id, key))))
        })?;
        self.each_part(FAILURES, ROWS, |rows| {
            found.extend(searched(rows, &keys)?);
            Ok(())
        })?;
        let mut violated = Vec::new();
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            violated.extend(violations(rows)?);
            Ok(())
        })?;
        if !violated.is_empty() {
            let runs: BTreeMap<RunId, RunKey> = self.run_rows()?.into_iter().map(|run| (run.key.id, run.key)).collect();
            for found in &mut violated {
                found.key = runs.get(&found.key.id).unwrap_or(&found.key).clone();
            }
            self.add_lengths(&mut violated)?;
        }
        found.extend(violated);
        self.add_needs(&mut found)?;
        Ok(found)
    }

    /// Episodes of evaluations without a touch, in which the gap between car and pedestrian was smaller than this (m) at some time.
    ///
    /// # Errors
    /// As [`StoredReport::failures`].
    pub fn near_misses(&self, gap: f64) -> Result<Vec<Failure>, ReadError> {
        let mut found = Vec::new();
        self.each_part(EPISODES, ROWS, |rows| {
            let (table, gaps) = (EpisodeTable::new(rows)?, MIN_GAP.read(rows)?);
            let is_near = |row: usize| gaps.get(row).is_some_and(|smallest| smallest < gap);
            for row in table.rows().filter(|row| table.counts(*row) && !table.is_touch(*row) && is_near(*row)) {
                found.push(Failure::new(RunKey::read(rows, row)?, FoundBy::Evaluation, table.episode(row).into()));
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Adds which actors the failures of a cast need.
    fn add_needs(&self, failures: &mut [Failure]) -> Result<(), ReadError> {
        let mut needs: BTreeMap<(String, u64), Vec<String>> = BTreeMap::new();
        self.each_part(ACTORS, ROWS, |rows| {
            (0..rows.height()).try_for_each(|number| {
                let row = Row(rows, number);
                let named = needs.entry((row.text(&RUN_ID)?, row.count(&NUMBER)?)).or_default();
                let role = row.text(&ROLE)?;
                if row.holds(&NEEDED)? && !named.contains(&role) {
                    named.push(role);
                }
                Ok(())
            })
        })?;
        for failure in failures {
            failure.needs = needs.get(&(failure.key.id.to_string(), failure.number)).map(|roles| roles.join(" "));
        }
        Ok(())
    }

    /// Adds the lengths of their episodes to violations.
    fn add_lengths(&self, violations: &mut [Failure]) -> Result<(), ReadError> {
        let named: BTreeSet<(String, u64)> =
            violations.iter().map(|failure| (failure.key.id.to_string(), failure.number)).collect();
        let mut lengths = BTreeMap::new();
        self.each_part(EPISODES, ROWS, |rows| {
            let (ids, numbers) = (RUN_ID.read(rows)?, EPISODE.read(rows)?);
            let names = ids.iter().zip(numbers.iter()).enumerate();
            for (row, (id, number)) in names {
                let name = (id.unwrap_or_default().to_owned(), u64::from(number.unwrap_or_default()));
                if named.contains(&name) {
                    lengths.insert(name, EPISODE_LENGTH.value(rows, row)?);
                }
            }
            Ok(())
        })?;
        let length = |failure: &Failure| lengths.get(&(failure.key.id.to_string(), failure.number)).copied().flatten();
        violations.iter_mut().for_each(|failure| failure.episode_length = length(failure));
        Ok(())
    }
}

/// A row of a table.
#[derive(Clone, Copy)]
struct Row<'a>(&'a DataFrame, usize);

impl Row<'_> {
    fn text(self, column: &Column<String>) -> PolarsResult<String> {
        column.value(self.0, self.1).map(Option::unwrap_or_default)
    }

    fn count(self, column: &Column<u64>) -> PolarsResult<u64> {
        column.value(self.0, self.1).map(Option::unwrap_or_default)
    }

    fn number(self, column: &Column<f64>) -> PolarsResult<f64> {
        column.value(self.0, self.1).map(Option::unwrap_or_default)
    }

    fn holds(self, column: &Column<bool>) -> PolarsResult<bool> {
        column.value(self.0, self.1).map(|value| value == Some(true))
    }

    /// The violation, with the column of whether it is preventable.
    fn violation(self, preventable: &Column<bool>) -> PolarsResult<Violation> {
        Ok(Violation {
            requirement: self.text(&REQUIREMENT)?,
            priority: PRIORITY.value(self.0, self.1)?.unwrap_or_default(),
            robustness: self.number(&ROBUSTNESS)?,
            unit: self.text(&ROBUSTNESS_UNIT)?,
            part: self.text(&PART)?,
            at_collision: false,
            preventable: preventable.value(self.0, self.1)?,
            no_verdict: self.text(&NO_VERDICT)?,
        })
    }
}

/// The name of the run of a row.
fn run_id(row: Row<'_>) -> PolarsResult<RunId> {
    let no_run = |error: NoRunId| PolarsError::ComputeError(error.to_string().into());
    row.text(&RUN_ID)?.parse().map_err(no_run)
}

/// The key of a search, whose falsifier is the controller, in the table of searches.
fn search_key_of(row: Row<'_>) -> PolarsResult<RunKey> {
    let cell = CellKey {
        controller: row.text(&FALSIFIER)?,
        reward: row.text(&REWARD)?,
        town: row.text(&TOWN)?,
        policy: row.text(&POLICY)?,
        block: row.count(&SEARCH_BLOCK)? as u32,
        ..CellKey::default()
    };
    Ok(RunKey { id: run_id(row)?, cell, run: row.count(&SEARCH_RUN)? as u32 })
}

/// The failures of a part of the table of failures of searches, with the keys of the searches; a search without one has its name alone.
///
/// # Errors
/// A column is missing or holds something else.
pub fn searched(rows: &DataFrame, keys: &BTreeMap<RunId, RunKey>) -> PolarsResult<Vec<Failure>> {
    let has_goals = rows.get_column_index(REQUIREMENT.name).is_some();
    let failure = |number: usize| {
        let row = Row(rows, number);
        let id = run_id(row)?;
        let key = keys.get(&id).cloned().unwrap_or_else(|| RunKey { id, ..RunKey::default() });
        let found = Failure {
            start: row.count(&START)?,
            commands: commands(&row.text(&COMMANDS)?).unwrap_or_default(),
            found_after: row.count(&FOUND_AFTER)?,
            digest: u64::from_str_radix(&row.text(&DIGEST)?, 16).unwrap_or_default(),
            verdict: Label::named(&row.text(&VERDICT)?),
            foreseeable: row.holds(&FORESEEABLE)?,
            fault: row.holds(&FAULT)?,
            impact: Impact::named(&row.text(&IMPACT)?),
            occluded: is_occluded(IN_SIGHT.value(rows, number)?),
            driving_mode: DrivingMode::named(&row.text(&DRIVING_MODE)?),
            impact_speed: row.number(&IMPACT_SPEED)?,
            length: row.number(&EPISODE_LENGTH)?,
            episode_length: EPISODE_LENGTH.value(rows, number)?,
            ..Failure::new(key, FoundBy::Search, row.count(&FAILURE)?)
        };
        if !has_goals || REQUIREMENT.value(rows, number)?.is_none() {
            return Ok(found);
        }
        Ok(Failure {
            violation: Some(row.violation(&GOAL_PREVENTABLE)?),
            length: row.number(&INSTANT)?,
            foreseeable: row.holds(&GOAL_FORESEEABLE)?,
            fault: row.holds(&GOAL_FAULT)?,
            ..found
        })
    };
    (0..rows.height()).map(failure).collect()
}

/// Commands as a table has them, `heading@speed`; `None` if they are damaged.
fn commands(text: &str) -> Option<Vec<WalkCommand>> {
    let finite = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
    let command = |text: &str| {
        let (heading, speed) = text.split_once('@')?;
        Some(WalkCommand { heading: finite(heading)?, speed: finite(speed)? })
    };
    text.split_whitespace().map(command).collect()
}

/// The violations in a part of the table of requirements that count; of their runs the names alone are there.
///
/// # Errors
/// A column is missing or holds something else.
fn violations(rows: &DataFrame) -> PolarsResult<Vec<Failure>> {
    let (violated, counts) = (VIOLATED.read(rows)?, COUNTS.read(rows)?);
    let failure = |number: usize| {
        let row = Row(rows, number);
        let episode = EPISODE.value(rows, number)?.unwrap_or_default();
        let at_collision = row.holds(&AT_COLLISION)?;
        Ok(Failure {
            foreseeable: row.holds(&VIOLATION_FORESEEABLE)?,
            fault: row.holds(&VIOLATION_FAULT)?,
            length: row.number(&INSTANT)?,
            violation: Some(Violation { at_collision, ..row.violation(&PREVENTABLE)? }),
            ..Failure::new(RunKey { id: run_id(row)?, ..RunKey::default() }, FoundBy::Evaluation, episode.into())
        })
    };
    let wanted = |row: &usize| violated.get(*row) == Some(true) && counts.get(*row) == Some(true);
    (0..rows.height()).filter(wanted).map(failure).collect()
}

/// A failure of a list.
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
    type Listed = ListedFailure;
    let mut table = Table::<Listed>::new("failures", "One row for each failure.")
        .text("name", "the path by which other commands find it", |row| {
            format!("{}/{}", row.report.display(), row.failure.name())
        })
        .text("report", "folder of the report", |row| row.report.display().to_string())
        .column(RUN_ID.of(|row: &Listed| row.failure.key.id.to_string()))
        .column(NUMBER.of(|row: &Listed| row.failure.number))
        .text("found_by", "`evaluation` or `search`", |row| row.failure.found_by.name())
        .column(POLICY.of(|row: &Listed| row.failure.key.cell.policy.clone()))
        .column(CONTROLLER.of(|row: &Listed| row.failure.key.cell.controller.clone()))
        .column(REWARD.of(|row: &Listed| row.failure.key.cell.reward.clone()))
        .column(TRAIN_TOWN.of(|row: &Listed| row.failure.key.cell.train_town.clone()))
        .column(TRAIN_POLICY.of(|row: &Listed| row.failure.key.cell.train_policy.clone()))
        .column(TOWN.of(|row: &Listed| row.failure.key.cell.town.clone()))
        .column(VERDICT.of(|row: &Listed| row.failure.verdict.map(Label::name)))
        .column(FORESEEABLE.of(|row: &Listed| row.failure.foreseeable))
        .column(FAULT.of(|row: &Listed| row.failure.fault))
        .column(IMPACT.of(|row: &Listed| row.failure.impact.map_or("", Impact::name)))
        .column(
            Column::<bool>::new("occluded", "", "whether it came into sight too late for a careful human")
                .of(|row: &Listed| row.failure.occluded),
        )
        .column(DRIVING_MODE.of(|row: &Listed| row.failure.driving_mode.map_or("", DrivingMode::name)))
        .column(
            IMPACT_SPEED.of(|row: &Listed| Some(row.failure.impact_speed).filter(|_| row.failure.violation.is_none())),
        )
        .column(EPISODE_LENGTH.of(|row: &Listed| row.failure.episode_length))
        .column(REQUIREMENT.of(|row: &Listed| row.failure.violation.as_ref().map(|found| found.requirement.clone())))
        .column(ROBUSTNESS.of(|row: &Listed| Signed(row.failure.violation.as_ref().map(|found| found.robustness))))
        .column(ROBUSTNESS_UNIT.of(|row: &Listed| row.failure.violation.as_ref().map(|found| found.unit.clone())))
        .column(INSTANT.of(|row: &Listed| row.failure.violation.as_ref().map(|_| row.failure.length)))
        .column(PART.of(|row: &Listed| row.failure.violation.as_ref().map(|found| found.part.clone())))
        .column(PREVENTABLE.of(|row: &Listed| row.failure.violation.as_ref().and_then(|found| found.preventable)))
        .column(NO_VERDICT.of(|row: &Listed| row.failure.violation.as_ref().map(|found| found.no_verdict.clone())))
        .column(
            Column::<u64>::new(
                "merged",
                "",
                "number of failures that shrink to it, itself included; missing without --distinct",
            )
            .of(|row: &Listed| row.merged),
        )
        .column(
            Column::<String>::new("weakness", "", "what the driver lacks, a word; missing without --why")
                .of(|row: &Listed| row.cause.as_ref().map(|cause| cause.weakness.name())),
        )
        .column(
            Column::<String>::new("cause", "", "why the driver failed, a sentence; missing without --why")
                .of(|row: &Listed| row.cause.as_ref().map(Cause::sentence)),
        )
        .column(
            Column::<String>::new("around", "", "which starts around it fail, a sentence; missing without --why")
                .of(|row: &Listed| row.around.as_ref().map(Around::sentence)),
        );
    if failures.iter().any(|each| each.failure.needs.is_some()) {
        let doc = "roles of the other actors that it needs, with a blank between two; missing if that was not asked";
        table = table.text("needs", doc, |row| row.failure.needs.clone());
    }
    table.frame(failures)
}
