use std::collections::BTreeMap;

use super::requirements::RequirementRow;
use crate::failure::Failure;
use crate::jobs::SearchResult;
use crate::record::{CellKey, EpisodeTable, RunKey};

/// Maximum number of failures of a driver that are listed. The table `failures` has all.
const MAX_PER_DRIVER: usize = 100;

/// The worst failures of each driver, gathered run by run in memory that does not grow with the number of episodes. Their order is [`Failure::worse_first`], which a
/// table has no column of.
#[derive(Debug, Clone, Default)]
pub struct Failures {
    drivers: BTreeMap<String, Vec<Failure>>,
    /// The worst collision of each cell, and its worst violation of each requirement but those that the touch of a collision decides, in the order of first
    /// appearance.
    worst: Vec<Failure>,
    /// The places of these, by cell and requirement.
    places: BTreeMap<(CellKey, Option<String>), usize>,
}

impl Failures {
    /// Adds the collisions of a run or of a part of it: rows of a table of episodes.
    pub fn add(&mut self, key: &RunKey, table: &EpisodeTable<'_>) {
        for found in table.rows().filter_map(|row| Failure::of_collision(table, row, key)) {
            self.compare(&found);
            self.insert(found);
        }
    }

    /// Adds the failures that searches found.
    pub fn add_searches(&mut self, searches: &[SearchResult]) {
        searches.iter().flat_map(SearchResult::failures).for_each(|find| self.insert(Failure::from(&find)));
    }

    /// Adds the violations of a run or of a part of it that count.
    pub fn add_violations(&mut self, rows: &[RequirementRow]) {
        let is_own = |row: &&RequirementRow| row.counts && row.degree.is_violated() && !row.violation.at_collision;
        rows.iter().filter(is_own).for_each(|row| self.compare(&row.failure()));
    }

    /// Keeps a failure if it is the worst of its kind in its cell.
    fn compare(&mut self, found: &Failure) {
        let requirement = found.violation.as_ref().map(|violation| violation.requirement.clone());
        let place = *self.places.entry((found.key.cell.clone(), requirement)).or_insert(self.worst.len());
        match self.worst.get_mut(place) {
            Some(worst) if found.worse_first(worst).is_lt() => worst.clone_from(found),
            Some(_) => {}
            None => self.worst.push(found.clone()),
        }
    }

    /// The worst violation of each requirement in each cell that has any.
    pub fn violations(&self) -> impl Iterator<Item = &Failure> {
        self.worst.iter().filter(|found| found.violation.is_some())
    }

    /// The failure of a cell's evaluation that counts most against its driver: a collision, or a violation of a requirement; `None` without any.
    pub fn worst_of(&self, cell: &CellKey, requirement: Option<&str>) -> Option<&Failure> {
        Some(&self.worst[*self.places.get(&(cell.clone(), requirement.map(str::to_owned)))?])
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
