//! The failures of a report, of evaluations and searches alike, as a list.

use std::collections::BTreeSet;
use std::path::PathBuf;

use polars::prelude::DataFrame;

use super::{ReadError, StoredReport};
use crate::record::columns::{
    CONTROLLER, DRIVING_MODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, POLICY, REWARD, RUN_ID, TOWN,
    TRAIN_POLICY, TRAIN_TOWN, VERDICT,
};
use crate::record::{Column, EPISODES, Table};
use crate::report::aggregate::{
    FAILURES, INSTANT, NO_VERDICT, PART, PREVENTABLE, REQUIREMENT, REQUIREMENTS, ROBUSTNESS, ROBUSTNESS_UNIT,
};
use crate::report::listed_failure::{ListedFailure, searched, touches, violations};
use world::judge::Label;

/// The number of rows of a table that are read at once.
const ROWS: usize = 1 << 17;

/// The failures that a list shows. An empty list of words allows every value; bumps are listed only where `verdicts` names them.
#[derive(Debug, Clone, Default)]
pub struct FailureFilter {
    /// Verdicts: names of [`Label`]s, `fault`, `foreseeable`, `violation`, `no_verdict`. Of a violation `preventable` and `fault` are those of its
    /// requirement.
    pub verdicts: Vec<String>,
    /// Names of driving policies.
    pub drivers: Vec<String>,
    /// Names of controllers and falsifiers.
    pub controllers: Vec<String>,
    /// Words of the kind, all of which must occur: `front`, `occluded`, `cruise`.
    pub kind: Vec<String>,
    /// Names of requirements, of which only violations are listed. An empty list allows all failures; a violation at the touch of a collision is then
    /// listed as the collision alone.
    pub requirements: Vec<String>,
    /// The least speed of the car at the touch (m/s).
    pub min_speed: f64,
}

impl FailureFilter {
    /// The words that may be verdicts in a filter.
    pub fn verdict_names() -> impl Iterator<Item = &'static str> {
        ["fault", "foreseeable", "violation", "no_verdict"].into_iter().chain(Label::ALL.map(Label::name))
    }

    /// Whether it lets a failure through.
    pub fn allows(&self, failure: &ListedFailure) -> bool {
        let among = |words: &[String], word: &str| words.is_empty() || words.iter().any(|each| each == word);
        let verdict = |word: &String| match word.as_str() {
            "fault" => failure.fault,
            "foreseeable" => failure.foreseeable,
            "violation" => failure.violation.is_some(),
            "no_verdict" => failure.violation.as_ref().is_some_and(|found| found.preventable.is_none()),
            "preventable" if failure.violation.is_some() => {
                failure.violation.as_ref().is_some_and(|found| found.preventable == Some(true))
            }
            _ if failure.violation.is_some() => false,
            label => failure.verdict.is_some_and(|known| known.name() == label),
        };
        let violated = match &failure.violation {
            Some(violation) if self.requirements.is_empty() => !violation.at_collision,
            Some(violation) => self.requirements.contains(&violation.requirement),
            None => self.requirements.is_empty(),
        };
        let kind = failure.kind();
        let has = |word: &String| kind.split(", ").any(|part| part == word.replace('_', " "));
        (self.verdicts.is_empty() && !failure.is_bump() || self.verdicts.iter().any(verdict))
            && among(&self.drivers, &failure.policy)
            && among(&self.controllers, &failure.controller)
            && self.kind.iter().all(has)
            && failure.impact_speed >= self.min_speed
            && violated
    }
}

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

    /// The failures that a filter lets through: collisions of evaluations, those of searches, violations of requirements, each in the order of its table.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn failures(&self, filter: &FailureFilter) -> Result<Vec<ListedFailure>, ReadError> {
        let mut found = Vec::new();
        self.each_part(EPISODES, ROWS, |rows| {
            found.extend(touches(rows)?.into_values().filter(|failure| filter.allows(failure)));
            Ok(())
        })?;
        self.each_part(FAILURES, ROWS, |rows| {
            found.extend(searched(rows)?.into_iter().filter(|failure| filter.allows(failure)));
            Ok(())
        })?;
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            found.extend(violations(rows)?.into_iter().filter(|failure| filter.allows(failure)));
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
        .column(IMPACT.of(|row: &Row| row.1.impact.clone()))
        .column(
            Column::<bool>::new("occluded", "", "whether it came into sight too late for a careful human")
                .of(|row: &Row| row.1.occluded),
        )
        .column(DRIVING_MODE.of(|row: &Row| row.1.driving_mode.clone()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::listed_failure::tests::failure;

    #[test]
    fn a_filter_joins_its_conditions() {
        let one = failure(Some(Label::Preventable), true, 3.0);
        let words = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
        let all = FailureFilter::default();
        for (filter, wanted) in [
            (all.clone(), true),
            (FailureFilter { verdicts: words(&["bump", "fault"]), ..all.clone() }, true),
            (FailureFilter { verdicts: words(&["bump"]), ..all.clone() }, false),
            (FailureFilter { drivers: words(&["idm"]), ..all.clone() }, false),
            (FailureFilter { controllers: words(&["random"]), min_speed: 3.0, ..all.clone() }, true),
            (FailureFilter { min_speed: 3.1, ..all.clone() }, false),
            (FailureFilter { kind: words(&["front", "emergency_stop"]), ..all.clone() }, true),
            (FailureFilter { kind: words(&["front", "occluded"]), ..all }, false),
        ] {
            assert_eq!(filter.allows(&one), wanted, "{filter:?}");
        }
    }
}
