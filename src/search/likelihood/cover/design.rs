use rand::RngExt;

use super::picture::{Picture, square_distance};
use base::seed::Stream;

/// Chosen points of a batch are farther from each other than this part of the distance to the nearest known point.
const APART: f64 = 0.7;

/// Draws a point of the unit box.
pub(in super::super) fn uniform(dimensions: usize, stream: &mut Stream) -> Vec<f64> {
    (0..dimensions).map(|_| stream.random()).collect()
}

/// Draws points of the unit box so that each of `count` equal slices of each coordinate has one.
pub(crate) fn latin_hypercube(count: usize, dimensions: usize, stream: &mut Stream) -> Vec<Vec<f64>> {
    let mut points = vec![vec![0.0; dimensions]; count];
    for dimension in 0..dimensions {
        let mut slices: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            slices.swap(last, stream.random_range(0..=last));
        }
        for (point, slice) in points.iter_mut().zip(slices) {
            point[dimension] = (slice as f64 + stream.random::<f64>()) / count as f64;
        }
    }
    points
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
