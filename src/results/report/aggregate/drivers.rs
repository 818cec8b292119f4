use std::cmp::Ordering;

use polars::prelude::DataFrame;

use super::{Failures, ProtocolCell};
use crate::failure::Failure;
use crate::record::CellKey;
use crate::record::columns::DRIVER;
use crate::report::price::DriverPrice;
use crate::tables::metrics::{AVOIDABLE_INJURY, COLLISION_RATE, EPISODES, FAULT_RATE, PREVENTABLE_RATE};
use crate::tables::{
    BREACH_COUNT, Cell, EVALUATED_EPISODES, EVALUATED_FAULTS, FAILURE_COUNT, FAULT_COUNT, FAULT_START_RATE,
    FAULT_STARTS, INJURY, PREVENTABLE_COUNT, Row, Rows, SEARCH_EPISODES, searched_drivers,
};
use compile::Driver;

/// The failures of a driver that searches found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SearchFailures {
    pub all: usize,
    /// Those that a careful human would have avoided.
    pub preventable: usize,
    /// The collisions that count against the driver.
    pub fault: usize,
    /// The violations of a requirement that count against it.
    pub breaches: usize,
    /// The starts from which a search found a fault.
    pub fault_starts: usize,
    /// The avoidable injury of a thousand episodes, as the mean over the searches: one that spends its budget on many short episodes has no greater
    /// weight. `None` without any episode.
    pub injury_per_thousand: Option<f64>,
    /// The share of the starts with a fault, as the mean over the searches; `None` without any start.
    pub fault_start_rate: Option<f64>,
    pub episodes: u64,
    /// The faults in fresh episodes of the pedestrians that searches ended with, and these episodes.
    pub evaluated: (u64, u64),
}

impl From<&Row<String>> for SearchFailures {
    fn from(driver: &Row<String>) -> Self {
        let count = |column| driver.whole_number(column) as usize;
        Self {
            all: count(FAILURE_COUNT),
            preventable: count(PREVENTABLE_COUNT),
            fault: count(FAULT_COUNT),
            breaches: count(BREACH_COUNT),
            fault_starts: count(FAULT_STARTS),
            injury_per_thousand: driver.number(INJURY),
            fault_start_rate: driver.number(FAULT_START_RATE),
            episodes: driver.whole_number(SEARCH_EPISODES),
            evaluated: (driver.whole_number(EVALUATED_FAULTS), driver.whole_number(EVALUATED_EPISODES)),
        }
    }
}

/// What a campaign found about a driver, over all towns, controllers and searches.
#[derive(Debug, Clone, PartialEq)]
pub struct DriverResult {
    pub driver: Driver,
    /// Its worst failure, in the tests of a protocol the worst at the test speed if there is one; `None` without a collision.
    pub worst: Option<Failure>,
    /// The place of the worst cell in the list of cells: that with the highest fault rate; `None` if it was not evaluated.
    pub cell: Option<usize>,
    /// The failures that searches found; `None` without a search.
    pub searched: Option<SearchFailures>,
    /// What it gives for safety, over all towns; `None` where that was not asked.
    pub price: Option<DriverPrice>,
    /// Its episodes that count, of evaluations and of searches.
    pub episodes: u64,
}

impl DriverResult {
    /// Its worst failure in words, or why there is none.
    pub fn worst_in_words(&self) -> String {
        match &self.worst {
            // Rates beside it are those of evaluations.
            Some(found) if found.is_of_search() && self.cell.is_some() => format!("{}, by a search", found.in_words()),
            Some(found) => found.in_words(),
            None if self.episodes == 0 => "no episode".into(),
            None => "no collision".into(),
        }
    }
}

