use super::common_starts::{CommonStarts, MetricByRun};
use crate::record::CellKey;
use crate::tables::Metric;
use base::choice;
use base::statistics::{MIN_RUNS, Uncertainty, disagreement, holm, mcnemar};

choice! {
    /// The method behind a p-value.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Test {
        /// Student's t over trainings, with the covariance of common starts. It generalises to further trainings and episodes.
        Student = "student",
        /// McNemar's exact test on pairs of episodes. It generalises to further episodes of these two pedestrians.
        McNemar = "mcnemar",
        /// No test: one training against several, two runs on a side, or no event in either cell.
        None = "",
    }
}

/// Two cells with common starts: two controllers against one driver, or one controller against two drivers.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub first: CellKey,
    /// The second, which is subtracted.
    pub second: CellKey,
    /// The compared figure.
    pub figure: &'static Metric,
    /// The number of runs of both.
    pub runs: [u64; 2],
    /// The number of starts of each run.
    pub episodes: u64,
    /// The value of both, mean over runs.
    pub values: [f64; 2],
    /// First less second.
    pub difference: f64,
    /// The values of the runs of either side; the differences of the runs, and nothing, where drivers are compared.
    pub by_run: [Vec<f64>; 2],
    /// The standard error of the difference about further trainings and episodes; `None` if a side is a single training.
    pub uncertainty: Option<Uncertainty>,
    /// Of single runs: the number of pairs of episodes with such an event in the first only, and in the second only.
    pub discordant: Option<(u64, u64)>,
    /// The method of p.
    pub test: Test,
    /// Probability of such a difference by chance.
    pub p: Option<f64>,
    /// The same, adjusted for all comparisons of controllers, or of drivers, of the campaign by Holm's method.
    pub holm: Option<f64>,
    /// An interval of the difference such that, in 95 % of campaigns, those of all comparisons of controllers, or of drivers, hold the truth
    /// (Bonferroni). None with two or three runs, and for a single training against several runs.
    pub interval: Option<(f64, f64)>,
}

impl Comparison {
    /// Whether a side has several runs, but too few for an interval. Where no pair of episodes disagrees, their number makes one.
    pub fn has_few_runs(&self) -> bool {
        let few = |runs: &u64| (2..MIN_RUNS as u64).contains(runs);
        self.runs.iter().any(few) && self.discordant != Some((0, 0))
    }

    /// An interval that misses the difference with a probability of at most `alpha`: Bonett and Price's for single runs, else Student's.
    pub fn interval_at(&self, alpha: f64) -> Option<(f64, f64)> {
        if let Some((only_first, only_second)) = self.discordant {
            return Some(disagreement(only_second, only_first, self.episodes, alpha));
        }
        if self.has_few_runs() {
            return None;
        }
        Some(cut(self.uncertainty?.interval_at(self.difference, alpha)))
    }

    /// Whether two drivers are compared.
    pub fn is_of_drivers(&self) -> bool {
        self.first.policy != self.second.policy
    }
}

/// The pairs that are compared. Against one driver: every trained pedestrian with every untrained one that has the same reward, and with the
/// same pedestrian trained for an earlier reward. Of drivers: each with each earlier one, met by the same pedestrian; one that is not
/// trained is compared for its first reward only, since it is the same for all.
pub fn pairs(place: &CommonStarts) -> Vec<(usize, usize)> {
    let keys = || (0..place.cells.len()).map(|cell| (cell, &place.runs(cell)[0].key));
    let mut pairs = Vec::new();
    for (first, a) in keys().filter(|(_, key)| key.is_trained()) {
        for (second, b) in keys().filter(|(_, b)| a.policy == b.policy) {
            let plain = !b.is_trained() && a.reward == b.reward;
            let same = a.controller == b.controller && a.train_town == b.train_town && a.train_policy == b.train_policy;
            if plain || (same && second < first) {
                pairs.push((first, second));
            }
        }
    }
    let repeats = |cell: usize, key: &CellKey| {
        let mut earlier = keys().take(cell);
        !key.is_of_reward() && earlier.any(|(_, b)| b.policy == key.policy && b.controller == key.controller)
    };
    for (first, a) in keys().filter(|(cell, key)| !repeats(*cell, key)) {
        let others = keys().take(first).filter(|(_, b)| a.policy != b.policy && a.has_controller_of(b));
        pairs.extend(others.map(|(second, _)| (first, second)));
    }
    pairs
}

/// Compares two cells of a place; `None` if one of them has no value.
pub fn compare(place: &CommonStarts, measured: &MetricByRun, (first, second): (usize, usize)) -> Option<Comparison> {
    let figure = measured.metric;
    let (ours, theirs) = (&place.runs(first)[0], &place.runs(second)[0]);
    let drivers = ours.key.policy != theirs.key.policy;
    let (sample, values, runs) = if drivers {
        let (sample, values) = place.paired(measured, first, second)?;
        let runs = [sample.values.len() as u64; 2];
        (sample, values, runs)
    } else {
        let sample = place.sample(measured, first, Some(second))?;
        let (a, b) = sample.values.split_at(sample.first);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (values, runs) = ([mean(a), mean(b)], [a.len() as u64, b.len() as u64]);
        (sample, values, runs)
    };
    let has_events = values.iter().any(|value| *value != 0.0);
    let single = runs == [1, 1] && [first, second].map(|cell| place.runs(cell).len()) == [1, 1];
    let discordant = single.then(|| ours.discordant(theirs, figure));
    let (test, p) = match (discordant, sample.p()) {
        // Neither could be significant, so it is no test and costs the others nothing.
        _ if !has_events => (Test::None, None),
        (Some((only_first, only_second)), _) => (Test::McNemar, Some(mcnemar(only_first, only_second))),
        (None, Some(p)) => (Test::Student, Some(p)),
        (None, None) => (Test::None, None),
    };
    Some(Comparison {
        first: ours.key.clone(),
        second: theirs.key.clone(),
        figure,
        runs,
        episodes: sample.episodes.count(),
        values,
        difference: sample.estimate(),
        uncertainty: sample.uncertainty(),
        by_run: [sample.values[..sample.first].to_vec(), sample.values[sample.first..].to_vec()],
        discordant,
        test,
        p,
        holm: None,
        interval: None,
    })
}

fn cut((low, high): (f64, f64)) -> (f64, f64) {
    (low.clamp(-1.0, 1.0), high.clamp(-1.0, 1.0))
}

/// Adjusts p and the interval for the number of comparisons: those of controllers and those of drivers separately, since they answer two
/// questions.
pub fn adjust(comparisons: &mut [Comparison]) {
    for drivers in [false, true] {
        let mut all: Vec<&mut Comparison> =
            comparisons.iter_mut().filter(|each| each.is_of_drivers() == drivers).collect();
        // Without a pair that disagrees a comparison could not be significant, and costs the others nothing.
        let is_tested = |each: &Comparison| each.p.is_some() && each.discordant != Some((0, 0));
        let raw: Vec<f64> = all.iter().filter(|each| is_tested(each)).filter_map(|each| each.p).collect();
        let mut adjusted = holm(&raw).into_iter();
        let alpha = 0.05 / all.len().max(1) as f64;
        for comparison in &mut all {
            comparison.holm = if is_tested(comparison) { adjusted.next() } else { comparison.p };
            comparison.interval = comparison.interval_at(alpha);
        }
    }
}
