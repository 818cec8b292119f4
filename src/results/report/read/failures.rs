//! The failures of a report, of evaluations and searches alike, as a list.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::PathBuf;

use polars::prelude::{DataFrame, PolarsResult};

use super::{ReadError, StoredReport};
use crate::analysis::Impact;
use crate::record::columns::{
    CONTROLLER, DRIVING_MODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, IN_SIGHT, MOTION, POLICY,
    REWARD, RUN_ID, TOWN, TRAIN_POLICY, TRAIN_TOWN, VERDICT,
};
use crate::record::{Column, EPISODES, EpisodeTable, RunKey, Table};
use crate::report::aggregate::{FAILURE, FAILURES, FALSIFIER, FailureClass, START};
use world::av::DrivingMode;
use world::judge::{Label, Sight};

/// The number of rows of a table that are read at once.
const ROWS: usize = 1 << 17;

/// A failure: a collision of an evaluation, or a failure that a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedFailure {
    pub run: String,
    /// The number of the episode, or of the failure of a search.
    pub number: u64,
    /// The number of its start: that of the episode, or that which a search gave it.
    pub start: u64,
    /// The controller of the pedestrian; for a search, its falsifier.
    pub controller: String,
    /// Whether a search found it.
    pub searched: bool,
    /// The reward of the controller; empty without one.
    pub reward: String,
    /// The town of the training; empty for an untrained controller.
    pub train_town: String,
    /// The driving policy of the training; empty for an untrained controller.
    pub train_policy: String,
    pub town: String,
    /// The driving policy.
    pub policy: String,
    /// The verdict; none if the failure of a search does not repeat.
    pub verdict: Option<Label>,
    /// Whether the pedestrian moved as people do.
    pub foreseeable: bool,
    /// Whether it counts against the driver: preventable and foreseeable.
    pub fault: bool,
    /// The side of the car that was hit.
    pub impact: String,
    /// Whether the car moved.
    pub moving: bool,
    /// Whether the pedestrian came into sight too late for a careful human.
    pub occluded: bool,
    /// What the driver was doing at the last decision.
    pub driving_mode: String,
    /// Speed of the car at the touch (m/s).
    pub impact_speed: f64,
    /// Time from the start of the episode to the touch (s).
    pub length: f64,
}

impl ListedFailure {
    /// Its name in its report, `RUN:EPISODE`.
    pub fn name(&self) -> String {
        format!("{}:{}", self.run, self.number)
    }

    /// Its kind without the verdict, as `front, moving, occluded, cruise`.
    pub fn kind(&self) -> String {
        let (motion, occluded) =
            (if self.moving { "moving" } else { "standing" }, if self.occluded { "occluded, " } else { "" });
        format!("{}, {motion}, {occluded}{}", self.impact, self.driving_mode.replace('_', " "))
    }

    /// The verdict in a word: `fault` precedes the verdict of the reference drivers.
    pub fn verdict_name(&self) -> &'static str {
        match self.verdict {
            _ if self.fault => "fault",
            Some(label) => label.name(),
            None => "",
        }
    }

    /// The verdict for people.
    pub fn verdict_text(&self) -> String {
        self.verdict_name().replace('_', " ")
    }

    /// How much it counts against the driver.
    pub fn class(&self) -> FailureClass {
        FailureClass::new(self.verdict, self.fault)
    }
}

/// The failures that a list shows. An empty list of words allows every value.
#[derive(Debug, Clone, Default)]
pub struct FailureFilter {
    /// Verdicts: names of [`Label`]s, `fault`, `foreseeable`.
    pub verdicts: Vec<String>,
    /// Names of driving policies.
    pub drivers: Vec<String>,
    /// Names of controllers and falsifiers.
    pub controllers: Vec<String>,
    /// Words of the kind, all of which must occur: `front`, `moving`, `occluded`, `cruise`.
    pub kind: Vec<String>,
    /// The least speed of the car at the touch (m/s).
    pub min_speed: f64,
}

