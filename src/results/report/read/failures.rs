//! The failures of a report, of evaluations and searches alike, as a list.

use std::collections::BTreeSet;
use std::path::PathBuf;

use polars::prelude::DataFrame;

use super::{ReadError, StoredReport};
use crate::analysis::Impact;
use crate::record::columns::{
    CONTROLLER, DRIVING_MODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, POLICY, REWARD, RUN_ID, TOWN,
    TRAIN_POLICY, TRAIN_TOWN, VERDICT,
};
use crate::record::{Column, EPISODES, Table};
use crate::report::aggregate::{
    FAILURES, INSTANT, NO_VERDICT, PART, PREVENTABLE, REQUIREMENT, REQUIREMENTS, ROBUSTNESS, ROBUSTNESS_UNIT,
};
use crate::report::listed_failure::{ListedFailure, searched, touches, violations};
use world::av::DrivingMode;
use world::judge::Label;

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

    /// All failures: collisions of evaluations, those of searches, violations of requirements, each in the order of its table. Bumps are among them, and
    /// violations at the touch of a collision.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn failures(&self) -> Result<Vec<ListedFailure>, ReadError> {
        let mut found = Vec::new();
        self.each_part(EPISODES, ROWS, |rows| {
            found.extend(touches(rows)?.into_values());
            Ok(())
        })?;
        self.each_part(FAILURES, ROWS, |rows| {
            found.extend(searched(rows)?);
            Ok(())
        })?;
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            found.extend(violations(rows)?);
            Ok(())
        })?;
        Ok(found)
    }
}

/// Failures with the folders of their reports as a table, one row each, in the order given.
pub fn failure_list(failures: &[(PathBuf, ListedFailure)]) -> DataFrame {
    type Row = (PathBuf, ListedFailure);
    let text = Column::<String>::new;
    Table::new("failures", "One row for each failure.")
        .column(
            text("name", "", "the path by which other commands find it")
                .of(|row: &Row| format!("{}/{}", row.0.display(), row.1.name())),
        )
        .column(text("report", "", "folder of the report").of(|row: &Row| row.0.display().to_string()))
        .column(RUN_ID.of(|row: &Row| row.1.run.clone()))
        .column(
            Column::<u64>::new("number", "", "number of the episode, or of the failure of a search")
                .of(|row: &Row| row.1.number),
        )
        .column(
            text("found_by", "", "`evaluation` or `search`")
                .of(|row: &Row| if row.1.searched { "search" } else { "evaluation" }),
        )
        .column(POLICY.of(|row: &Row| row.1.policy.clone()))
        .column(CONTROLLER.of(|row: &Row| row.1.controller.clone()))
        .column(REWARD.of(|row: &Row| row.1.reward.clone()))
        .column(TRAIN_TOWN.of(|row: &Row| row.1.train_town.clone()))
        .column(TRAIN_POLICY.of(|row: &Row| row.1.train_policy.clone()))
        .column(TOWN.of(|row: &Row| row.1.town.clone()))
        .column(VERDICT.of(|row: &Row| row.1.verdict.map(Label::name)))
        .column(FORESEEABLE.of(|row: &Row| row.1.foreseeable))
        .column(FAULT.of(|row: &Row| row.1.fault))
        .column(IMPACT.of(|row: &Row| row.1.impact.map_or("", Impact::name)))
        .column(
            Column::<bool>::new("occluded", "", "whether it came into sight too late for a careful human")
                .of(|row: &Row| row.1.occluded),
        )
        .column(DRIVING_MODE.of(|row: &Row| row.1.driving_mode.map_or("", DrivingMode::name)))
        .column(IMPACT_SPEED.of(|row: &Row| Some(row.1.impact_speed).filter(|_| row.1.violation.is_none())))
        .column(EPISODE_LENGTH.of(|row: &Row| row.1.length))
        .column(REQUIREMENT.of(|row: &Row| row.1.violation.as_ref().map(|found| found.requirement.clone())))
        .column(ROBUSTNESS.of(|row: &Row| row.1.violation.as_ref().map(|found| found.robustness)))
        .column(ROBUSTNESS_UNIT.of(|row: &Row| row.1.violation.as_ref().map(|found| found.unit.clone())))
        .column(INSTANT.of(|row: &Row| row.1.violation.as_ref().map(|_| row.1.length)))
        .column(PART.of(|row: &Row| row.1.violation.as_ref().map(|found| found.part.clone())))
        .column(PREVENTABLE.of(|row: &Row| row.1.violation.as_ref().and_then(|found| found.preventable)))
        .column(NO_VERDICT.of(|row: &Row| row.1.violation.as_ref().map(|found| found.no_verdict.clone())))
        .frame(failures)
}
