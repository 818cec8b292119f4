use std::cmp::Ordering;

use polars::prelude::{DataFrame, PolarsResult};

use crate::campaign::SearchResult;
use crate::record::{CellKey, EpisodeTable, RunKey};
use compile::{RunId, SearchKey};
use world::judge::{Label, Verdict};

/// The most failures of a driver that are listed. The tables `episodes` and `search_failures` have all.
const MOST_OF_A_DRIVER: usize = 100;

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
    /// The car stood.
    Standing,
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
            Some(Label::Standing) => Self::Standing,
            None => Self::Unjudged,
        }
    }

    /// Its name, for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fault => "fault",
            Self::Preventable => "preventable",
            Self::Contested => "contested",
            Self::MachinePreventable => "by machine only",
            Self::Unpreventable => "unpreventable",
            Self::Standing => "car standing",
            Self::Unjudged => "not judged",
        }
    }

    /// Whether a careful human would have avoided it.
    pub fn is_preventable(self) -> bool {
        self <= Self::Preventable
    }
}

/// What found a failure.
#[derive(Debug, Clone, PartialEq)]
pub enum FoundBy {
    /// A controller, in an evaluation.
    Controller(Box<CellKey>),
    /// A falsifier, in a search.
    Falsifier(Box<SearchKey>),
}

/// A failure in a list.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFailure {
    /// The evaluation's or the search's short name.
    pub run: RunId,
    /// Number of its episode, or of the failure in its search.
    pub number: u32,
    /// How much it counts.
    pub class: FailureClass,
    /// The car's speed at the touch (m/s).
    pub impact_speed: f64,
    /// Time from the start of the episode to the touch (s).
    pub length: f64,
    pub by: FoundBy,
}

impl FoundFailure {
    /// Its name, `RUN:EPISODE`.
    pub fn name(&self) -> String {
        format!("{}:{}", self.run, self.number)
    }

    /// The driver under test.
    pub fn driver(&self) -> &str {
        match &self.by {
            FoundBy::Controller(key) => &key.policy,
            FoundBy::Falsifier(key) => &key.policy,
        }
    }

    pub fn town(&self) -> &str {
        match &self.by {
            FoundBy::Controller(key) => &key.town,
            FoundBy::Falsifier(key) => &key.town,
        }
    }

    /// The controller or the falsifier.
    pub fn finder(&self) -> String {
        match &self.by {
            FoundBy::Controller(key) if key.is_trained() => format!("{}, {}", key.controller, key.reward),
            FoundBy::Controller(key) => key.controller.clone(),
            FoundBy::Falsifier(key) => format!("search: {}", key.falsifier),
        }
    }

    /// The worse failure first: by class, then the faster car. Equal ones are in the order of their names.
    pub fn worse_first(&self, other: &Self) -> Ordering {
        let names = || (self.run, self.number).cmp(&(other.run, other.number));
        self.class.cmp(&other.class).then(other.impact_speed.total_cmp(&self.impact_speed)).then_with(names)
    }
}

/// The worst failures of each driver, gathered run by run in memory that does not grow with the number of episodes.
#[derive(Debug, Clone, Default)]
pub struct Failures {
    drivers: Vec<Vec<FoundFailure>>,
    /// The runs of untrained controllers that were added, without their reward.
    untrained: Vec<RunKey>,
    /// The run of the last rows, and whether it counts.
    last: Option<(RunKey, bool)>,
    /// The worst failure of each cell that has any.
    worst: Vec<(CellKey, FoundFailure)>,
}

impl Failures {
    /// Adds the collisions of one run or of a part of it: all rows of a table of episodes, which have the same key. The parts of a run follow
    /// each other. An untrained controller walks the same for every reward, so its runs for further rewards are left out.
    ///
    /// # Errors
    /// Those of polars; none for a table made by `episodes`.
    pub fn add(&mut self, run: &DataFrame) -> PolarsResult<()> {
        if run.height() == 0 {
            return Ok(());
        }
        let episodes = EpisodeTable::new(run)?;
        let key = episodes.key()?;
        let counts = match &self.last {
            Some((last, counts)) if *last == key => *counts,
            _ => key.cell.is_trained() || self.is_new(&key),
        };
        self.last = Some((key.clone(), counts));
        let place = self.place(&key.cell.policy);
        for row in episodes.rows().filter(|row| episodes.is_collision(*row)) {
            let found = FoundFailure {
                run: key.id,
                number: episodes.episode(row),
                class: FailureClass::new(episodes.label(row), episodes.is_fault(row)),
                impact_speed: episodes.impact_speed(row).unwrap_or_default(),
                length: episodes.length(row).unwrap_or_default(),
                by: FoundBy::Controller(Box::default()),
            };
            let by = || FoundBy::Controller(Box::new(key.cell.clone()));
            match self.worst.iter_mut().find(|(cell, _)| *cell == key.cell) {
                Some((_, worst)) if found.worse_first(worst).is_lt() => {
                    *worst = FoundFailure { by: by(), ..found.clone() }
                }
                Some(_) => {}
                None => self.worst.push((key.cell.clone(), FoundFailure { by: by(), ..found.clone() })),
            }
            if counts {
                insert(&mut self.drivers[place], found, by);
            }
        }
        Ok(())
    }

