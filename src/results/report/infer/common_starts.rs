use std::ops::Range;

use super::evaluated_run::EvaluatedRun;
use crate::report::grouped::grouped;
use crate::tables::Metric;
use base::statistics::{ClusteredCount, Sample};

/// All runs with common starts; the runs of a cell are consecutive.
pub struct CommonStarts {
    pub evaluated: Vec<EvaluatedRun>,
    /// The indices of the runs of each cell.
    pub cells: Vec<Range<usize>>,
}

impl CommonStarts {
    /// Sorts runs into cells, in the order of first appearance.
    pub fn new(runs: Vec<EvaluatedRun>) -> Self {
        let groups = grouped(runs, |run| run.key.clone());
        let mut end = 0;
        let cells = groups.iter().map(|group| {
            end += group.len();
            end - group.len()..end
        });
        Self { cells: cells.collect(), evaluated: groups.into_iter().flatten().collect() }
    }

    pub fn runs(&self, cell: usize) -> &[EvaluatedRun] {
        &self.evaluated[self.cells[cell].clone()]
    }

    pub fn measure(&self, metric: &'static Metric) -> MetricByRun {
        MetricByRun { metric, runs: self.evaluated.iter().map(|run| run.influence(metric)).collect() }
    }

    /// A figure of one cell, or of its difference from another; `None` if a cell has no value.
    pub fn sample(&self, measured: &MetricByRun, cell: usize, other: Option<usize>) -> Option<Sample> {
        let known = |cell: usize| self.cells[cell].clone().filter(|run| measured.runs[*run].is_some());
        let first: Vec<usize> = known(cell).collect();
        let second: Vec<usize> = other.into_iter().flat_map(known).collect();
        if first.is_empty() || (other.is_some() && second.is_empty()) {
            return None;
        }
        let members = [first.as_slice(), second.as_slice()].concat();
        let (values, influences): (Vec<f64>, Vec<&Vec<f64>>) = members
            .iter()
            .filter_map(|run| measured.runs[*run].as_ref())
            .map(|(value, influences)| (*value, influences))
            .unzip();
        let covariance = self.covariance(&influences, &members);
        let trained = |cell: usize| self.runs(cell)[0].key.is_trained();
        Some(Sample {
            values,
            covariance,
            first: first.len(),
            trained: [trained(cell), other.is_some_and(trained)],
            episodes: least(members.iter().map(|run| self.evaluated[*run].episodes())),
        })
    }

    /// The difference of a figure between two cells with the same controller, run by run: the runs of a number are one training, or draw the
    /// same numbers. With the means of both cells over these runs; `None` if no run has a value in both.
    pub fn paired(&self, measured: &MetricByRun, first: usize, second: usize) -> Option<(Sample, [f64; 2])> {
        let known = |run: &usize| Some((*run, measured.runs[*run].as_ref()?));
        let partner = |run: usize| {
            let same = |other: &usize| self.evaluated[*other].run == self.evaluated[run].run;
            self.cells[second].clone().find(same).as_ref().and_then(known)
        };
        let pairs: Vec<_> = self.cells[first].clone().filter_map(|run| Some((known(&run)?, partner(run)?))).collect();
        if pairs.is_empty() {
            return None;
        }
        let apart = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let at = |influences: &[f64], episode: usize| influences.get(episode).copied().unwrap_or(0.0);
            (0..a.len().max(b.len())).map(|episode| at(a, episode) - at(b, episode)).collect()
        };
        let influences: Vec<Vec<f64>> = pairs.iter().map(|((_, (_, a)), (_, (_, b)))| apart(a, b)).collect();
        let members: Vec<usize> = pairs.iter().map(|((run, _), _)| *run).collect();
        let both = pairs.iter().flat_map(|((run, _), (other, _))| [*run, *other]);
        let n = pairs.len() as f64;
        let sample = Sample {
            values: pairs.iter().map(|((_, (a, _)), (_, (b, _)))| a - b).collect(),
            covariance: self.covariance(&influences.iter().collect::<Vec<_>>(), &members),
            first: pairs.len(),
            trained: [self.runs(first)[0].key.is_trained(), false],
            episodes: least(both.map(|run| self.evaluated[run].episodes())),
        };
        let means = [
            pairs.iter().map(|((_, (a, _)), _)| a).sum::<f64>() / n,
            pairs.iter().map(|(_, (_, (b, _)))| b).sum::<f64>() / n,
        ];
        Some((sample, means))
    }

    /// The covariances of figures of these runs due to the draw of episodes (n × n), from the influence of each episode on each figure.
    fn covariance(&self, influences: &[&Vec<f64>], members: &[usize]) -> Vec<f64> {
        let n = influences.len();
        let mut covariance = vec![0.0; n * n];
        for (i, a) in influences.iter().enumerate() {
            for (j, b) in influences.iter().enumerate().skip(i) {
                let kept: f64 = a.iter().zip(*b).map(|(a, b)| a * b).sum();
                let common = kept * self.evaluated[members[i]].scale_to_all(&self.evaluated[members[j]]);
                (covariance[i * n + j], covariance[j * n + i]) = (common, common);
            }
        }
        covariance
    }
}

/// The count with the least effective size.
pub fn least(counts: impl Iterator<Item = ClusteredCount>) -> ClusteredCount {
    counts.min_by(|a, b| a.effective_size().total_cmp(&b.effective_size())).unwrap_or_default()
}

/// A figure of all runs of a place.
pub struct MetricByRun {
    pub metric: &'static Metric,
    /// For each run, if it has one: the value, and the influence of each kept episode on it.
    pub runs: Vec<Option<(f64, Vec<f64>)>>,
}
