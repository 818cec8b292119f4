//! The first weights of a network.

use nalgebra::DMatrix;

use super::normal::standard_normal;
use base::seed::Stream;

/// The gain of hidden layers.
pub(super) const HIDDEN_GAIN: f64 = std::f64::consts::SQRT_2;

/// The gain of the layer that gives the action's mean: first actions are near zero whatever the observation.
pub(super) const ACTION_GAIN: f64 = 0.01;

/// The gain of the layer that gives the value.
pub(super) const VALUE_GAIN: f64 = 1.0;

/// Draws a matrix whose rows or columns, whichever are fewer, are orthogonal and of length `gain`.
///
/// # Source
/// `torch.nn.init.orthogonal_`: the Q of a QR decomposition of a standard normal matrix, with the signs of R's diagonal,
/// which makes it uniform over all such matrices.
pub(super) fn orthogonal(rows: usize, columns: usize, gain: f64, stream: &mut Stream) -> DMatrix<f64> {
    let (long, short) = (rows.max(columns), rows.min(columns));
    // nalgebra chooses the signs that make R's diagonal positive.
    let q = DMatrix::from_fn(long, short, |_, _| standard_normal(stream)).qr().q() * gain;
    if rows < columns { q.transpose() } else { q }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    #[test]
    fn rows_or_columns_are_orthogonal_and_as_long_as_the_gain() {
        let mut stream = Seed::root(5).stream();
        for (rows, columns) in [(64, 4), (64, 64), (2, 64), (1, 64), (3, 3), (1, 1)] {
            let matrix = orthogonal(rows, columns, 1.5, &mut stream);
            assert_eq!(matrix.shape(), (rows, columns));
            let vectors: Vec<Vec<f64>> = if rows < columns {
                matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
            } else {
                matrix.column_iter().map(|column| column.iter().copied().collect()).collect()
            };
            for (i, a) in vectors.iter().enumerate() {
                for (j, b) in vectors.iter().enumerate() {
                    let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    let expected = if i == j { 2.25 } else { 0.0 };
                    assert!((product - expected).abs() < 1e-12, "{rows}x{columns}: {i}, {j}");
                }
            }
        }
    }

    #[test]
    fn no_sign_is_preferred() {
        // Without the signs of R's diagonal the first component would be biased to one side.
        let mut stream = Seed::root(6).stream();
        let positive = (0..400).filter(|_| orthogonal(4, 4, 1.0, &mut stream)[(0, 0)] > 0.0).count();
        assert!((150..250).contains(&positive), "{positive} of 400 are positive");
    }
}
