//! A failure of a report, of evaluations and searches alike: the row that every list has.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use polars::prelude::{DataFrame, PolarsResult};

use super::aggregate::{
    AT_COLLISION, COUNTS, FAILURE, FALSIFIER, GOAL_FAULT, GOAL_FORESEEABLE, GOAL_PREVENTABLE, INSTANT, NO_VERDICT,
    PART, PREVENTABLE, PRIORITY, REQUIREMENT, ROBUSTNESS, ROBUSTNESS_UNIT, RequirementRow, START, VIOLATED,
    VIOLATION_FAULT, VIOLATION_FORESEEABLE, impact, no_verdict, unit_of,
};
use crate::analysis::Impact;
use crate::jobs::Find;
use crate::record::columns::{
    DRIVING_MODE, EPISODE, EPISODE_LENGTH, FAULT, FORESEEABLE, IMPACT, IMPACT_SPEED, IN_SIGHT, POLICY, REWARD, RUN_ID,
    TOWN, VERDICT,
};
use crate::record::{CellKey, Column, EpisodeTable, RunKey};
use compile::RunId;
use world::av::DrivingMode;
use world::judge::{Label, Sight};

/// How much a failure counts against the driver under test, the most serious first. All lists of failures have this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FailureClass {
    /// A careful human would have avoided it, and the pedestrian moved as people do.
    Fault,
    /// A careful human would have avoided it.
    Preventable,
    /// Reference drivers disagree.
    Contested,
    /// Only a machine avoids it.
    MachinePreventable,
    /// No driver avoids it by braking.
    Unpreventable,
    /// A requirement is violated. Of these the faults come first, then the preventable ones.
    Violation,
    /// The car stood.
    Bump,
    /// There is no verdict: a driver that is not deterministic did not repeat it.
    Unjudged,
}

impl FailureClass {
    /// The class of a failure with this verdict.
    pub fn new(label: Option<Label>, is_fault: bool) -> Self {
        match label {
            _ if is_fault => Self::Fault,
            Some(Label::Preventable) => Self::Preventable,
            Some(Label::Contested) => Self::Contested,
            Some(Label::MachinePreventable) => Self::MachinePreventable,
            Some(Label::Unpreventable) => Self::Unpreventable,
            Some(Label::Bump) => Self::Bump,
            None => Self::Unjudged,
        }
    }

    /// Whether a careful human would have avoided it.
    pub fn is_preventable(self) -> bool {
        self <= Self::Preventable
    }
}

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
    /// The side of the car that was hit; `None` without a touch.
    pub impact: Option<Impact>,
    /// Whether the pedestrian came into sight too late for a careful human.
    pub occluded: bool,
    /// What the driver did at the touch; `None` of a violation in an evaluation.
    pub driving_mode: Option<DrivingMode>,
    /// Speed of the car at the touch (m/s).
    pub impact_speed: f64,
    /// Time from the start of the episode to the touch, or to the sample that decides a violation (s).
    pub length: f64,
    /// The requirement that is violated; none of a collision or a bump.
    pub violation: Option<Violation>,
}

/// A violation of a requirement.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub requirement: String,
    /// The rank of the requirement; 1 is the most important.
    pub priority: u32,
    /// Below 0, or -0.
    pub robustness: f64,
    /// The unit of the robustness; empty where it is scaled.
    pub unit: String,
    /// The comparison that decides.
    pub part: String,
    /// Whether it is decided at the touch of a collision, which is a failure by itself.
    pub at_collision: bool,
    /// Whether both careful humans satisfy the requirement; none without a verdict.
    pub preventable: Option<bool>,
    /// Why the requirement has no verdict; empty if it has.
    pub no_verdict: String,
}

impl Violation {
    /// As `slow_pass by 0.31 m/s: ego_speed < 3 m/s`.
    fn text(&self) -> String {
        let by = match self.robustness.is_finite() && self.robustness != 0.0 {
            // Where dimensions meet, the margin is a plain number.
            true if self.unit.is_empty() => format!(" by {:.2} (scaled)", -self.robustness),
            true => format!(" by {:.2} {}", -self.robustness, self.unit),
            false => String::new(),
        };
        format!("{}{by}: {}", self.requirement, self.part)
    }
}

