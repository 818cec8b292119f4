//! A failure of a driver: a collision or the violation of a requirement, of an episode of an evaluation or from a search's finds.

use std::cmp::Ordering;

use crate::jobs::SearchFailure;
use crate::record::{CellKey, EpisodeTable, RunKey};
use base::choice;
use compile::SearchKey;
use episode::Impact;
use episode::requirement::{Degree, NamedRequirement};
use verdict::cause::{part_of, unit_of};
use verdict::{Class, Label, NoVerdict, RestsOn, Sight, ViolationVerdict};
use world::av::DrivingMode;
use world::sim::WalkCommand;

choice! {
    /// What found a failure.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
    pub enum FoundBy {
        #[default]
        Evaluation = "evaluation",
        Search = "search",
    }
}

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

/// A failure of a driver, or a bump into the standing car.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Failure {
    /// Its evaluation; of a search the falsifier is the controller.
    pub key: RunKey,
    pub found_by: FoundBy,
    /// The number of the episode, or of the failure of a search.
    pub number: u64,
    /// The number of its start: that of the episode, or that which a search gave it.
    pub start: u64,
    /// The commands that lead to it from its start, one for each decision. Empty of an episode, whose controller decides again, and if a
    /// table has damaged ones.
    pub commands: Vec<WalkCommand>,
    /// Simulator ticks that its search had used.
    pub found_after: u64,
    /// The digest of its episode, which shows whether a repetition is the same; 0 if it is not known.
    pub digest: u64,
    /// The verdict; `None` if the failure of a search does not repeat.
    pub verdict: Option<Label>,
    /// Whether the pedestrian moved as people do.
    pub foreseeable: bool,
    /// Whether it counts against the driver, see [`verdict`].
    pub fault: bool,
    /// The side of the car that was hit; `None` without a touch.
    pub impact: Option<Impact>,
    /// Why its touch is a fault or none; `None` without a verdict.
    pub counts_as: Option<Class>,
    /// On what it rests that it is preventable; `None` unless it is.
    pub rests_on: Option<RestsOn>,
    /// The longest reaction time with which a driver avoids it (s).
    pub latest_reaction: Option<f64>,
    /// Time in sight before the touch (s).
    pub in_sight: Option<f64>,
    /// Whether the pedestrian was on a crosswalk at the touch.
    pub on_crosswalk: Option<bool>,
    /// The marks of its states, as a table has them; empty if they are not known.
    pub state_hashes: String,
    /// What the driver did at the touch; `None` of a violation in an evaluation.
    pub driving_mode: Option<DrivingMode>,
    /// Speed of the car at the touch (m/s).
    pub impact_speed: f64,
    /// Time from the start of the episode to the touch, or to the sample that decides a violation (s).
    pub length: f64,
    /// Length of the whole episode (s); `None` if it is not known.
    pub episode_length: Option<f64>,
    /// The roles of the other actors that it needs, such as `child van`; `None` if that was not asked.
    pub needs: Option<String>,
    /// The requirement that is violated; `None` of a collision or a bump.
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
    /// Whether all careful drivers satisfy the requirement; `None` without a verdict.
    pub preventable: Option<bool>,
}

impl Violation {
    /// What a degree of a requirement says, with the verdict on it.
    pub fn new(named: &NamedRequirement, degree: &Degree, verdict: Option<ViolationVerdict>) -> Self {
        Self {
            requirement: named.name.to_string(),
            priority: named.priority,
            robustness: degree.robustness,
            unit: unit_of(named).into(),
            part: part_of(named, degree).unwrap_or_default().into(),
            at_collision: false,
            preventable: verdict.map(|verdict| verdict.preventable),
        }
    }

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

impl Failure {
    /// An episode of a run, without anything that failed in it.
    pub fn new(key: RunKey, found_by: FoundBy, number: u64) -> Self {
        Self { key, found_by, number, start: number, ..Self::default() }
    }