impl FailureFilter {
    /// The words that may be verdicts in a filter.
    pub fn verdict_names() -> impl Iterator<Item = &'static str> {
        ["fault", "foreseeable"].into_iter().chain(Label::ALL.map(Label::name))
    }

    /// Whether it lets a failure through.
    pub fn allows(&self, failure: &ListedFailure) -> bool {
        let among = |words: &[String], word: &str| words.is_empty() || words.iter().any(|each| each == word);
        let verdict = |word: &String| match word.as_str() {
            "fault" => failure.fault,
            "foreseeable" => failure.foreseeable,
            label => failure.verdict.is_some_and(|known| known.name() == label),
        };
        let kind = failure.kind();
        let has = |word: &String| kind.split(", ").any(|part| part == word.replace('_', " "));
        (self.verdicts.is_empty() || self.verdicts.iter().any(verdict))
            && among(&self.drivers, &failure.policy)
            && among(&self.controllers, &failure.controller)
            && self.kind.iter().all(has)
            && failure.impact_speed >= self.min_speed
    }
}

/// The order of a list of failures. Equal ones stay in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FailureOrder {
    /// By [`FailureClass`]: fault ones first, then the verdicts from `preventable` to `standing`; in each the highest speed at the
    /// touch first.
    #[default]
    Severity,
    /// The highest speed at the touch first.
    Speed,
    /// The shortest time to the touch first.
    Time,
    /// As in the report.
    Report,
}

impl FailureOrder {
    /// Which of two failures precedes the other.
    pub fn compare(self, a: &ListedFailure, b: &ListedFailure) -> Ordering {
        let faster = || b.impact_speed.total_cmp(&a.impact_speed);
        match self {
            Self::Severity => a.class().cmp(&b.class()).then_with(faster),
            Self::Speed => faster(),
            Self::Time => a.length.total_cmp(&b.length),
            Self::Report => Ordering::Equal,
        }
    }
}

impl StoredReport {
    /// The failures that a filter lets through: those of evaluations, then those of searches, each in the order of its table.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn failures(&self, filter: &FailureFilter) -> Result<Vec<ListedFailure>, ReadError> {
        let mut found = Vec::new();
        self.each_part(EPISODES, ROWS, |rows| evaluated(rows, filter, &mut found))?;
        self.each_part(FAILURES, ROWS, |rows| searched(rows, filter, &mut found))?;
        Ok(found)
    }
}

/// Adds the collisions of a part of the table of episodes.
fn evaluated(rows: &DataFrame, filter: &FailureFilter, found: &mut Vec<ListedFailure>) -> PolarsResult<()> {
    found.extend(listed(rows)?.into_values().filter(|failure| filter.allows(failure)));
    Ok(())
}

/// The collisions of a part of the table of episodes, by their rows.
pub fn listed(rows: &DataFrame) -> PolarsResult<BTreeMap<usize, ListedFailure>> {
    let (table, foreseeable) = (EpisodeTable::new(rows)?, FORESEEABLE.read(rows)?);
    let failure = |row: usize| {
        let RunKey { id, cell, .. } = RunKey::read(rows, row)?;
        let failure = ListedFailure {
            run: id.to_string(),
            number: table.episode(row).into(),
            start: table.episode(row).into(),
            controller: cell.controller,
            searched: false,
            reward: cell.reward,
            train_town: cell.train_town,
            train_policy: cell.train_policy,
            town: cell.town,
            policy: cell.policy,
            verdict: table.label(row),
            foreseeable: foreseeable.get(row) == Some(true),
            fault: table.is_fault(row),
            impact: Impact::new(table.is_front(row), table.impact_bearing(row).unwrap_or_default()).name().into(),
            moving: table.is_moving(row),
            occluded: is_occluded(table.in_sight(row)),
            driving_mode: table.driving_mode(row).map_or("", DrivingMode::name).into(),
            impact_speed: table.impact_speed(row).unwrap_or_default(),
            length: table.length(row).unwrap_or_default(),
        };
        Ok((row, failure))
    };
    table.rows().filter(|row| table.is_collision(*row)).map(failure).collect()
}

