use polars::prelude::{DataFrame, PolarsResult};

use super::Figure;
use super::cell::CellEvidence;
use super::comparison::{Comparison, adjust, compare, pairs};
use super::place::Place;
use super::transfer::{Transfer, transfers};
use super::tried::{KEPT, Tried};
use crate::seed::Seed;

/// What the results of a campaign show beside means.
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
/// one town against one policy. The resampling depends on the seed and the names of a place alone.
#[derive(Debug, Clone)]
pub struct Gathering {
    seed: Seed,
    kept: usize,
    here: Vec<Tried>,
    found: Evidence,
}

impl Gathering {
    /// Begins without any run.
    pub fn new(seed: Seed) -> Self {
        Self::keeping(KEPT, seed)
    }

    /// Begins with another number of episodes that are looked at one by one.
    pub(super) fn keeping(kept: usize, seed: Seed) -> Self {
        Self { seed, kept, here: Vec::new(), found: Evidence::default() }
    }

    /// Adds all episodes of a run.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::record::episodes).
    pub fn add(&mut self, run: &DataFrame) -> PolarsResult<()> {
        if run.height() == 0 {
            return Ok(());
        }
        let tried = Tried::new(run, self.kept)?;
        if self.here.first().is_some_and(|first| !first.key.is_beside(&tried.key)) {
            self.found.add(std::mem::take(&mut self.here), &self.seed);
        }
        self.here.push(tried);
        Ok(())
    }

    /// What all runs show together.
    pub fn finish(mut self) -> Evidence {
        self.found.add(self.here, &self.seed);
        adjust(&mut self.found.comparisons);
        self.found.transfers = transfers(&self.found.cells, &self.seed.child("transfer"));
        self.found
    }
}

impl Evidence {
    /// Adds all runs of a place.
    fn add(&mut self, runs: Vec<Tried>, seed: &Seed) {
        let Some(first) = runs.first() else { return };
        let seed = first.key.place_seed(seed);
        let place = Place::new(runs);
        let mut cells: Vec<_> = (0..place.cells.len()).map(|cell| CellEvidence::new(&place, cell)).collect();
        let pairs = pairs(&place);
        let mut comparisons = Vec::new();
        // One figure after the other, since each takes a number for every episode.
        for figure in Figure::ALL {
            let measured = place.measure(figure);
            for (number, cell) in cells.iter_mut().enumerate() {
                let seed = cell.key.controller_seed(&seed.child("cell"));
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
