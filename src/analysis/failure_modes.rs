use std::collections::BTreeMap;

use super::clusters::clusters;
use crate::campaign::EpisodeRow;
use crate::env::Ending;

/// Where the car was hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Impact {
    /// Within the front sector.
    Front,
    /// Beside it, to the car's left.
    Left,
    /// Beside it, to the car's right.
    Right,
    /// Within 60° of straight behind.
    Rear,
}

impl Impact {
    /// Where a pedestrian hit the car, who was within the front sector or not, at this bearing from the car's middle (rad).
    pub fn new(front: bool, bearing: f64) -> Self {
        match bearing {
            _ if front => Self::Front,
            b if b.abs() >= 120_f64.to_radians() => Self::Rear,
            b if b > 0.0 => Self::Left,
            _ => Self::Right,
        }
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Left => "left",
            Self::Right => "right",
            Self::Rear => "rear",
        }
    }
}

/// A kind of collision of the trained pedestrians of one reward and training, in one town against one policy.
#[derive(Debug, Clone, PartialEq)]
pub struct FailureMode {
    /// Any of its rows tells which reward, training, town and policy.
    pub example: EpisodeRow,
    /// Where the car was hit.
    pub impact: Impact,
    /// Whether the car moved.
    pub moving: bool,
    /// Number of the cluster within impact and motion, from 0.
    pub cluster: usize,
    /// How many collisions.
    pub failures: usize,
    /// Share of all collisions of the cell.
    pub share: f64,
    /// Mean distance of the pedestrian at the beginning (m).
    pub distance: f64,
    /// Mean bearing of the pedestrian from the car at the beginning (rad), positive to the left.
    pub bearing: f64,
    /// Mean length of the episodes (s).
    pub length: f64,
    /// Mean speed of the car at the impact (m/s).
    pub impact_speed: f64,
    /// How well two halves of the failures agree on the clusters, 0 to 1.
    pub stability: f64,
}

/// A collision as the analysis sees it.
struct Failure<'a> {
    row: &'a EpisodeRow,
    features: Vec<f64>,
}

/// The collisions of a cell, by impact and whether the car moved.
type Classes<'a> = BTreeMap<(Impact, bool), Vec<Failure<'a>>>;

/// Finds the failure modes of trained pedestrians, cell by cell in the order of the rows, the commonest first.
pub fn failure_modes(rows: &[EpisodeRow]) -> Vec<FailureMode> {
    let mut cells: Vec<(&EpisodeRow, Classes<'_>)> = Vec::new();
    for row in rows.iter().filter(|row| row.pedestrian == "trained") {
        let Ending::Collision { front, moving, impact_speed, bearing } = row.outcome.ending else { continue };
        let same = |other: &EpisodeRow| {
            let (a, b) = (&row.trained, &other.trained);
            let place = |row: &EpisodeRow| {
                (row.town.clone(), row.policy.clone(), row.vehicle.clone(), row.adversary.clone(), row.block)
            };
            (&a.reward, &a.town, &a.policy) == (&b.reward, &b.town, &b.policy) && place(row) == place(other)
        };
        let index = cells.iter().position(|(first, _)| same(first)).unwrap_or_else(|| {
            cells.push((row, BTreeMap::new()));
            cells.len() - 1
        });
        let spawn = &row.outcome.spawn;
        let start = spawn.ego.to_local(spawn.pedestrian.position());
        let distance = start.norm();
        // A bearing as a point on the unit circle: ±180° are neighbours.
        let features = vec![distance, start.x / distance, start.y / distance, row.outcome.duration, impact_speed];
        cells[index].1.entry((Impact::new(front, bearing), moving)).or_default().push(Failure { row, features });
    }
    cells.into_iter().flat_map(|(_, classes)| modes(classes)).collect()
}

fn modes(classes: Classes<'_>) -> Vec<FailureMode> {
    let all: usize = classes.values().map(Vec::len).sum();
    let mut modes = Vec::new();
    for ((impact, moving), failures) in classes {
        let features: Vec<Vec<f64>> = failures.iter().map(|failure| failure.features.clone()).collect();
        let groups: Vec<u32> = failures.iter().map(|failure| failure.row.episode).collect();
        let found = clusters(&features, &groups);
        for cluster in 0..=found.labels.iter().copied().max().unwrap_or(0) {
            let members: Vec<&Failure<'_>> = failures
                .iter()
                .zip(&found.labels)
                .filter(|(_, label)| **label == cluster)
                .map(|(failure, _)| failure)
                .collect();
            let means: Vec<f64> = (0..5)
                .map(|axis| members.iter().map(|member| member.features[axis]).sum::<f64>() / members.len() as f64)
                .collect();
            let far = |failure: &Failure<'_>| {
                // Metres, tenths of a radian, seconds and metres a second are of one order here.
                let scale = [1.0, 10.0, 10.0, 1.0, 1.0];
                (0..5).map(|axis| ((failure.features[axis] - means[axis]) * scale[axis]).powi(2)).sum::<f64>()
            };
            let Some(example) = members.iter().min_by(|a, b| far(a).total_cmp(&far(b))) else { continue };
            modes.push(FailureMode {
                example: example.row.clone(),
                impact,
                moving,
                cluster,
                failures: members.len(),
                share: members.len() as f64 / all as f64,
                distance: means[0],
                bearing: libm::atan2(means[2], means[1]),
                length: means[3],
                impact_speed: means[4],
                stability: found.stability,
            });
        }
    }
    modes.sort_by_key(|mode| std::cmp::Reverse(mode.failures));
    modes
}
