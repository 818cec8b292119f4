use super::Figure;
use super::place::{Measured, Place};
use crate::record::CellKey;
use crate::seed::Seed;
use crate::statistics::{benjamini_hochberg, holm, mcnemar};

/// The method behind a p-value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Test {
    /// Student's t over trainings, with the covariance of common starts. It generalises to further trainings and episodes.
    Student,
    /// McNemar's exact test on pairs of episodes. It generalises to further episodes of these two pedestrians.
    McNemar,
    /// No test: one training against several, or no event in either cell.
    None,
}

impl Test {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Student => "student",
            Self::McNemar => "mcnemar",
            Self::None => "",
        }
    }
}

/// Two cells with common starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The first.
    pub first: CellKey,
    /// The second, which is subtracted.
    pub second: CellKey,
    /// The compared figure.
    pub figure: Figure,
    /// The number of runs of both.
    pub runs: [u64; 2],
    /// The number of starts of each run.
    pub episodes: u64,
    /// The value of both, mean over runs.
    pub values: [f64; 2],
    /// First less second.
    pub difference: f64,
    /// 95 % interval by hierarchical bootstrap on common starts.
    pub bootstrap: (f64, f64),
    /// Student's 95 % interval.
    pub student: Option<(f64, f64)>,
    /// The method of p.
    pub test: Test,
    /// Probability of such a difference by chance.
    pub p: Option<f64>,
    /// The same, adjusted for all comparisons of the campaign by Holm's method.
    pub holm: Option<f64>,
    /// The same by Benjamini and Hochberg's.
    pub benjamini_hochberg: Option<f64>,
}

/// The pairs that are compared: every trained pedestrian with every untrained one that has the same reward, and with the same pedestrian
/// trained for an earlier reward.
pub fn pairs(place: &Place) -> Vec<(usize, usize)> {
    let keys = || (0..place.cells.len()).map(|cell| (cell, &place.runs(cell)[0].key));
    let mut pairs = Vec::new();
    for (first, a) in keys().filter(|(_, key)| key.is_trained()) {
        for (second, b) in keys() {
            let plain = !b.is_trained() && a.reward == b.reward;
            let same = a.controller == b.controller && a.train_town == b.train_town && a.train_policy == b.train_policy;
            if plain || (same && second < first) {
                pairs.push((first, second));
            }
        }
    }
    pairs
}

/// Compares two cells of a place; none when one of them has no value.
pub fn compare(place: &Place, measured: &Measured, (first, second): (usize, usize), seed: &Seed) -> Option<Comparison> {
    let (figure, sample) = (measured.figure, place.sample(measured, first, Some(second))?);
    let (ours, theirs) = (&place.runs(first)[0], &place.runs(second)[0]);
    let seed = theirs.key.controller_seed(&ours.key.controller_seed(&seed.child("comparison")));
    let (a, b) = sample.values.split_at(sample.first);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let cut = |(low, high): (f64, f64)| (low.clamp(-1.0, 1.0), high.clamp(-1.0, 1.0));
    let plain = ours.episodes().is_plain() && theirs.episodes().is_plain();
    // An exact test counts pairs; there is none for pairs of different weights.
    let has_events = sample.values.iter().any(|value| *value != 0.0);
    let (test, p, student) = if !has_events {
        // Neither could be significant, so it is no test and costs the others nothing.
        (Test::None, None, sample.student().map(|found| cut((found.low, found.high))))
    } else if plain && a.len() == 1 && b.len() == 1 {
        let (only_first, only_second) = ours.discordant(theirs, figure);
        (Test::McNemar, Some(mcnemar(only_first, only_second)), None)
    } else {
        match sample.student() {
            Some(found) => (Test::Student, Some(found.p), Some(cut((found.low, found.high)))),
            None => (Test::None, None, None),
        }
    };
    Some(Comparison {
        first: ours.key.clone(),
        second: theirs.key.clone(),
        figure,
        runs: [a.len() as u64, b.len() as u64],
        episodes: sample.episodes.count(),
        values: [mean(a), mean(b)],
        difference: sample.estimate(),
        bootstrap: cut(sample.bootstrap(&seed.child(figure.name()))),
        student,
        test,
        p,
        holm: None,
        benjamini_hochberg: None,
    })
}

/// Adjusts p for the number of comparisons.
pub fn adjust(comparisons: &mut [Comparison]) {
    let raw: Vec<f64> = comparisons.iter().filter_map(|comparison| comparison.p).collect();
    let tested = comparisons.iter_mut().filter(|comparison| comparison.p.is_some());
    for (comparison, (first, second)) in tested.zip(holm(&raw).into_iter().zip(benjamini_hochberg(&raw))) {
        (comparison.holm, comparison.benjamini_hochberg) = (Some(first), Some(second));
    }
}