    /// The touch in a row of the table of episodes.
    pub fn of_row(table: &EpisodeTable<'_>, row: usize, key: RunKey) -> Self {
        Self {
            digest: u64::from_str_radix(table.digest(row), 16).unwrap_or_default(),
            verdict: table.label(row),
            foreseeable: table.is_foreseeable(row),
            fault: table.is_fault(row),
            counts_as: table.counts_as(row),
            rests_on: table.rests_on(row),
            latest_reaction: table.latest_reaction(row),
            in_sight: table.in_sight(row),
            on_crosswalk: table.on_crosswalk(row),
            state_hashes: table.state_hashes(row).unwrap_or_default().into(),
            impact: table.impact(row),
            driving_mode: table.driving_mode(row),
            impact_speed: table.impact_speed(row).unwrap_or_default(),
            length: table.length(row).unwrap_or_default(),
            episode_length: table.length(row),
            ..Self::new(key, FoundBy::Evaluation, table.episode(row).into())
        }
    }

    /// The collision in a row of the table of episodes; `None` of a bump, without a touch, and if the episode does not count.
    pub fn of_collision(table: &EpisodeTable<'_>, row: usize, key: &RunKey) -> Option<Self> {
        let is_touch = table.counts(row) && table.is_touch(row);
        is_touch.then(|| Self::of_row(table, row, key.clone())).filter(|found| !found.is_bump())
    }

    /// Its name in its report, `RUN:EPISODE`.
    pub fn name(&self) -> String {
        format!("{}:{}", self.key.id, self.number)
    }

    /// Its kind without the verdict, as `front, occluded, cruise`; of a violation what is violated.
    pub fn kind(&self) -> String {
        if let Some(violation) = &self.violation {
            return violation.text();
        }
        let occluded = self.is_occluded().then(|| "occluded".to_owned());
        let mode = self.driving_mode.filter(|mode| *mode != DrivingMode::Unknown);
        let words = [
            Some(self.impact.map_or("", Impact::name).to_owned()),
            occluded,
            mode.map(|mode| mode.name().replace('_', " ")),
        ];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// Whether the pedestrian came into sight too late for a careful human.
    pub fn is_occluded(&self) -> bool {
        self.in_sight.is_some_and(|seen| Sight { seen }.is_occluded())
    }

    /// Whether the pedestrian touched a standing car, which is not a failure, and no requirement is violated.
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
            Some(_) if self.fault => return "breach",
            Some(Violation { preventable: Some(true), .. }) => return "preventable",
            Some(Violation { preventable: Some(false), .. }) => return "not preventable",
            Some(_) => return "no verdict",
            None => {}
        }
        self.verdict.map_or("not judged", |label| label.word(self.fault))
    }

    /// What it counts as, and the requirement that it violates or the speed of the touch.
    pub fn in_words(&self) -> String {
        match &self.violation {
            Some(violation) => format!("{}, violates `{}`", self.word(), violation.requirement),
            None => format!("{}, {:.1} m/s", self.word(), self.impact_speed),
        }
    }

    /// Whether a search found it.
    pub fn is_of_search(&self) -> bool {
        self.found_by == FoundBy::Search
    }

    /// What found it, in words.
    pub fn finder(&self) -> String {
        let CellKey { controller, reward, .. } = &self.key.cell;
        match self.found_by {
            FoundBy::Search => format!("search: {controller}"),
            FoundBy::Evaluation if self.key.cell.is_trained() => format!("{controller}, {reward}"),
            FoundBy::Evaluation => controller.clone(),
        }
    }

    /// The worse failure first: see [`Self::counts_more`]. Equal ones are in the order of their names.
    pub fn worse_first(&self, other: &Self) -> Ordering {
        self.counts_more(other).then_with(|| (self.key.id, self.number).cmp(&(other.key.id, other.number)))
    }