impl ListedFailure {
    /// An episode of a run, without anything that failed in it.
    fn of_episode(id: RunId, cell: CellKey, number: u64) -> Self {
        let CellKey { controller, reward, train_town, train_policy, town, policy, .. } = cell;
        Self {
            run: id.to_string(),
            number,
            start: number,
            controller,
            searched: false,
            reward,
            train_town,
            train_policy,
            town,
            policy,
            verdict: None,
            foreseeable: false,
            fault: false,
            impact: None,
            occluded: false,
            driving_mode: None,
            impact_speed: 0.0,
            length: 0.0,
            violation: None,
        }
    }

    /// Its name in its report, `RUN:EPISODE`.
    pub fn name(&self) -> String {
        format!("{}:{}", self.run, self.number)
    }

    /// Its kind without the verdict, as `front, occluded, cruise`; of a violation what is violated.
    pub fn kind(&self) -> String {
        if let Some(violation) = &self.violation {
            return violation.text();
        }
        let occluded = if self.occluded { "occluded, " } else { "" };
        let mode = self.driving_mode.map_or(String::new(), |mode| mode.name().replace('_', " "));
        format!("{}, {occluded}{mode}", self.impact.map_or("", Impact::name))
    }

    /// Whether the pedestrian touched a standing car, which is no failure, and no requirement is violated.
    pub fn is_bump(&self) -> bool {
        self.verdict == Some(Label::Bump) && self.violation.is_none()
    }

    /// Whether it is a failure of its own: not a bump, and not a violation at the touch of a collision.
    pub fn is_failure(&self) -> bool {
        !self.is_bump() && self.violation.as_ref().is_none_or(|violation| !violation.at_collision)
    }

    /// What it is called in lists: [`Label::word`], or whose fault the violation is.
    pub fn word(&self) -> &'static str {
        match &self.violation {
            Some(_) if self.fault => return "fault",
            Some(Violation { preventable: Some(true), .. }) => return "preventable",
            Some(Violation { preventable: Some(false), .. }) => return "not preventable",
            Some(_) => return "no verdict",
            None => {}
        }
        self.verdict.map_or("not judged", |label| label.word(self.fault))
    }

    /// What found it, in words.
    pub fn finder(&self) -> String {
        if self.searched {
            format!("search: {}", self.controller)
        } else if self.train_town.is_empty() {
            self.controller.clone()
        } else {
            format!("{}, {}", self.controller, self.reward)
        }
    }

    /// The worse failure first: by class, then the faster car. Equal ones are in the order of their names.
    pub fn worse_first(&self, other: &Self) -> Ordering {
        FailureOrder::Severity
            .compare(self, other)
            .then_with(|| (&self.run, self.number).cmp(&(&other.run, other.number)))
    }

    /// How much it counts against the driver.
    pub fn class(&self) -> FailureClass {
        match self.violation {
            Some(_) => FailureClass::Violation,
            None => FailureClass::new(self.verdict, self.fault),
        }
    }
}

/// The order of a list of failures. Equal ones stay in the order of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FailureOrder {
    /// By class: fault ones first, then the verdicts from `preventable` to `bump`; in each the highest speed at the
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
            Self::Severity => {
                let rank = |failure: &ListedFailure| failure.violation.as_ref().map_or(0, |found| found.priority);
                let degree = |failure: &ListedFailure| failure.violation.as_ref().map_or(0.0, |found| found.robustness);
                let worse = || degree(a).total_cmp(&degree(b));
                let blame = |failure: &ListedFailure| match &failure.violation {
                    Some(found) => (!failure.fault, found.preventable != Some(true)),
                    None => (false, false),
                };
                a.class()
                    .cmp(&b.class())
                    .then_with(|| blame(a).cmp(&blame(b)))
                    .then_with(|| rank(a).cmp(&rank(b)))
                    .then_with(worse)
                    .then_with(faster)
            }
            Self::Speed => faster(),
            Self::Time => a.length.total_cmp(&b.length),
            Self::Report => Ordering::Equal,
        }
    }
}

