use polars::prelude::{DataFrame, PolarsResult};

use super::Figure;
use super::cell::CellEvidence;
use super::comparison::{Comparison, adjust, compare, pairs};
use super::place::Place;
use super::transfer::{Transfer, transfers};
use super::tried::Tried;
use crate::seed::Seed;

/// Everything that a campaign shows beside means.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// One for each cell, in the order of first appearance.
    pub cells: Vec<CellEvidence>,
    /// Pedestrians of the same place.
    pub comparisons: Vec<Comparison>,
    /// The same pedestrian in two places.
    pub transfers: Vec<Transfer>,
}

/// Gathers the evidence from the episodes of a campaign, run by run in the plan's order: one table for each run of a pedestrian in
/// one town against one policy. The resampling hangs on the seed and the names of a place alone.
///
/// # Errors
/// Those of the runs; none of its own for tables made by [`episodes`](crate::report::episodes).
pub fn evidence(runs: impl IntoIterator<Item = PolarsResult<DataFrame>>, seed: &Seed) -> PolarsResult<Evidence> {
    let mut found = Evidence::default();
    let mut here: Vec<Tried> = Vec::new();
    for run in runs {
        let run = run?;
        if run.height() == 0 {
            continue;
        }
        let tried = Tried::new(&run)?;
        if here.first().is_some_and(|first| !first.key.is_beside(&tried.key)) {
            found.add(std::mem::take(&mut here), seed);
        }
        here.push(tried);
    }
    found.add(here, seed);
    adjust(&mut found.comparisons);
    found.transfers = transfers(&found.cells, &seed.child("transfer"));
    Ok(found)
}

impl Evidence {
    /// Adds all runs of a place.
    fn add(&mut self, runs: Vec<Tried>, seed: &Seed) {
        let Some(first) = runs.first() else { return };
        let seed = first.key.place(seed);
        let place = Place::new(runs);
        let mut cells: Vec<_> = (0..place.cells.len()).map(|cell| CellEvidence::new(&place, cell)).collect();
        let pairs = pairs(&place);
        let mut comparisons = Vec::new();
        // One figure after the other, since each takes a number for every episode.
        for figure in Figure::ALL {
            let measured = place.measure(figure);
            for (number, cell) in cells.iter_mut().enumerate() {
                let seed = cell.key.who(&seed.child("cell"));
                cell.measure(&place, &measured, number, &seed);
            }
            if Figure::COMPARED.contains(&figure) {
                let found =
                    pairs.iter().enumerate().map(|(rank, pair)| (rank, compare(&place, &measured, *pair, &seed)));
                comparisons.extend(found);
            }
        }
        comparisons.sort_by_key(|(rank, _)| *rank);
        self.cells.extend(cells);
        self.comparisons.extend(comparisons.into_iter().filter_map(|(_, comparison)| comparison));
    }
}