/// Adds the failures of a part of the table of failures of searches.
fn searched(rows: &DataFrame, filter: &FailureFilter, found: &mut Vec<ListedFailure>) -> PolarsResult<()> {
    let text = |column: &Column<String>, row: usize| -> PolarsResult<String> {
        Ok(column.read(rows)?.get(row).unwrap_or_default().to_string())
    };
    let number = |column: &Column<f64>, row: usize| -> PolarsResult<Option<f64>> { Ok(column.read(rows)?.get(row)) };
    for row in 0..rows.height() {
        let failure = ListedFailure {
            run: text(&RUN_ID, row)?,
            number: FAILURE.read(rows)?.get(row).unwrap_or_default(),
            start: START.read(rows)?.get(row).unwrap_or_default(),
            controller: text(&FALSIFIER, row)?,
            searched: true,
            reward: text(&REWARD, row)?,
            train_town: String::new(),
            train_policy: String::new(),
            town: text(&TOWN, row)?,
            policy: text(&POLICY, row)?,
            verdict: Label::named(&text(&VERDICT, row)?),
            foreseeable: FORESEEABLE.read(rows)?.get(row) == Some(true),
            fault: FAULT.read(rows)?.get(row) == Some(true),
            impact: text(&IMPACT, row)?,
            moving: text(&MOTION, row)? == "moving",
            occluded: is_occluded(number(&IN_SIGHT, row)?),
            driving_mode: text(&DRIVING_MODE, row)?,
            impact_speed: number(&IMPACT_SPEED, row)?.unwrap_or_default(),
            length: number(&EPISODE_LENGTH, row)?.unwrap_or_default(),
        };
        found.extend(Some(failure).filter(|failure| filter.allows(failure)));
    }
    Ok(())
}

fn is_occluded(in_sight: Option<f64>) -> bool {
    in_sight.is_some_and(|seen| Sight { hidden: 0.0, seen }.is_occluded())
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
        .column(MOTION.of(|row: &Row| if row.1.moving { "moving" } else { "standing" }))
        .column(
            Column::<bool>::new("occluded", "", "whether it came into sight too late for a careful human")
                .of(|row: &Row| row.1.occluded),
        )
        .column(DRIVING_MODE.of(|row: &Row| row.1.driving_mode.clone()))
        .column(IMPACT_SPEED.of(|row: &Row| row.1.impact_speed))
        .column(EPISODE_LENGTH.of(|row: &Row| row.1.length))
        .frame(failures)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failure(verdict: Option<Label>, fault: bool, speed: f64) -> ListedFailure {
        ListedFailure {
            run: "1a2b3c4d".into(),
            number: 3,
            start: 3,
            controller: "random".into(),
            searched: false,
            reward: "r1".into(),
            train_town: String::new(),
            train_policy: String::new(),
            town: "harbour".into(),
            policy: "behavior".into(),
            verdict,
            foreseeable: fault,
            fault,
            impact: "front".into(),
            moving: speed > 0.1,
            occluded: false,
            driving_mode: "emergency_stop".into(),
            impact_speed: speed,
            length: 10.0 - speed,
        }
    }

    #[test]
    fn what_counts_most_against_the_driver_comes_first() {
        let mut all = vec![
            failure(Some(Label::Standing), false, 0.0),
            failure(None, false, 9.0),
            failure(Some(Label::Unpreventable), false, 8.0),
            failure(Some(Label::Preventable), false, 7.0),
            failure(Some(Label::Preventable), true, 2.0),
            failure(Some(Label::Preventable), true, 3.0),
        ];
        let speeds = |all: &[ListedFailure]| all.iter().map(|each| each.impact_speed).collect::<Vec<_>>();
        all.sort_by(|a, b| FailureOrder::Severity.compare(a, b));
        assert_eq!(speeds(&all), [3.0, 2.0, 7.0, 8.0, 0.0, 9.0]);
        all.sort_by(|a, b| FailureOrder::Time.compare(a, b));
        assert_eq!(speeds(&all), [9.0, 8.0, 7.0, 3.0, 2.0, 0.0]);
    }

    #[test]
    fn a_filter_joins_its_conditions() {
        let one = failure(Some(Label::Preventable), true, 3.0);
        let words = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
        let all = FailureFilter::default();
        for (filter, wanted) in [
            (all.clone(), true),
            (FailureFilter { verdicts: words(&["standing", "fault"]), ..all.clone() }, true),
            (FailureFilter { verdicts: words(&["standing"]), ..all.clone() }, false),
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
