use serde::{Deserialize, Serialize};

use super::design::{latin_hypercube, uniform};
use base::seed::{Seed, Stream};

/// Chosen points of a batch are farther from each other than this part of the distance to the nearest known point.
const APART: f64 = 0.7;

/// Why a point was tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampled {
    /// To fill the box, before anything was known.
    Design,
    /// Near the boundary of pass and fail.
    Learning,
    /// To check a picture.
    Look,
}

impl Sampled {
    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Design => "design",
            Self::Learning => "learning",
            Self::Look => "look",
        }
    }
}

/// An experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its place in the unit box.
    pub at: Vec<f64>,
    pub failed: bool,
    /// Why it was tried.
    pub sampled: Sampled,
}

/// Where in the unit box experiments fail, as far as some of them tell: the local linear regression of failed (1) and passed (0) over the
/// nearest points.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    dimensions: usize,
    /// Coordinates, point by point.
    places: Vec<f64>,
    failed: Vec<bool>,
}

/// The places over which a chart averages the coordinates that it does not show.
const SPREAD: usize = 32;
/// Neighbours of a place for each dimension.
const NEIGHBOURS: usize = 4;
/// Added to the square of a relative distance before it divides a weight: the nearest point weighs at most ten times the farthest.
const FLAT: f64 = 0.1;
/// The ridge of the slopes, as a share of the sum of the weights.
const RIDGE: f64 = 0.02;

/// What a picture says of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Opinion {
    /// The share that fails there.
    pub share: f64,
    /// The distance to the nearest point that it knows.
    pub nearest: f64,
}

impl Picture {
    pub(super) fn of(dimensions: usize, points: &[Point]) -> Self {
        let mut picture = Self { dimensions, places: Vec::new(), failed: Vec::new() };
        points.iter().for_each(|point| picture.learn(point));
        picture
    }

    pub(super) fn learn(&mut self, point: &Point) {
        self.places.extend_from_slice(&point.at);
        self.failed.push(point.failed);
    }

    /// The number of points that it knows.
    pub(super) fn len(&self) -> usize {
        self.failed.len()
    }

    pub(super) fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The share of experiments that fail at a place of the unit box, from 0 to 1. Without any point it is 0.
    pub fn share(&self, at: &[f64]) -> f64 {
        self.opinion(at).share
    }

    /// Whether the picture shows a place as failing: half of the experiments there, or more.
    pub fn fails(&self, at: &[f64]) -> bool {
        self.share(at) >= 0.5
    }

    /// The shares that fail in the cells of a chart of two coordinates, row by row from low values of the second one, or of one coordinate in a single
    /// row. Other coordinates are averaged over their ranges.
    pub fn chart(&self, axes: (usize, Option<usize>), side: usize) -> Vec<f64> {
        let (first, second) = axes;
        let others = self.dimensions - 1 - usize::from(second.is_some());
        let spread = if others == 0 { 1 } else { SPREAD };
        let places = latin_hypercube(spread, self.dimensions, &mut Seed::root(0).child("chart").stream());
        let middle = |cell: usize| (cell as f64 + 0.5) / side as f64;
        let rows = if second.is_some() { side } else { 1 };
        let cells = (0..rows).flat_map(|row| (0..side).map(move |column| (row, column)));
        let share = |(row, column): (usize, usize)| {
            let shares = places.iter().map(|place| {
                let mut at = place.clone();
                at[first] = middle(column);
                if let Some(second) = second {
                    at[second] = middle(row);
                }
                self.share(&at)
            });
            shares.sum::<f64>() / spread as f64
        };
        cells.map(share).collect()
    }

    pub(super) fn opinion(&self, at: &[f64]) -> Opinion {
        let near = self.nearest(at);
        let nearest = near.first().map_or(f64::INFINITY, |(square, _)| square.sqrt());
        let failures = near.iter().filter(|(_, point)| self.failed[*point]).count();
        let share = match failures {
            0 => 0.0,
            all if all == near.len() => 1.0,
            _ => self.regression(at, &near),
        };
        Opinion { share, nearest }
    }

    /// The nearest points, with the squares of their distances; of equals the earlier one first.
    fn nearest(&self, at: &[f64]) -> Vec<(f64, usize)> {
        let most = NEIGHBOURS * self.dimensions;
        let mut near: Vec<(f64, usize)> = Vec::with_capacity(most + 1);
        for (point, place) in self.places.chunks_exact(self.dimensions).enumerate() {
            let square = square_distance(place, at);
            if near.len() < most || near.last().is_some_and(|(farthest, _)| square < *farthest) {
                let rank = near.partition_point(|(other, _)| *other <= square);
                near.insert(rank, (square, point));
                near.truncate(most);
            }
        }
        near
    }

    /// The value at a place of the plane that fits some points best, by weighted least squares with a ridge.
    fn regression(&self, at: &[f64], near: &[(f64, usize)]) -> f64 {
        let farthest = near.last().map_or(0.0, |(square, _)| *square).max(f64::MIN_POSITIVE);
        let (reach, unknown) = (farthest.sqrt(), self.dimensions + 1);
        // The normal equations, a row for each unknown and the right side as the last column: the value at the place, then the slopes.
        let width = unknown + 1;
        let mut rows = vec![0.0; unknown * width];
        let mut terms = vec![1.0; width];
        for &(square, point) in near {
            let weight = 1.0 / (square / farthest + FLAT);
            let place = &self.places[point * self.dimensions..][..self.dimensions];
            for (term, (there, here)) in terms[1..].iter_mut().zip(place.iter().zip(at)) {
                *term = (there - here) / reach;
            }
            terms[unknown] = f64::from(u8::from(self.failed[point]));
            for (row, factor) in rows.chunks_exact_mut(width).zip(&terms[..unknown]) {
                row.iter_mut().zip(&terms).for_each(|(sum, term)| *sum += weight * factor * term);
            }
        }
        let ridge = RIDGE * rows[0];
        (1..unknown).for_each(|slope| rows[slope * width + slope] += ridge);
        // The matrix is symmetric and positive definite, so elimination needs no pivots. It begins with the slopes and ends with the value.
        for pivot in (1..unknown).rev() {
            for row in 0..pivot {
                let factor = rows[row * width + pivot] / rows[pivot * width + pivot];
                for column in 0..width {
                    rows[row * width + column] -= factor * rows[pivot * width + column];
                }
            }
        }
        (rows[unknown] / rows[0]).clamp(0.0, 1.0)
    }
}

/// Chooses points where a picture is least sure, of uniform candidates: the score is the variance of the outcome times the distance to the
/// nearest known point, so that places of pure chance are not tried again and again. No point has a score of 0.
pub(super) fn uncertain(picture: &Picture, candidates: u64, most: u64, stream: &mut Stream) -> Vec<Vec<f64>> {
    let mut scored = Vec::new();
    for _ in 0..candidates {
        let at = uniform(picture.dimensions(), stream);
        let opinion = picture.opinion(&at);
        let score = opinion.share * (1.0 - opinion.share) * opinion.nearest;
        if score > 0.0 {
            scored.push((score, opinion.nearest, at));
        }
    }
    scored.sort_by(|(one, ..), (other, ..)| other.total_cmp(one));
    let mut chosen: Vec<Vec<f64>> = Vec::new();
    for (_, nearest, at) in scored {
        if chosen.len() as u64 == most {
            break;
        }
        let room = APART * nearest;
        if chosen.iter().all(|other| square_distance(other, &at) > room * room) {
            chosen.push(at);
        }
    }
    chosen
}

fn square_distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum()
}