    /// The failure of a cell's evaluation that counts most against its driver; none without a collision.
    pub fn worst_of(&self, cell: &CellKey) -> Option<&FoundFailure> {
        self.worst.iter().find(|(key, _)| key == cell).map(|(_, worst)| worst)
    }

    /// Whether a run of an untrained controller is the first of any reward, which is noted.
    fn is_new(&mut self, key: &RunKey) -> bool {
        let cell = CellKey { reward: String::new(), ..key.cell.clone() };
        let same = RunKey { id: RunId::default(), cell, run: key.run };
        let new = !self.untrained.contains(&same);
        if new {
            self.untrained.push(same);
        }
        new
    }

    /// Adds the failures that searches found.
    pub fn add_searches(&mut self, results: &[SearchResult]) {
        for result in results {
            let place = self.place(&result.key.policy);
            for (number, (failure, verdict)) in (0..).zip(result.spent.failures.iter().zip(&result.verdicts)) {
                let found = FoundFailure {
                    run: result.key.id,
                    number,
                    class: FailureClass::new(
                        verdict.as_ref().map(|verdict| verdict.label),
                        verdict.as_ref().is_some_and(Verdict::is_fault),
                    ),
                    impact_speed: failure.outcome.impact_speed().unwrap_or_default(),
                    length: failure.outcome.duration,
                    by: FoundBy::Controller(Box::default()),
                };
                let by = || FoundBy::Falsifier(Box::new(result.key.clone()));
                insert(&mut self.drivers[place], found, by);
            }
        }
    }

    /// The worst failures of a driver, the worst first; at most 100.
    pub fn of(&self, driver: &str) -> &[FoundFailure] {
        self.drivers.iter().find(|found| is_of(found, driver)).map_or(&[], Vec::as_slice)
    }

    /// The list of a driver; an empty list at the end when there is none yet.
    fn place(&mut self, driver: &str) -> usize {
        if let Some(place) = self.drivers.iter().position(|found| is_of(found, driver)) {
            return place;
        }
        if self.drivers.last().is_none_or(|last| !last.is_empty()) {
            self.drivers.push(Vec::new());
        }
        self.drivers.len() - 1
    }
}

fn is_of(found: &[FoundFailure], driver: &str) -> bool {
    found.first().is_some_and(|first| first.driver() == driver)
}

/// Inserts a failure where it belongs, if it is among the worst. What found it is only copied then.
fn insert(list: &mut Vec<FoundFailure>, found: FoundFailure, by: impl FnOnce() -> FoundBy) {
    let place = list.partition_point(|other| other.worse_first(&found).is_lt());
    if place < MOST_OF_A_DRIVER {
        list.insert(place, FoundFailure { by: by(), ..found });
        list.truncate(MOST_OF_A_DRIVER);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failure(driver: &str, number: u32, class: FailureClass, impact_speed: f64) -> FoundFailure {
        let by = FoundBy::Controller(Box::new(CellKey { policy: driver.into(), ..CellKey::default() }));
        FoundFailure { run: RunId::default(), number, class, impact_speed, length: 1.0, by }
    }

    #[test]
    fn the_verdict_comes_before_the_speed_and_the_speed_before_the_name() {
        let mut all = [
            failure("a", 4, FailureClass::Preventable, 9.0),
            failure("a", 3, FailureClass::Fault, 2.0),
            failure("a", 2, FailureClass::Fault, 7.0),
            failure("a", 1, FailureClass::Standing, 0.0),
            failure("a", 0, FailureClass::Preventable, 9.0),
        ];
        all.sort_by(FoundFailure::worse_first);
        assert_eq!(all.map(|found| found.number), [2, 3, 0, 4, 1]);
    }

    #[test]
    fn only_the_worst_of_a_driver_are_kept() {
        let mut list = Vec::new();
        for number in 0..3 * MOST_OF_A_DRIVER as u32 {
            let found = failure("a", number, FailureClass::Contested, f64::from((7 * number) % 300));
            let by = found.by.clone();
            insert(&mut list, found, || by);
        }
        let speeds: Vec<f64> = list.iter().map(|found| found.impact_speed).collect();
        let expected: Vec<f64> = (200..300).rev().map(f64::from).collect();
        assert_eq!(speeds, expected);
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
