use super::place::{Measured, Place};
use super::tried::Tried;
use super::{Figure, Learning};
use crate::record::CellKey;
use base::statistics::{ClusteredCount, MIN_RUNS, Sample, Uncertainty, quantile};
use world::judge::Reference;

/// The distribution of a figure between trainings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AcrossRuns {
    /// The value of each run, in order; none where a run has no value.
    pub by_run: Vec<Option<f64>>,
    /// The standard error of the mean about further trainings and episodes; none for a single training.
    pub uncertainty: Option<Uncertainty>,
    /// Student's 95 % interval of the mean, from that; none with fewer than four runs.
    pub interval: Option<(f64, f64)>,
}

/// Median and tails of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quantiles {
    /// The number of values.
    pub n: u64,
    /// The quantiles at the requested shares; none without values.
    pub at: [Option<f64>; 3],
}

impl Quantiles {
    fn new(mut values: Vec<f64>, shares: [f64; 3]) -> Self {
        values.sort_by(f64::total_cmp);
        Self { n: values.len() as u64, at: shares.map(|share| quantile(&values, share)) }
    }
}

/// The evidence on a cell, in addition to its means.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CellEvidence {
    pub key: CellKey,
    /// Episodes of all runs.
    pub episodes: ClusteredCount,
    /// Collisions of all runs.
    pub collisions: ClusteredCount,
    /// In the order of [`Figure::ALL`].
    pub between: [AcrossRuns; 8],
    /// Median, 90th and 99th percentile of the impact speeds (m/s).
    pub impact_speed: Quantiles,
    /// 1st and 10th percentile and median of the least times to collision of episodes without a collision (s).
    pub min_ttc: Quantiles,
    /// The same quantiles of post-encroachment times (s).
    pub pet: Quantiles,
    /// The number of collisions that each reference driver avoids, in the order of [`Reference::ALL`].
    pub avoided: [ClusteredCount; Reference::COUNT],
    /// Whether its trainings learnt; none for an untrained controller.
    pub learning: Option<Learning>,
    /// The samples of [`Figure::COMPARED`] with the numbers of their runs, for transfer gaps.
    pub(super) samples: [Option<(Vec<u32>, Sample)>; 3],
}

impl CellEvidence {
    /// Gathers a cell of a place; its figures are [measured](Self::measure) one by one.
    pub(super) fn new(place: &Place, cell: usize) -> Self {
        let runs = place.runs(cell);
        // Its runs share their starts, so a start counts once.
        let size = runs.len() as f64;
        let sum =
            |count: &dyn Fn(&Tried) -> ClusteredCount| runs.iter().map(count).sum::<ClusteredCount>().of_clusters(size);
        let all = |values: fn(&Tried) -> &Vec<f64>| runs.iter().flat_map(values).copied().collect();
        Self {
            key: runs[0].key.clone(),
            episodes: sum(&Tried::episodes),
            collisions: sum(&Tried::collisions),
            between: Default::default(),
            impact_speed: Quantiles::new(all(|run| &run.impact_speeds), [0.5, 0.9, 0.99]),
            min_ttc: Quantiles::new(all(|run| &run.min_ttc), [0.01, 0.1, 0.5]),
            pet: Quantiles::new(all(|run| &run.pet), [0.01, 0.1, 0.5]),
            avoided: std::array::from_fn(|driver| sum(&|run| run.avoided[driver])),
            learning: None,
            samples: Default::default(),
        }
    }

    /// Adds a figure of this cell of a place.
    pub(super) fn measure(&mut self, place: &Place, measured: &Measured, cell: usize) {
        let figure = measured.figure;
        let runs = place.cells[cell].clone();
        let by_run: Vec<Option<f64>> =
            measured.runs[runs.clone()].iter().map(|run| run.as_ref().map(|(value, _)| *value)).collect();
        let sample = place.sample(measured, cell, None);
        let (least, most) = figure.bounds();
        let cut = |(low, high): (f64, f64)| (low.clamp(least, most), high.clamp(least, most));
        self.between[figure as usize] = AcrossRuns {
            uncertainty: sample.as_ref().and_then(Sample::uncertainty),
            // One run says nothing of further ones, and two or three next to nothing.
            interval: sample.as_ref().filter(|_| by_run.len() >= MIN_RUNS).and_then(Sample::interval).map(cut),
            by_run,
        };
        if figure == Figure::Reward {
            self.learning = Learning::new(place, measured, cell);
        }
        if let Some(slot) = Figure::COMPARED.iter().position(|compared| *compared == figure) {
            let numbers = runs.filter(|run| measured.runs[*run].is_some()).map(|run| place.tried[run].run);
            self.samples[slot] = sample.map(|sample| (numbers.collect(), sample));
        }
    }

    /// The distribution of a figure between trainings.
    pub fn between(&self, figure: Figure) -> &AcrossRuns {
        &self.between[figure as usize]
    }

    /// The numbers of collisions that a reference driver would have avoided, and that it would not have avoided.
    pub fn split(&self, reference: Reference) -> (ClusteredCount, ClusteredCount) {
        let avoided = self.avoided[reference as usize];
        (avoided, self.collisions - avoided)
    }
}
