use crate::record::CellKey;
use crate::report::CellEvidence;
use crate::tables::Rate;
use crate::tables::metrics::inferred;
use crate::tables::{Cell, Metric};
use base::statistics::{MIN_RUNS, Uncertainty};
use compile::{Published, PublishedCell, PublishedFigure};

/// The largest spread that is printed as 0.00.
const ROUNDED_AWAY: f64 = 0.004;

/// One of our figures compared with a published one.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedComparison<'a> {
    /// The source of the published one.
    pub source: &'a str,
    /// Its documentation in the scenario.
    pub docs: &'a str,
    /// Our cell.
    pub key: CellKey,
    /// The number of our trainings.
    pub runs: u32,
    /// The published figure; its column names the column of the cell that it is compared with.
    pub published: PublishedFigure,
    /// The number of trainings in its average.
    pub published_runs: u32,
    /// Our figure.
    pub ours: Rate,
    /// Our figure less the published one; `None` if ours has no value.
    pub difference: Option<f64>,
    /// Student's 95 % interval of the difference: of ours over trainings and starts, of the published one over its trainings alone, since
    /// no publication states what its starts add. A published spread of 0.00 counts as 0.004. `None` without spreads, and if either side has fewer than
    /// four trainings.
    pub interval: Option<(f64, f64)>,
}

impl PublishedComparison<'_> {
    /// The published mean and spread.
    pub fn theirs(&self) -> Rate {
        Rate { value: Some(self.published.mean), sd: self.published.sd, ..Rate::default() }
    }
}

/// Compares published figures with those of our trained pedestrians, in the order of the published cells.
///
/// `evidence` has the evidence on the cells.
pub fn beside<'a>(
    published: &'a [Published],
    cells: &[Cell],
    evidence: &[CellEvidence],
) -> Vec<PublishedComparison<'a>> {
    let mut all = Vec::new();
    for table in published {
        for (theirs, cell) in table.cells.iter().flat_map(|theirs| matching(theirs, cells)) {
            let found = evidence.iter().find(|found| found.key == cell.key);
            all.extend(theirs.figures.iter().map(|figure| compare(table, *figure, cell, found)));
        }
    }
    all
}

fn matching<'a>(theirs: &'a PublishedCell, cells: &'a [Cell]) -> impl Iterator<Item = (&'a PublishedCell, &'a Cell)> {
    let trained = |cell: &&Cell| ["trained", "stochastic"].contains(&cell.key.controller.as_str());
    let same = move |cell: &&Cell| {
        theirs.rewards.contains(&cell.key.reward)
            && theirs.towns.contains(&cell.key.town)
            && theirs.policies.contains(&cell.key.policy)
    };
    cells.iter().filter(trained).filter(same).map(move |cell| (theirs, cell))
}

fn compare<'a>(
    table: &'a Published,
    published: PublishedFigure,
    cell: &Cell,
    evidence: Option<&CellEvidence>,
) -> PublishedComparison<'a> {
    let figure = figure(published.column).expect("checked: every published figure is one of a cell");
    let ours = cell.rate(figure);
    let difference = ours.value.map(|mean| mean - published.mean);
    let here = evidence.and_then(|found| found.uncertainty(figure));
    let there = published.sd.and_then(|sd| Uncertainty::of_mean(sd.max(ROUNDED_AWAY), table.runs));
    let few = |runs: u32| (runs as usize) < MIN_RUNS;
    let uncertainty = here.zip(there).filter(|_| !few(cell.runs()) && !few(table.runs));
    let interval = uncertainty.zip(difference).map(|((here, there), by)| here.of_difference(there).interval(by));
    let (source, docs) = (&table.source, &table.docs);
    PublishedComparison {
        source,
        docs,
        key: cell.key.clone(),
        runs: cell.runs(),
        published,
        published_runs: table.runs,
        ours,
        difference,
        interval,
    }
}

/// The figure that a published one is compared with, by its column without `_mean`.
fn figure(column: &str) -> Option<&'static Metric> {
    inferred().find(|metric| metric.name == column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_that_can_be_published_is_one_of_a_cell() {
        for column in compile::published_columns() {
            assert!(figure(column).is_some(), "{column}");
        }
    }
}
