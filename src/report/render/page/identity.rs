use std::collections::BTreeMap;

use polars::prelude::*;

use super::super::summary::{place, training};
use super::tally::CellKey;
use crate::report::Cell;

/// The key by which tables and tallies know a cell.
pub fn key(cell: &Cell) -> CellKey {
    let (town, policy) = cell.trained.clone();
    let names = [
        cell.pedestrian.clone(),
        cell.reward.clone(),
        town,
        policy,
        cell.town.clone(),
        cell.policy.clone(),
        cell.vehicle.clone(),
        cell.adversary.clone(),
    ];
    (names, cell.block)
}

/// A cell with what it is called on the page.
#[derive(Debug, Clone)]
pub struct Named<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// Its key.
    pub key: CellKey,
    /// Who tries, with what tells it from the others.
    pub who: String,
    /// Where and against whom.
    pub place: String,
    /// Number of the colour of who tries: the same in all figures.
    pub colour: usize,
}

/// Names the cells of a page and gives those who try their colours.
///
/// An untrained pedestrian does the same for every reward, so only its first row is kept: the others differ in what it is paid.
pub fn named(cells: &[Cell]) -> Vec<Named<'_>> {
    let trainings = cells.iter().filter(|cell| !cell.trained.0.is_empty());
    let several = trainings.clone().any(|cell| trainings.clone().any(|other| other.trained != cell.trained));
    let mut all: Vec<Named<'_>> = Vec::new();
    let mut learners: Vec<String> = Vec::new();
    for cell in cells {
        let learnt = !cell.trained.0.is_empty();
        let mut who = match (learnt, cell.pedestrian.as_str()) {
            (true, "trained") => format!("trained, {}", cell.reward),
            (true, other) => format!("{other}, {}", cell.reward),
            (false, other) => other.to_string(),
        };
        if learnt && several {
            who = format!("{who} ({})", training(cell));
        }
        let place = format!("{} · {}", place(cell, cells), cell.policy);
        if !learnt && all.iter().any(|other| other.who == who && other.place == place) {
            continue;
        }
        let colour = match cell.pedestrian.as_str() {
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
        all.push(Named { cell, key: key(cell), who, place, colour });
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

/// The rates that a row of results shows: what share of all episodes it is of, by column of `runs`.
pub const RATES: [&str; 3] = ["collision", "moving", "preventable"];

/// What the runs of a cell say, for each of [`RATES`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunRates {
    /// Episodes of all runs.
    pub episodes: u64,
    /// Failures of all runs.
    pub failures: [u64; 3],
    /// The rate of each run.
    pub rates: [Vec<f64>; 3],
}

/// Reads the rates of each cell's runs from the table of runs.
///
/// # Errors
/// Those of polars; none for a table made by [`metrics`](crate::report::metrics).
pub fn run_rates(runs: &DataFrame) -> PolarsResult<BTreeMap<CellKey, RunRates>> {
    let text = |name: &str| -> PolarsResult<StringChunked> { Ok(runs.column(name)?.str()?.clone()) };
    let whole = |name: &str| -> PolarsResult<UInt32Chunked> { Ok(runs.column(name)?.u32()?.clone()) };
    let names = ["pedestrian", "reward", "train_town", "train_policy", "town", "policy", "vehicle", "adversary"];
    let names = names.iter().map(|name| text(name)).collect::<PolarsResult<Vec<_>>>()?;
    let (block, episodes) = (whole("block")?, whole("episodes")?);
    let counts = RATES.iter().map(|rate| {
        let name = if *rate == "collision" { "collisions".to_string() } else { format!("{rate}_collisions") };
        whole(&name)
    });
    let counts = counts.collect::<PolarsResult<Vec<_>>>()?;
    let mut all: BTreeMap<CellKey, RunRates> = BTreeMap::new();
    for row in 0..runs.height() {
        let names = std::array::from_fn(|column| names[column].get(row).unwrap_or_default().to_string());
        let found = all.entry((names, block.get(row).unwrap_or_default())).or_default();
        let tried = u64::from(episodes.get(row).unwrap_or_default());
        found.episodes += tried;
        for (number, count) in counts.iter().enumerate() {
            let count = u64::from(count.get(row).unwrap_or_default());
            found.failures[number] += count;
            if tried > 0 {
                found.rates[number].push(count as f64 / tried as f64);
            }
        }
    }
    Ok(all)
}