    /// Which of two failures counts more against the driver: by class, fault ones first, then the verdicts from `preventable` to `bump`; in each the
    /// highest speed at the touch first.
    pub fn counts_more(&self, other: &Self) -> Ordering {
        let rank = |failure: &Self| failure.violation.as_ref().map_or(0, |found| found.priority);
        let degree = |failure: &Self| failure.violation.as_ref().map_or(0.0, |found| found.robustness);
        let blame = |failure: &Self| match &failure.violation {
            Some(found) => (!failure.fault, found.preventable != Some(true)),
            None => (false, false),
        };
        let order = self.class().cmp(&other.class()).then_with(|| blame(self).cmp(&blame(other)));
        let order = order.then_with(|| rank(self).cmp(&rank(other)));
        let order = order.then_with(|| degree(self).total_cmp(&degree(other)));
        order.then_with(|| other.impact_speed.total_cmp(&self.impact_speed))
    }

    /// How much it counts against the driver.
    pub fn class(&self) -> FailureClass {
        match self.violation {
            Some(_) => FailureClass::Violation,
            None => FailureClass::new(self.verdict, self.fault),
        }
    }
}

impl From<&SearchFailure<'_>> for Failure {
    fn from(find: &SearchFailure<'_>) -> Self {
        let (outcome, verdict) = (&find.failure.outcome, find.verdict());
        let struck = verdict.filter(|verdict| !verdict.is_bump());
        let violation = find.violation();
        let blame = match violation {
            Some((.., verdict)) => verdict.map(|verdict| (verdict.foreseeable, verdict.fault)),
            None => struck.map(|verdict| (verdict.foreseeable, verdict.is_fault())),
        };
        let SearchKey { ref falsifier, ref reward, ref town, ref policy, block, run, .. } = *find.key;
        let (controller, reward) = (falsifier.clone(), reward.clone());
        let cell =
            CellKey { block, town: town.clone(), policy: policy.clone(), controller, reward, ..CellKey::default() };
        Self {
            start: find.failure.start,
            commands: find.failure.commands.clone(),
            found_after: find.failure.ticks,
            digest: outcome.digest,
            verdict: verdict.map(|verdict| verdict.label),
            foreseeable: blame.is_some_and(|(foreseeable, _)| foreseeable),
            fault: blame.is_some_and(|(_, fault)| fault),
            impact: Impact::of(outcome),
            counts_as: verdict.map(|verdict| verdict.class()),
            rests_on: struck.and_then(|verdict| verdict.rests_on),
            latest_reaction: struck.and_then(|verdict| verdict.latest_reaction),
            in_sight: verdict.map(|verdict| verdict.sight.seen),
            on_crosswalk: outcome.is_touch().then_some(outcome.on_crosswalk),
            state_hashes: outcome.state_hashes.to_string(),
            driving_mode: Some(outcome.last_mode),
            impact_speed: outcome.impact_speed().unwrap_or_default(),
            length: find.instant().unwrap_or(outcome.duration),
            episode_length: Some(outcome.duration),
            violation: violation.map(|(named, degree, verdict)| Violation::new(named, degree, verdict)),
            ..Self::new(RunKey { id: find.id, cell, run }, FoundBy::Search, find.number as u64)
        }
    }
}

/// Why violations of a requirement have no verdict; empty if they have.
pub fn no_verdict(named: &NamedRequirement) -> &'static str {
    NoVerdict::of(&named.requirement).map_or("", NoVerdict::name)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn failure(verdict: Option<Label>, fault: bool, speed: f64) -> Failure {
        let names = ["random", "r1", "harbour", "behavior"].map(String::from);
        let [controller, reward, town, policy] = names;
        let cell = CellKey { controller, reward, town, policy, ..CellKey::default() };
        Failure {
            verdict,
            foreseeable: fault,
            fault,
            impact: Some(Impact::Front),
            driving_mode: Some(DrivingMode::EmergencyStop),
            impact_speed: speed,
            length: 10.0 - speed,
            ..Failure::new(RunKey { id: "1a2b3c4d".parse().unwrap(), cell, run: 0 }, FoundBy::Evaluation, 3)
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
        let speeds = |all: &[Failure]| all.iter().map(|each| each.impact_speed).collect::<Vec<_>>();
        all.sort_by(Failure::counts_more);
        assert_eq!(speeds(&all), [3.0, 2.0, 7.0, 8.0, 0.0, 9.0]);
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
