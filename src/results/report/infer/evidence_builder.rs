use super::cell::CellEvidence;
use super::common_starts::CommonStarts;
use super::comparison::{Comparison, adjust, compare, pairs};
use super::evaluated_run::{EvaluatedRun, MAX_KEPT};
use super::learning;
use crate::record::RunKey;
use crate::tables::metrics::{Inference, inferred};
use polars::prelude::{DataFrame, PolarsResult};

/// The evidence of a campaign's results, in addition to means.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// One for each cell, in the order of first appearance.
    pub cells: Vec<CellEvidence>,
    /// Comparisons of pedestrians, and of drivers, of the same place.
    pub comparisons: Vec<Comparison>,
}

/// Gathers the evidence from the episodes of a campaign, run by run in the plan's order. A run is one table or several that follow each
/// other, for a pedestrian in one town against one policy.
#[derive(Debug, Clone)]
pub struct EvidenceBuilder {
    kept: usize,
    /// The run of the last rows, of which more may follow.
    last: Option<(RunKey, EvaluatedRun)>,
    here: Vec<EvaluatedRun>,
    found: Evidence,
}

impl Default for EvidenceBuilder {
    /// Without any run.
    fn default() -> Self {
        Self::keeping(MAX_KEPT)
    }
}

impl EvidenceBuilder {
    /// Starts with another number of episodes of a run that are kept one by one.
    pub(super) fn keeping(kept: usize) -> Self {
        Self { kept, last: None, here: Vec::new(), found: Evidence::default() }
    }

    /// Adds the episodes of a run or of a part of it. The parts of a run follow each other.
    ///
    /// # Errors
    /// Those of polars; none for a table of episodes.
    pub fn add(&mut self, key: &RunKey, rows: &DataFrame) -> PolarsResult<()> {
        if self.last.as_ref().is_none_or(|(last, _)| last != key) {
            self.close();
        }
        let (_, run) = self.last.get_or_insert_with(|| (key.clone(), EvaluatedRun::new(key.clone(), self.kept)));
        run.add(rows)
    }

    /// Ends the run of the last rows.
    fn close(&mut self) {
        let Some((_, tried)) = self.last.take() else { return };
        if self.here.first().is_some_and(|first| !first.key.is_beside(&tried.key)) {
            self.found.add(std::mem::take(&mut self.here));
        }
        self.here.push(tried);
    }

    /// The evidence of all runs.
    pub fn finish(mut self) -> Evidence {
        self.close();
        self.found.add(self.here);
        adjust(&mut self.found.comparisons);
        learning::adjust(&mut self.found.cells);
        self.found
    }
}

impl Evidence {
    /// Adds all runs of a place.
    fn add(&mut self, runs: Vec<EvaluatedRun>) {
        if runs.is_empty() {
            return;
        }
        let place = CommonStarts::new(runs);
        let mut cells: Vec<_> = (0..place.cells.len()).map(|cell| CellEvidence::new(&place, cell)).collect();
        let pairs = pairs(&place);
        let mut comparisons = Vec::new();
        // One metric after the other, since each needs a number for every episode.
        for metric in inferred() {
            let measured = place.measure(metric);
            for (number, cell) in cells.iter_mut().enumerate() {
                cell.measure(&place, &measured, number);
            }
            if metric.inference == Inference::Pairs {
                let found = pairs.iter().enumerate().map(|(rank, pair)| (rank, compare(&place, &measured, *pair)));
                comparisons.extend(found);
            }
        }
        comparisons.sort_by_key(|(rank, _)| *rank);
        self.cells.extend(cells);
        self.comparisons.extend(comparisons.into_iter().filter_map(|(_, comparison)| comparison));
    }
}
