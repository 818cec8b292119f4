use std::collections::BTreeMap;

use super::place::least;
use super::{CellEvidence, Figure};
use crate::record::CellKey;
use crate::seed::Seed;
use crate::statistics::{Sample, mean_interval};

/// The change from the place of the training.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The town.
    Town,
    /// The driver.
    Policy,
}

impl Change {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Town => "town",
            Self::Policy => "policy",
        }
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
    /// The figure.
    pub figure: Figure,
    /// Trainings that were evaluated in both places.
    pub runs: u64,
    /// The figure at home and away, mean over these.
    pub values: [f64; 2],
    /// Home less away: above 0 the part that does not transfer.
    pub gap: f64,
    /// 95 % interval by hierarchical bootstrap: trainings as pairs, episodes separately.
    pub bootstrap: (f64, f64),
    /// Student's 95 % interval over the gaps of the trainings.
    pub student: Option<(f64, f64)>,
}

/// The transfer gaps between all cells of a campaign.
pub fn transfers(cells: &[CellEvidence], seed: &Seed) -> Vec<Transfer> {
    let mut everywhere: BTreeMap<_, Vec<&CellEvidence>> = BTreeMap::new();
    for cell in cells.iter().filter(|cell| cell.key.is_trained()) {
        everywhere.entry(pedestrian(&cell.key)).or_default().push(cell);
    }
    let mut all = Vec::new();
    for home in cells.iter().filter(|cell| cell.key.is_trained()) {
        for away in &everywhere[&pedestrian(&home.key)] {
            let (here, there) = (&home.key, &away.key);
            let change = match (here.town == there.town, here.policy == there.policy) {
                (false, true) if here.town == here.train_town => Change::Town,
                (true, false) if here.policy == here.train_policy => Change::Policy,
                _ => continue,
            };
            let seed = there.place_seed(&here.controller_seed(&here.place_seed(seed)));
            for (slot, figure) in Figure::COMPARED.into_iter().enumerate() {
                let (Some(first), Some(second)) = (&home.samples[slot], &away.samples[slot]) else { continue };
                all.extend(gap(first, second).map(|(sample, values)| Transfer {
                    home: here.clone(),
                    away: there.clone(),
                    change,
                    figure,
                    runs: sample.values.len() as u64,
                    values,
                    gap: sample.estimate(),
                    bootstrap: cut(sample.bootstrap(&seed.child(figure.name()))),
                    student: mean_interval(&sample.values).1.map(cut),
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

/// The gaps of the trainings that were evaluated in both places, and their means there. Each place has its own starts.
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
