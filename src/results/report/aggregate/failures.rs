use std::collections::BTreeMap;

use super::requirements::RequirementRow;
use crate::failure::Failure;
use crate::jobs::SearchResult;
use crate::record::{CellKey, EpisodeTable, RunKey};
use compile::RunId;

/// Maximum number of failures of a driver that are listed. The table `failures` has all.
const MAX_PER_DRIVER: usize = 100;

/// The worst failures of each driver, gathered run by run in memory that does not grow with the number of episodes.
#[derive(Debug, Clone, Default)]
pub struct Failures {
    drivers: BTreeMap<String, Vec<Failure>>,
    /// The runs of untrained controllers that were added, without their reward.
    untrained: Vec<RunKey>,
    /// The run of the last rows, and whether it counts.
    last: Option<(RunKey, bool)>,
    /// The worst failure of each cell that has any.
    worst: Vec<(CellKey, Failure)>,
    /// The worst violation of each requirement in each cell that has any, but those that the touch of a collision decides.
    violations: Vec<(CellKey, Failure)>,
}

impl Failures {
    /// Adds the collisions of one run or of a part of it: all rows of a table of episodes, which have the same key. The parts of a run follow
    /// each other. An untrained controller walks the same for every reward, so its runs for further rewards are left out.
    pub fn add(&mut self, key: &RunKey, table: &EpisodeTable<'_>) {
        let counts = match &self.last {
            Some((last, counts)) if last == key => *counts,
            _ => key.cell.is_of_reward() || self.is_new(key),
        };
        self.last = Some((key.clone(), counts));
        for found in table.rows().filter_map(|row| Failure::of_collision(table, row, key)) {
            match self.worst.iter_mut().find(|(cell, _)| *cell == key.cell) {
                Some((_, worst)) if found.worse_first(worst).is_lt() => worst.clone_from(&found),
                Some(_) => {}
                None => self.worst.push((key.cell.clone(), found.clone())),
            }
            if counts {
                self.insert(found);
            }
        }
    }

    /// Adds the failures that searches found.
    pub fn add_searches(&mut self, searches: &[SearchResult]) {
        searches.iter().flat_map(SearchResult::finds).for_each(|find| self.insert(Failure::from(&find)));
    }

    /// Adds the violations of a run or of a part of it that count.
    pub fn add_violations(&mut self, key: &CellKey, rows: &[RequirementRow]) {
        let name = |failure: &Failure| failure.violation.as_ref().map(|found| found.requirement.clone());
        let is_own = |row: &&RequirementRow| row.counts && row.degree.is_violated() && !row.violation.at_collision;
        for found in rows.iter().filter(is_own).map(RequirementRow::failure) {
            let same = |(cell, other): &&mut (CellKey, Failure)| cell == key && name(other) == name(&found);
            match self.violations.iter_mut().find(same) {
                Some((_, worst)) if found.worse_first(worst).is_lt() => *worst = found,
                Some(_) => {}
                None => self.violations.push((key.clone(), found)),
            }
        }
    }

    /// The worst violation of each requirement in each cell that has any, with its cell.
    pub fn violations(&self) -> &[(CellKey, Failure)] {
        &self.violations
    }

    /// The failure of a cell's evaluation that counts most against its driver; `None` without a collision.
    pub fn worst_of(&self, cell: &CellKey) -> Option<&Failure> {
        self.worst.iter().find(|(key, _)| key == cell).map(|(_, worst)| worst)
    }

    /// The worst failures of a driver, one of each start of a run, the worst first; at most 100.
    pub fn of(&self, driver: &str) -> &[Failure] {
        self.drivers.get(driver).map_or(&[], Vec::as_slice)
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

    /// Inserts a failure where it belongs, if it is the worst of its start and among the worst of its driver.
    fn insert(&mut self, found: Failure) {
        let list = self.drivers.entry(found.key.cell.policy.clone()).or_default();
        if let Some(same) = list.iter().position(|other| (other.key.id, other.start) == (found.key.id, found.start)) {
            if list[same].worse_first(&found).is_lt() {
                return;
            }
            list.remove(same);
        }
        let place = list.partition_point(|other| other.worse_first(&found).is_lt());
        if place < MAX_PER_DRIVER {
            list.insert(place, found);
            list.truncate(MAX_PER_DRIVER);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::tests::failure;
    use world::judge::Label;

    #[test]
    fn only_the_worst_of_each_start_and_driver_are_kept() {
        let mut failures = Failures::default();
        for number in 0..3 * MAX_PER_DRIVER as u64 {
            let speed = ((7 * number) % 300) as f64;
            let found = Failure { number, start: number, ..failure(Some(Label::Contested), false, speed) };
            failures.insert(Failure { number: number + 1000, impact_speed: speed - 0.5, ..found.clone() });
            failures.insert(found);
        }
        let kept = failures.of("behavior");
        let speeds: Vec<f64> = kept.iter().map(|found| found.impact_speed).collect();
        let expected: Vec<f64> = (200..300).rev().map(f64::from).collect();
        assert_eq!(speeds, expected);
        assert!(failures.of("idm").is_empty());
    }
}
