use std::collections::BTreeMap;

use super::requirements::RequirementRow;
use crate::failure::Failure;
use crate::jobs::SearchResult;
use crate::record::{CellKey, EpisodeTable, RunKey};

/// Maximum number of failures of a driver that are listed. The table `failures` has all.
const MAX_PER_DRIVER: usize = 100;

/// The worst failures of each driver, gathered run by run in memory that does not grow with the number of episodes.
#[derive(Debug, Clone, Default)]
pub struct Failures {
    drivers: BTreeMap<String, Vec<Failure>>,
    /// The worst failure of each cell that has any.
    worst: BTreeMap<CellKey, Failure>,
    /// The worst violation of each requirement in each cell that has any, but those that the touch of a collision decides, in the order of first appearance.
    violations: Vec<(CellKey, Failure)>,
    /// The places of these, by cell and requirement.
    violated: BTreeMap<(CellKey, String), usize>,
}

impl Failures {
    /// Adds the collisions of a run or of a part of it: rows of a table of episodes.
    pub fn add(&mut self, key: &RunKey, table: &EpisodeTable<'_>) {
        for found in table.rows().filter_map(|row| Failure::of_collision(table, row, key)) {
            match self.worst.get_mut(&key.cell) {
                Some(worst) if found.worse_first(worst).is_lt() => worst.clone_from(&found),
                Some(_) => {}
                None => drop(self.worst.insert(key.cell.clone(), found.clone())),
            }
            self.insert(found);
        }
    }

    /// Adds the failures that searches found.
    pub fn add_searches(&mut self, searches: &[SearchResult]) {
        searches.iter().flat_map(SearchResult::failures).for_each(|find| self.insert(Failure::from(&find)));
    }

    /// Adds the violations of a run or of a part of it that count.
    pub fn add_violations(&mut self, key: &CellKey, rows: &[RequirementRow]) {
        let is_own = |row: &&RequirementRow| row.counts && row.degree.is_violated() && !row.violation.at_collision;
        for found in rows.iter().filter(is_own).map(RequirementRow::failure) {
            let requirement = found.violation.as_ref().map(|found| found.requirement.clone()).unwrap_or_default();
            let place = *self.violated.entry((key.clone(), requirement)).or_insert(self.violations.len());
            match self.violations.get_mut(place) {
                Some((_, worst)) if found.worse_first(worst).is_lt() => *worst = found,
                Some(_) => {}
                None => self.violations.push((key.clone(), found)),
            }
        }
    }

    /// The worst violation of a requirement in a cell.
    pub fn worst_violation(&self, cell: &CellKey, requirement: &str) -> Option<&Failure> {
        let place = self.violated.get(&(cell.clone(), requirement.to_owned()))?;
        Some(&self.violations[*place].1)
    }

    /// The worst violation of each requirement in each cell that has any, with its cell.
    pub fn violations(&self) -> &[(CellKey, Failure)] {
        &self.violations
    }

    /// The failure of a cell's evaluation that counts most against its driver; `None` without a collision.
    pub fn worst_of(&self, cell: &CellKey) -> Option<&Failure> {
        self.worst.get(cell)
    }

    /// The worst failures of a driver, one of each start of a run, the worst first; at most 100.
    pub fn of(&self, driver: &str) -> &[Failure] {
        self.drivers.get(driver).map_or(&[], Vec::as_slice)
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
    use verdict::Label;

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
