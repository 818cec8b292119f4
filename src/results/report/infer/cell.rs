use std::collections::BTreeMap;

use super::common_starts::{CommonStarts, MetricByRun};
use super::evaluated_run::EvaluatedRun;
use super::{Learning, reference_rates};
use crate::record::{CellKey, ColumnReference};
use crate::tables::metrics::EPISODE_REWARD;
use crate::tables::{Metric, Rate};
use base::statistics::{ClusteredCount, MIN_RUNS, Sample, Uncertainty, bounded_interval, quantile};
use verdict::Reference;

/// The evidence on a cell, in addition to its means.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CellEvidence {
    pub key: CellKey,
    /// Episodes of all runs.
    pub episodes: ClusteredCount,
    /// Collisions of all runs.
    pub collisions: ClusteredCount,
    /// The [inferred](crate::tables::metrics::inferred) metrics over trainings with Student's interval, by their names.
    pub between: BTreeMap<&'static str, Rate>,
    /// The standard errors of these about further trainings and episodes; none for a single training.
    pub uncertainties: BTreeMap<&'static str, Uncertainty>,
    /// 90th percentile of the impact speeds (m/s), and the number of collisions that it is of; `None` without a collision.
    pub impact_speed_p90: (Option<f64>, u64),
    /// The number of collisions that each reference driver avoids, in the order of [`Reference::ALL`].
    pub avoided: [ClusteredCount; Reference::COUNT],
    /// The number of episodes in which each would have braked needlessly.
    pub needless: [ClusteredCount; Reference::COUNT],
    /// How its trainings compare with untrained pedestrians; `None` for an untrained controller.
    pub learning: Option<Learning>,
}

impl CellEvidence {
    /// Gathers a cell of a place; its metrics are [measured](Self::measure) one by one.
    pub(super) fn new(place: &CommonStarts, cell: usize) -> Self {
        let runs = place.runs(cell);
        // Its runs share their starts, so a start counts once.
        let size = runs.len() as f64;
        let sum = |count: &dyn Fn(&EvaluatedRun) -> ClusteredCount| {
            runs.iter().map(count).sum::<ClusteredCount>().of_clusters(size)
        };
        let mut speeds: Vec<f64> = runs.iter().flat_map(|run| &run.impact_speeds).copied().collect();
        speeds.sort_by(f64::total_cmp);
        Self {
            key: runs[0].key.clone(),
            episodes: sum(&EvaluatedRun::episodes),
            collisions: sum(&EvaluatedRun::collisions),
            between: Default::default(),
            uncertainties: Default::default(),
            impact_speed_p90: (quantile(&speeds, 0.9), speeds.len() as u64),
            avoided: std::array::from_fn(|driver| sum(&|run| run.avoided[driver])),
            needless: std::array::from_fn(|driver| sum(&|run| run.needless[driver])),
            learning: None,
        }
    }

    /// Adds a figure of this cell of a place.
    pub(super) fn measure(&mut self, place: &CommonStarts, measured: &MetricByRun, cell: usize) {
        let metric = measured.metric;
        let runs = &measured.runs[place.cells[cell].clone()];
        let by_run: Vec<f64> = runs.iter().flatten().map(|(value, _)| *value).collect();
        let sample = place.sample(measured, cell, None);
        self.uncertainties.extend(sample.as_ref().and_then(Sample::uncertainty).map(|found| (metric.name, found)));
        // One run says nothing of further ones, and two or three next to nothing.
        let interval = sample.as_ref().filter(|_| runs.len() >= MIN_RUNS).and_then(Sample::interval);
        let interval = sample
            .as_ref()
            .zip(interval)
            .map(|(sample, (low, high))| bounded_interval(sample.estimate(), (high - low) / 2.0, metric.bounds()));
        self.between.insert(metric.name, Rate::of_runs(by_run).within(interval));
        if *metric == EPISODE_REWARD {
            self.learning = Learning::new(place, measured, cell);
        }
    }

    /// A metric over trainings; `None` if nothing is inferred of it.
    pub fn between(&self, metric: &Metric) -> Option<&Rate> {
        self.between.get(metric.name)
    }

    /// The standard error of a metric about further trainings and episodes; `None` for a single training.
    pub fn uncertainty(&self, metric: &Metric) -> Option<Uncertainty> {
        self.uncertainties.get(metric.name).copied()
    }

    /// The number of collisions that a reference driver would not have avoided.
    pub fn remaining(&self, reference: Reference) -> ClusteredCount {
        self.collisions - self.avoided[reference as usize]
    }

    /// The metrics of a reference driver, with the number of episodes that each is a rate of.
    pub fn rates_of(&self, reference: Reference) -> [(ColumnReference, ClusteredCount); 2] {
        let counts = [self.remaining(reference), self.needless[reference as usize]];
        let [remaining, needless] = reference_rates(reference);
        [(remaining, counts[0]), (needless, counts[1])]
    }
}