/// The results of the drivers: the user's own, then those that are built in, then those that see no pedestrians, since they are a baseline. Of each the
/// worst first, by the rates in the worst cell, then by the share of the starts from which searches found a fault.
pub fn driver_results(
    drivers: &[Driver],
    cells: &[Cell],
    failures: &Failures,
    searches: &DataFrame,
    tests: &[(CellKey, Vec<ProtocolCell>)],
) -> Vec<DriverResult> {
    let name = |table: &DataFrame, row| Ok(DRIVER.value(table, row)?.unwrap_or_default());
    let searched = searched_drivers(searches).and_then(|table| Rows::new(table, name));
    let searched = searched.expect("a bug: a table of searches has its columns");
    let result = |driver: &Driver| {
        let own = cells.iter().filter(|cell| cell.key.policy == driver.name);
        let searched = searched.iter().find(|row| row.key == driver.name).map(SearchFailures::from);
        DriverResult {
            driver: driver.clone(),
            worst: worst_of(failures.of(&driver.name), tests).cloned(),
            cell: worst_cell(cells, &driver.name),
            episodes: own.map(|cell| u64::from(cell.count(&EPISODES))).sum::<u64>()
                + searched.map_or(0, |found| found.episodes),
            searched,
            price: None,
        }
    };
    let mut results: Vec<DriverResult> = drivers.iter().map(result).collect();
    results.retain(|result| result.cell.is_some() || result.searched.is_some());
    results.sort_by(|a, b| {
        let (first, second) = (a.cell.map(|cell| &cells[cell]), b.cell.map(|cell| &cells[cell]));
        let rates = match (first, second) {
            (Some(first), Some(second)) => worse_cell_first(first, second),
            (first, second) => second.is_some().cmp(&first.is_some()),
        };
        let failures = || match (&a.worst, &b.worst) {
            (Some(first), Some(second)) => first.worse_first(second),
            (first, second) => second.is_some().cmp(&first.is_some()),
        };
        let searched = |result: &DriverResult| result.searched.and_then(|found| found.fault_start_rate).unwrap_or(0.0);
        rank(&a.driver)
            .cmp(&rank(&b.driver))
            .then(rates)
            .then_with(|| searched(b).total_cmp(&searched(a)))
            .then_with(failures)
    });
    results
}

/// The worst of failures, the worst first: one in a case that was not run at the test speed only if there is no other.
fn worst_of<'a>(failures: &'a [Failure], tests: &[(CellKey, Vec<ProtocolCell>)]) -> Option<&'a Failure> {
    let is_tested = |failure: &&Failure| {
        let run = failure.key.id.to_string();
        let cases = tests.iter().map(|(_, cases)| cases).find(|cases| cases.iter().any(|case| case.run_id == run));
        cases.is_none_or(|cases| cases[failure.number as usize % cases.len()].is_tested())
    };
    failures.iter().find(is_tested).or(failures.first())
}

/// The user's own drivers first, those that see no pedestrians last.
fn rank(driver: &Driver) -> u8 {
    if driver.is_own() { 0 } else { 1 + u8::from(driver.sees_no_pedestrians()) }
}

/// The worst failure of the user's own drivers; without any, of the others under test, then of those that see no pedestrians.
pub fn worst_failure(results: &[DriverResult]) -> Option<&Failure> {
    let found = results.iter().filter_map(|result| Some((rank(&result.driver), result.worst.as_ref()?)));
    found.min_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.worse_first(b.1))).map(|(_, worst)| worst)
}

/// The place of the worst cell of a driver, the first of equal ones.
fn worst_cell(cells: &[Cell], driver: &str) -> Option<usize> {
    let of_driver = cells.iter().enumerate().filter(|(_, cell)| cell.key.policy == driver);
    of_driver.min_by(|a, b| worse_cell_first(a.1, b.1)).map(|(place, _)| place)
}

/// The cell with the higher fault rate first; of equal ones by the preventable rate, the rate of collisions, the avoidable injury.
fn worse_cell_first(a: &Cell, b: &Cell) -> Ordering {
    let rates = |cell: &Cell| {
        [&FAULT_RATE, &PREVENTABLE_RATE, &COLLISION_RATE, &AVOIDABLE_INJURY]
            .map(|metric| cell.value(metric).unwrap_or(-1.0))
    };
    let pairs = rates(b).into_iter().zip(rates(a));
    pairs.map(|(b, a)| b.total_cmp(&a)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::report::Rate;
    use base::signature::Arguments;

    fn driver(name: &str, kind: &'static str) -> Driver {
        Driver {
            name: name.into(),
            kind,
            settings: Arguments::default(),
            changed: Vec::new(),
            sensors: None,
            sensor_model: None,
            surrogate: "",
        }
    }

    fn cell(policy: &str, fault: f64, moving: f64) -> Cell {
        let key = CellKey { policy: policy.into(), ..CellKey::default() };
        Cell::example(key, &[], &[(&FAULT_RATE, Rate::single(fault)), (&COLLISION_RATE, Rate::single(moving))])
    }

    #[test]
    fn drivers_are_ordered_by_their_worst_cell_and_those_that_see_no_pedestrians_are_last() {
        let drivers = [driver("blind", "cruise"), driver("good", "idm"), driver("bad", "idm"), driver("unused", "idm")];
        let cells = [
            cell("blind", 0.9, 0.9),
            cell("good", 0.0, 0.4),
            cell("bad", 0.1, 0.2),
            cell("bad", 0.1, 0.3),
            cell("bad", 0.0, 0.8),
        ];
        let results = driver_results(&drivers, &cells, &Failures::default(), &super::super::all_of_searches(&[]), &[]);
        let found: Vec<_> = results.iter().map(|result| (result.driver.name.as_str(), result.cell)).collect();
        assert_eq!(found, [("bad", Some(3)), ("good", Some(1)), ("blind", Some(0))]);
    }
}