impl From<&Find<'_>> for ListedFailure {
    fn from(find: &Find<'_>) -> Self {
        let (outcome, verdict) = (&find.failure.outcome, find.verdict());
        let struck = verdict.filter(|verdict| !verdict.is_bump());
        let violation = find.violation();
        let blame = violation.map(|(.., verdict)| verdict);
        Self {
            run: find.id.to_string(),
            number: find.number as u64,
            start: find.failure.start,
            controller: find.key.falsifier.clone(),
            searched: true,
            reward: find.key.reward.clone(),
            train_town: String::new(),
            train_policy: String::new(),
            town: find.key.town.clone(),
            policy: find.key.policy.clone(),
            verdict: verdict.map(|verdict| verdict.label),
            foreseeable: match blame {
                Some(blame) => blame.is_some_and(|blame| blame.foreseeable),
                None => struck.is_some_and(|verdict| verdict.foreseeable),
            },
            fault: match blame {
                Some(blame) => blame.is_some_and(|blame| blame.fault),
                None => struck.is_some_and(|verdict| verdict.is_fault()),
            },
            impact: impact(outcome),
            occluded: verdict.is_some_and(|verdict| verdict.sight.is_occluded()),
            driving_mode: Some(outcome.last_mode),
            impact_speed: outcome.impact_speed().unwrap_or_default(),
            length: find.instant().unwrap_or(outcome.duration),
            violation: violation.map(|(named, degree, verdict)| Violation {
                requirement: named.name.to_string(),
                priority: named.priority,
                robustness: degree.robustness,
                unit: unit_of(named).into(),
                part: degree
                    .part
                    .and_then(|part| named.requirement.parts.get(usize::from(part)))
                    .map_or(String::new(), |part| part.text.clone()),
                at_collision: false,
                preventable: verdict.map(|verdict| verdict.preventable),
                no_verdict: no_verdict(named).into(),
            }),
        }
    }
}

impl From<&RequirementRow> for ListedFailure {
    fn from(row: &RequirementRow) -> Self {
        Self {
            foreseeable: row.verdict.is_some_and(|verdict| verdict.foreseeable),
            fault: row.verdict.is_some_and(|verdict| verdict.fault),
            length: row.instant,
            violation: Some(Violation {
                requirement: row.name.clone(),
                priority: row.priority,
                robustness: row.degree.robustness,
                unit: row.unit.into(),
                part: row.part.clone(),
                at_collision: row.at_collision,
                preventable: row.verdict.map(|verdict| verdict.preventable),
                no_verdict: row.no_verdict.into(),
            }),
            ..Self::of_episode(row.key.id, row.key.cell.clone(), row.episode.into())
        }
    }
}

/// The collisions of a part of the table of episodes that count, by their rows.
///
/// # Errors
/// A column is missing or holds something else.
pub fn listed(rows: &DataFrame) -> PolarsResult<BTreeMap<usize, ListedFailure>> {
    let mut found = touches(rows)?;
    found.retain(|_, failure| !failure.is_bump());
    Ok(found)
}

/// The collisions and bumps of a part of the table of episodes, by their rows.
///
/// # Errors
/// As [`listed`].
pub fn touches(rows: &DataFrame) -> PolarsResult<BTreeMap<usize, ListedFailure>> {
    let (table, foreseeable) = (EpisodeTable::new(rows)?, FORESEEABLE.read(rows)?);
    let failure = |row: usize| {
        let RunKey { id, cell, .. } = RunKey::read(rows, row)?;
        let failure = ListedFailure {
            verdict: table.label(row),
            foreseeable: foreseeable.get(row) == Some(true),
            fault: table.is_fault(row),
            impact: Some(Impact::new(table.is_front(row), table.impact_bearing(row).unwrap_or_default())),
            occluded: is_occluded(table.in_sight(row)),
            driving_mode: table.driving_mode(row),
            impact_speed: table.impact_speed(row).unwrap_or_default(),
            length: table.length(row).unwrap_or_default(),
            ..ListedFailure::of_episode(id, cell, table.episode(row).into())
        };
        Ok((row, failure))
    };
    table.rows().filter(|row| table.counts(*row) && table.is_touch(*row)).map(failure).collect()
}

