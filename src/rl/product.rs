//! Products and transposes of column-major matrices in slices.
//!
//! nalgebra's general product serves only operands that are contiguous, column-major and larger than [`SMALL`] in every
//! dimension: below that nalgebra 0.35 takes another path, which is slow for matrices of few rows and unsound for views
//! with a row stride. Plain loops serve the rest. The general product packs its operands into memory that it allocates in
//! every call; nothing else here allocates.

use nalgebra::{DMatrixView, DMatrixViewMut};

use super::real::Real;

/// The largest dimension that the general product does not accept.
pub(super) const SMALL: usize = 5;

/// Writes the product of `a` (rows × inner) and `b` (inner × columns) into `c` (rows × columns).
pub(super) fn product<T: Real>(a: &[T], b: &[T], c: &mut [T], rows: usize, inner: usize, columns: usize) {
    if rows > SMALL && inner > SMALL && columns > SMALL {
        let a = DMatrixView::from_slice(a, rows, inner);
        let b = DMatrixView::from_slice(b, inner, columns);
        DMatrixViewMut::from_slice(c, rows, columns).gemm(T::one(), &a, &b, T::zero());
        return;
    }
    for (c, b) in c.chunks_exact_mut(rows).zip(b.chunks_exact(inner)) {
        c.fill(T::zero());
        let (quads, rest) = b.as_chunks::<4>();
        let (a_quads, a_rest) = a[..rows * inner].split_at(rows * 4 * quads.len());
        for (a, &[b0, b1, b2, b3]) in a_quads.chunks_exact(4 * rows).zip(quads) {
            let (a0, a) = a.split_at(rows);
            let (a1, a) = a.split_at(rows);
            let (a2, a3) = a.split_at(rows);
            for ((((c, a0), a1), a2), a3) in c.iter_mut().zip(a0).zip(a1).zip(a2).zip(a3) {
                *c += *a0 * b0 + *a1 * b1 + *a2 * b2 + *a3 * b3;
            }
        }
        for (a, b) in a_rest.chunks_exact(rows).zip(rest) {
            for (c, a) in c.iter_mut().zip(a) {
                *c += *a * *b;
            }
        }
    }
}

/// Writes the product of `a`ᵀ and `b` into `c` (rows × columns), for `a` (inner × rows) of few columns.
pub(super) fn product_of_transpose<T: Real>(a: &[T], b: &[T], c: &mut [T], rows: usize, inner: usize) {
    for (c, b) in c.chunks_exact_mut(rows).zip(b.chunks_exact(inner)) {
        for (c, a) in c.iter_mut().zip(a.chunks_exact(inner)) {
            *c = dot(a, b);
        }
    }
}

/// Returns the inner product of two vectors of equal length, summed in eight lanes.
pub(super) fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut lanes = [T::zero(); 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    let rest = a_rest.iter().zip(b_rest).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
    lanes.into_iter().fold(rest, |sum, lane| sum + lane)
}

/// Writes the transpose of `a` (rows × columns) into `out` (columns × rows).
pub(super) fn transpose<T: Real>(a: &[T], out: &mut [T], rows: usize, columns: usize) {
    const TILE: usize = 8;
    for column in (0..columns).step_by(TILE) {
        let column_end = (column + TILE).min(columns);
        for row in (0..rows).step_by(TILE) {
            let row_end = (row + TILE).min(rows);
            for i in row..row_end {
                let out = &mut out[i * columns + column..i * columns + column_end];
                for (out, j) in out.iter_mut().zip(column..column_end) {
                    *out = a[j * rows + i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rl::normal::standard_normal;
    use crate::seed::Seed;

    fn naive(a: &[f64], b: &[f64], rows: usize, inner: usize, columns: usize) -> Vec<f64> {
        let mut c = vec![0.0; rows * columns];
        for i in 0..rows {
            for j in 0..columns {
                c[j * rows + i] = (0..inner).map(|k| a[k * rows + i] * b[j * inner + k]).sum();
            }
        }
        c
    }

    #[test]
    fn all_shapes_agree_with_naive_loops() {
        let mut stream = Seed::root(3).stream();
        let mut draw = |n: usize| -> Vec<f64> { (0..n).map(|_| standard_normal(&mut stream)).collect() };
        let sizes = [1, 2, 3, 4, 5, 6, 7, 22, 64];
        for rows in sizes {
            for inner in sizes {
                for columns in sizes {
                    let (a, b) = (draw(rows * inner), draw(inner * columns));
                    let expected = naive(&a, &b, rows, inner, columns);
                    // One element more than needed shows a write out of bounds.
                    let mut c = vec![f64::NAN; rows * columns + 1];
                    c[rows * columns] = 42.0;
                    product(&a, &b, &mut c[..rows * columns], rows, inner, columns);
                    let mut a_transposed = vec![0.0; a.len()];
                    transpose(&a, &mut a_transposed, rows, inner);
                    let mut d = vec![f64::NAN; rows * columns];
                    product_of_transpose(&a_transposed, &b, &mut d, rows, inner);
                    assert_eq!(c[rows * columns], 42.0);
                    for ((c, d), expected) in c.iter().zip(&d).zip(&expected) {
                        assert!((c - expected).abs() < 1e-12, "{rows}x{inner}x{columns}");
                        assert!((d - expected).abs() < 1e-12, "{rows}x{inner}x{columns}, transposed");
                    }
                }
            }
        }
    }

    #[test]
    fn a_transpose_exchanges_rows_and_columns() {
        let mut out = [0.0; 6];
        transpose(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut out, 2, 3);
        assert_eq!(out, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    }
}
