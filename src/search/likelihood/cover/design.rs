use rand::RngExt;

use base::seed::Stream;

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
