use std::collections::BTreeMap;

use polars::prelude::{DataFrame, PolarsResult};

use super::super::sections::{distinct, place, who};
use crate::record::{CellKey, metric};
use crate::report::Cell;
use base::statistics::ClusteredCount;

/// A cell with its name on the page.
#[derive(Debug, Clone)]
pub struct Named<'a> {
    pub cell: &'a Cell,
    /// The controller, with what distinguishes it from the others.
    pub who: String,
    /// The place and the driver.
    pub place: String,
    /// Number of the colour of the controller: the same in all figures.
    pub colour: usize,
}

/// Names the cells of a page and gives controllers their colours. Rows that would be the same twice are there once.
pub fn named(cells: &[Cell]) -> Vec<Named<'_>> {
    let mut all: Vec<Named<'_>> = Vec::new();
    let mut learners: Vec<String> = Vec::new();
    for cell in distinct(cells) {
        let who = who(cell, cells);
        let place = format!("{} · {}", place(cell, cells), cell.key.policy);
        let colour = match cell.key.controller.as_str() {
            "random" => 6,
            "intercept" => 2,
            "homing" => 4,
            _ => {
                let number = learners.iter().position(|other| *other == who).unwrap_or(learners.len());
                if number == learners.len() {
                    learners.push(who.clone());
                }
                [0, 1, 3, 5, 4, 2][number % 6]
            }
        };
        all.push(Named { cell, who, place, colour });
    }
    all
}

/// The places of a page in order of appearance, each with its cells.
pub fn places<'a, 'b>(cells: &'b [Named<'a>]) -> Vec<(&'b str, Vec<&'b Named<'a>>)> {
    let mut all: Vec<(&str, Vec<&Named<'a>>)> = Vec::new();
    for cell in cells {
        match all.iter_mut().find(|(place, _)| *place == cell.place) {
            Some((_, members)) => members.push(cell),
            None => all.push((&cell.place, vec![cell])),
        }
    }
    all
}

/// The rates in a row of results; each is a share of all episodes.
pub const RATES: [metric::Rate; 3] = [metric::COLLISION_RATE, metric::PREVENTABLE_RATE, metric::FAULT_RATE];

/// The rates of the runs of a cell, for each of [`RATES`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunRates {
    /// Episodes of all runs.
    pub episodes: ClusteredCount,
    /// Failures of all runs.
    pub failures: [ClusteredCount; 3],
    /// The rate of each run.
    pub rates: [Vec<f64>; 3],
}

/// Reads the rates of each cell's runs from the table of runs.
///
/// # Errors
/// Those of polars; none for a table made by [`metrics`](crate::report::metrics).
pub fn run_rates(runs: &DataFrame) -> PolarsResult<BTreeMap<CellKey, RunRates>> {
    let episodes = metric::EPISODES.read(runs)?;
    let counts = RATES.map(|rate| rate.part.read(runs));
    let counts = counts.into_iter().collect::<PolarsResult<Vec<_>>>()?;
    let mut all: BTreeMap<CellKey, RunRates> = BTreeMap::new();
    for row in 0..runs.height() {
        let found = all.entry(CellKey::read(runs, row)?).or_default();
        let tried = u64::from(episodes.get(row).unwrap_or_default());
        found.episodes += tried.into();
        for (number, count) in counts.iter().enumerate() {
            let count = u64::from(count.get(row).unwrap_or_default());
            found.failures[number] += count.into();
            if tried > 0 {
                found.rates[number].push(count as f64 / tried as f64);
            }
        }
    }
    Ok(all)
}