/// The failures of a part of the table of failures of searches.
///
/// # Errors
/// A column is missing or holds something else.
pub fn searched(rows: &DataFrame) -> PolarsResult<Vec<ListedFailure>> {
    let has_goals = rows.get_column_index(REQUIREMENT.name).is_some();
    let failure = |row: usize| {
        let text = |column: &Column<String>| column.value(rows, row).map(Option::unwrap_or_default);
        let has = |column: &Column<bool>| column.value(rows, row).map(|value| value == Some(true));
        let found = ListedFailure {
            run: text(&RUN_ID)?,
            number: FAILURE.value(rows, row)?.unwrap_or_default(),
            start: START.value(rows, row)?.unwrap_or_default(),
            controller: text(&FALSIFIER)?,
            searched: true,
            reward: text(&REWARD)?,
            train_town: String::new(),
            train_policy: String::new(),
            town: text(&TOWN)?,
            policy: text(&POLICY)?,
            verdict: Label::named(&text(&VERDICT)?),
            foreseeable: has(&FORESEEABLE)?,
            fault: has(&FAULT)?,
            impact: Impact::named(&text(&IMPACT)?),
            occluded: is_occluded(IN_SIGHT.value(rows, row)?),
            driving_mode: DrivingMode::named(&text(&DRIVING_MODE)?),
            impact_speed: IMPACT_SPEED.value(rows, row)?.unwrap_or_default(),
            length: EPISODE_LENGTH.value(rows, row)?.unwrap_or_default(),
            violation: None,
        };
        if !has_goals || REQUIREMENT.value(rows, row)?.is_none() {
            return Ok(found);
        }
        Ok(ListedFailure {
            violation: Some(Violation::read(rows, row, &GOAL_PREVENTABLE)?),
            length: INSTANT.value(rows, row)?.unwrap_or_default(),
            foreseeable: has(&GOAL_FORESEEABLE)?,
            fault: has(&GOAL_FAULT)?,
            ..found
        })
    };
    (0..rows.height()).map(failure).collect()
}

impl Violation {
    /// The violation in a row of a table.
    fn read(rows: &DataFrame, row: usize, preventable: &Column<bool>) -> PolarsResult<Self> {
        let text = |column: &Column<String>| column.value(rows, row).map(Option::unwrap_or_default);
        Ok(Self {
            requirement: text(&REQUIREMENT)?,
            priority: PRIORITY.value(rows, row)?.unwrap_or_default(),
            robustness: ROBUSTNESS.value(rows, row)?.unwrap_or_default(),
            unit: text(&ROBUSTNESS_UNIT)?,
            part: text(&PART)?,
            at_collision: false,
            preventable: preventable.value(rows, row)?,
            no_verdict: text(&NO_VERDICT)?,
        })
    }
}

/// The violations in a part of the table of requirements that count.
///
/// # Errors
/// A column is missing or holds something else.
pub fn violations(rows: &DataFrame) -> PolarsResult<Vec<ListedFailure>> {
    let (violated, counts) = (VIOLATED.read(rows)?, COUNTS.read(rows)?);
    let failure = |row: usize| {
        let has = |column: &Column<bool>| column.value(rows, row).map(|value| value == Some(true));
        let RunKey { id, cell, .. } = RunKey::read(rows, row)?;
        let number = u64::from(EPISODE.value(rows, row)?.unwrap_or_default());
        let violation = Violation { at_collision: has(&AT_COLLISION)?, ..Violation::read(rows, row, &PREVENTABLE)? };
        Ok(ListedFailure {
            foreseeable: has(&VIOLATION_FORESEEABLE)?,
            fault: has(&VIOLATION_FAULT)?,
            length: INSTANT.value(rows, row)?.unwrap_or_default(),
            violation: Some(violation),
            ..ListedFailure::of_episode(id, cell, number)
        })
    };
    let wanted = |row: &usize| violated.get(*row) == Some(true) && counts.get(*row) == Some(true);
    (0..rows.height()).filter(wanted).map(failure).collect()
}

fn is_occluded(in_sight: Option<f64>) -> bool {
    in_sight.is_some_and(|seen| Sight { hidden: 0.0, seen }.is_occluded())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn failure(verdict: Option<Label>, fault: bool, speed: f64) -> ListedFailure {
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
            impact: Some(Impact::Front),
            occluded: false,
            driving_mode: Some(DrivingMode::EmergencyStop),
            impact_speed: speed,
            length: 10.0 - speed,
            violation: None,
        }
    }

    #[test]
    fn what_counts_most_against_the_driver_comes_first() {
        let mut all = vec![
            failure(Some(Label::Bump), false, 0.0),
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
    fn every_label_has_a_class() {
        let classes: Vec<FailureClass> =
            Label::ALL.into_iter().map(|label| FailureClass::new(Some(label), false)).collect();
        assert!(classes.is_sorted(), "{classes:?}");
        assert_eq!(FailureClass::new(Some(Label::Preventable), true), FailureClass::Fault);
        assert!(FailureClass::Preventable.is_preventable() && !FailureClass::Contested.is_preventable());
    }
}
