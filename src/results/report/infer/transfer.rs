use std::collections::BTreeMap;

use super::place::{Measured, Place, least};
use super::{CellEvidence, Figure};
use crate::record::CellKey;
use base::choice;
use base::statistics::Sample;

choice! {
    /// The change from the place of the training.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Change {
        Town = "town",
        /// The driver.
        Policy = "policy",
    }
}

/// The loss of a trained pedestrian in another town or against another driver.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    /// The place of the training.
    pub home: CellKey,
    /// The place of the evaluation.
    pub away: CellKey,
    /// The change there.
    pub change: Change,
    pub figure: Figure,
    /// Trainings that were evaluated in both places.
    pub runs: u64,
    /// The figure at home and away, mean over these.
    pub values: [f64; 2],
    /// Home less away: above 0 the part that does not transfer.
    pub gap: f64,
    /// Student's 95 % interval over the gaps of the trainings and over episodes; none for fewer than four trainings.
    pub interval: Option<(f64, f64)>,
    /// The gap of each training.
    pub by_run: Vec<f64>,
}

/// The gaps between two drivers in one town, by the numbers of both cells and the figure. They have the same starts, so they are taken
/// while all episodes of their place are known.
#[derive(Debug, Clone, Default)]
pub struct PolicyGaps(BTreeMap<(usize, usize, Figure), (Sample, [f64; 2])>);

impl PolicyGaps {
    /// Adds a figure of the pedestrians of a place whose first cell has the number `before`.
    pub fn add(&mut self, place: &Place, measured: &Measured, before: usize) {
        let key = |cell: usize| &place.runs(cell)[0].key;
        for home in 0..place.cells.len() {
            for away in 0..place.cells.len() {
                let same = pedestrian(key(home)) == pedestrian(key(away));
                if same && change(key(home), key(away)) == Some(Change::Policy) {
                    let gap = place.paired(measured, home, away);
                    self.0.extend(gap.map(|gap| ((before + home, before + away, measured.figure), gap)));
                }
            }
        }
    }
}

/// The change between the place of a training and another one; none if there is none, or several.
fn change(home: &CellKey, away: &CellKey) -> Option<Change> {
    match (home.town == away.town, home.policy == away.policy) {
        _ if !home.is_trained() => None,
        (false, true) if home.town == home.train_town => Some(Change::Town),
        (true, false) if home.policy == home.train_policy => Some(Change::Policy),
        _ => None,
    }
}

/// The transfer gaps between all cells of a campaign.
pub fn transfers(cells: &[CellEvidence], gaps: &PolicyGaps) -> Vec<Transfer> {
    let mut everywhere: BTreeMap<_, Vec<(usize, &CellEvidence)>> = BTreeMap::new();
    let trained = || cells.iter().enumerate().filter(|(_, cell)| cell.key.is_trained());
    for (number, cell) in trained() {
        everywhere.entry(pedestrian(&cell.key)).or_default().push((number, cell));
    }
    let mut all = Vec::new();
    for (at_home, home) in trained() {
        for (abroad, away) in &everywhere[&pedestrian(&home.key)] {
            let (here, there) = (&home.key, &away.key);
            let Some(change) = change(here, there) else { continue };
            for (slot, figure) in Figure::COMPARED.into_iter().enumerate() {
                let found = match change {
                    Change::Policy => gaps.0.get(&(at_home, *abroad, figure)).cloned(),
                    Change::Town => {
                        home.samples[slot].as_ref().zip(away.samples[slot].as_ref()).and_then(|(a, b)| gap(a, b))
                    }
                };
                all.extend(found.map(|(sample, values)| Transfer {
                    home: here.clone(),
                    away: there.clone(),
                    change,
                    figure,
                    runs: sample.values.len() as u64,
                    values,
                    gap: sample.estimate(),
                    interval: sample.interval().map(cut),
                    by_run: sample.values,
                }));
            }
        }
    }
    all
}

fn cut((low, high): (f64, f64)) -> (f64, f64) {
    (low.clamp(-1.0, 1.0), high.clamp(-1.0, 1.0))
}

/// The common part of the keys of two cells in which the same pedestrian was evaluated in the same way.
fn pedestrian(key: &CellKey) -> (u32, [&String; 6]) {
    let names = [&key.vehicle, &key.adversary, &key.controller, &key.reward, &key.train_town, &key.train_policy];
    (key.block, names)
}

/// The gaps of the trainings that were evaluated in both towns, and their means there. Each town has its own starts.
fn gap(home: &(Vec<u32>, Sample), away: &(Vec<u32>, Sample)) -> Option<(Sample, [f64; 2])> {
    let both = |run: &(usize, &u32)| Some((run.0, away.0.iter().position(|other| other == run.1)?));
    let pairs: Vec<(usize, usize)> = home.0.iter().enumerate().filter_map(|run| both(&run)).collect();
    let n = pairs.len() as f64;
    let at = |sample: &Sample, i: usize, j: usize| sample.covariance[i * sample.values.len() + j];
    let covariance = pairs
        .iter()
        .flat_map(|a| pairs.iter().map(move |b| (a, b)))
        .map(|((i, k), (j, l))| at(&home.1, *i, *j) + at(&away.1, *k, *l))
        .collect();
    let sample = Sample {
        values: pairs.iter().map(|(i, j)| home.1.values[*i] - away.1.values[*j]).collect(),
        covariance,
        first: pairs.len(),
        trained: [true; 2],
        episodes: least([home.1.episodes, away.1.episodes].into_iter()),
    };
    let means = [
        pairs.iter().map(|(i, _)| home.1.values[*i]).sum::<f64>() / n,
        pairs.iter().map(|(_, j)| away.1.values[*j]).sum::<f64>() / n,
    ];
    (!pairs.is_empty()).then_some((sample, means))
}
