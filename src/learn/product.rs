//! Products and transposes of column-major matrices in slices.
//!
//! The loops keep a block of the result in registers while they run over the inner dimension. Every element is the sum of
//! its terms in their order, so the result does not depend on the shape of the blocks.
//! nalgebra's products are not used: they allocate in every call, choose their instructions themselves, and nalgebra 0.35
//! is unsound for small views with a row stride.

use super::arithmetic::{Arithmetic, Kernel, Real};

/// A matrix product `c = a · b`, or `c = a · bᵀ`; with `init`, every column of it plus `init`.
pub(super) struct Product<'a, T, const B_TRANSPOSED: bool> {
    /// rows × inner.
    pub(super) a: &'a [T],
    /// inner × columns, or columns × inner for the product with the transpose.
    pub(super) b: &'a [T],
    /// The start value of every column instead of zeros, one element per row.
    pub(super) init: Option<&'a [T]>,
    /// rows × columns.
    pub(super) c: &'a mut [T],
    /// The number of rows of `a` and `c`.
    pub(super) rows: usize,
    /// The number of columns of `a`.
    pub(super) inner: usize,
    /// The number of columns of `c`.
    pub(super) columns: usize,
}

/// The terms of a sum between which its value is in memory, where parts of `a` are copied: 32 KiB of `f32` are a part of 64 rows.
const DEPTH: usize = 128;

/// The number of columns from which copying `a` saves time.
const WORTH_A_COPY: usize = 16;

/// A copy of `R` rows of some columns of a matrix, in whole lines of the cache.
#[repr(align(64))]
struct Panel<T, const R: usize>([[T; R]; DEPTH]);

impl<T: Real, const B_TRANSPOSED: bool> Product<'_, T, B_TRANSPOSED> {
    /// Computes the rows `row..row + R` of four columns at a time, then of single ones.
    #[inline(always)]
    fn rows<A: Arithmetic, const R: usize>(&mut self, row: usize) {
        let (a, rows) = (&self.a[..self.rows * self.inner], self.rows);
        self.columns::<A, R, _>(row, 0, || a.chunks_exact(rows).map(move |a| block(&a[row..])));
    }

    /// Computes the rows `row..row + R` as [`Product::rows`] does, with copies of parts of `a`: a part lies in whole lines of the cache and
    /// stays in it for all columns.
    #[inline(always)]
    fn packed_rows<A: Arithmetic, const R: usize>(&mut self, row: usize, panel: &mut Panel<T, R>) {
        for from in (0..self.inner).step_by(DEPTH) {
            let panel = &mut panel.0[..DEPTH.min(self.inner - from)];
            for (slot, a) in panel.iter_mut().zip(self.a[from * self.rows..].chunks_exact(self.rows)) {
                *slot = *block(&a[row..]);
            }
            let panel = &*panel;
            self.columns::<A, R, _>(row, from, || panel.iter());
        }
    }

    /// Adds the terms from number `from` of the inner dimension on to all columns in rows `row..row + R`; `a` has these rows of its columns from
    /// there on.
    #[inline(always)]
    fn columns<'b, A: Arithmetic, const R: usize, I: Iterator<Item = &'b [T; R]>>(
        &mut self,
        row: usize,
        from: usize,
        a: impl Fn() -> I,
    ) {
        let mut at = 0;
        while at + 4 <= self.columns {
            self.four_columns::<A, R>(row, at, from, a());
            at += 4;
        }
        while at < self.columns {
            self.one_column::<A, R>(row, at, from, a());
            at += 1;
        }
    }

    /// Adds to the columns `at..at + 4`, unrolled so that the sums get registers.
    #[inline(always)]
    fn four_columns<'b, A: Arithmetic, const R: usize>(
        &mut self,
        row: usize,
        at: usize,
        from: usize,
        a: impl Iterator<Item = &'b [T; R]>,
    ) {
        let (mut s0, mut s1) = (self.first_sums(row, at, from), self.first_sums(row, at + 1, from));
        let (mut s2, mut s3) = (self.first_sums(row, at + 2, from), self.first_sums(row, at + 3, from));
        if B_TRANSPOSED {
            for (a, b) in a.zip(self.b[from * self.columns..].chunks_exact(self.columns)) {
                let [b0, b1, b2, b3] = *block(&b[at..]);
                add_multiple::<A, T, R>(&mut s0, a, b0);
                add_multiple::<A, T, R>(&mut s1, a, b1);
                add_multiple::<A, T, R>(&mut s2, a, b2);
                add_multiple::<A, T, R>(&mut s3, a, b3);
            }
        } else {
            let column = |j: usize| &self.b[(at + j) * self.inner..][from..self.inner];
            let columns = column(0).iter().zip(column(1)).zip(column(2)).zip(column(3));
            for (a, (((b0, b1), b2), b3)) in a.zip(columns) {
                add_multiple::<A, T, R>(&mut s0, a, *b0);
                add_multiple::<A, T, R>(&mut s1, a, *b1);
                add_multiple::<A, T, R>(&mut s2, a, *b2);
                add_multiple::<A, T, R>(&mut s3, a, *b3);
            }
        }
        self.store(row, at, &s0);
        self.store(row, at + 1, &s1);
        self.store(row, at + 2, &s2);
        self.store(row, at + 3, &s3);
    }

    /// Adds to the column `at`.
    #[inline(always)]
    fn one_column<'b, A: Arithmetic, const R: usize>(
        &mut self,
        row: usize,
        at: usize,
        from: usize,
        a: impl Iterator<Item = &'b [T; R]>,
    ) {
        let mut sums = self.first_sums(row, at, from);
        if B_TRANSPOSED {
            for (a, b) in a.zip(self.b[from * self.columns..].chunks_exact(self.columns)) {
                add_multiple::<A, T, R>(&mut sums, a, b[at]);
            }
        } else {
            for (a, b) in a.zip(&self.b[at * self.inner..][from..self.inner]) {
                add_multiple::<A, T, R>(&mut sums, a, *b);
            }
        }
        self.store(row, at, &sums);
    }

    /// The sums of a column before the terms from number `from` on.
    #[inline(always)]
    fn first_sums<const R: usize>(&self, row: usize, at: usize, from: usize) -> [T; R] {
        if from > 0 {
            *block(&self.c[at * self.rows + row..])
        } else if let Some(init) = self.init {
            *block(&init[row..])
        } else {
            [T::zero(); R]
        }
    }

    #[inline(always)]
    fn store<const R: usize>(&mut self, row: usize, at: usize, sums: &[T; R]) {
        self.c[at * self.rows + row..][..R].copy_from_slice(sums);
    }
}

/// Returns the start of a slice.
#[inline(always)]
fn block<T, const N: usize>(values: &[T]) -> &[T; N] {
    values.first_chunk().expect("a block lies inside of its matrix")
}

/// Adds `a · b` to sums in registers.
#[inline(always)]
fn add_multiple<A: Arithmetic, T: Real, const R: usize>(sums: &mut [T; R], a: &[T; R], b: T) {
    for (sum, a) in sums.iter_mut().zip(a) {
        *sum = A::mul_add(*a, b, *sum);
    }
}

impl<T: Real, const B_TRANSPOSED: bool> Kernel for Product<'_, T, B_TRANSPOSED> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(mut self) {
        let mut row = 0;
        // Eight registers or more hide the latency of an addition. Four columns of sixteen rows need the fewest loads of registers of
        // eight numbers, and four of sixty-four rows of the thirty-two that hold sixteen. But with debug assertions the compiler keeps
        // their sums in memory, which is twenty times slower. Narrow registers hold four columns of eight rows.
        while cfg!(debug_assertions) && row + 64 <= self.rows {
            let (a, rows) = (&self.a[..self.rows * self.inner], self.rows);
            for at in 0..self.columns {
                self.one_column::<A, 64>(row, at, 0, a.chunks_exact(rows).map(|a| block(&a[row..])));
            }
            row += 64;
        }
        if A::LANES >= 16 && row + 64 <= self.rows && self.columns >= WORTH_A_COPY {
            let mut panel = Panel([[T::zero(); 64]; DEPTH]);
            while row + 64 <= self.rows {
                self.packed_rows::<A, 64>(row, &mut panel);
                row += 64;
            }
        }
        while A::LANES >= 16 && row + 64 <= self.rows {
            self.rows::<A, 64>(row);
            row += 64;
        }
        while A::LANES >= 16 && row + 32 <= self.rows {
            self.rows::<A, 32>(row);
            row += 32;
        }
        while A::LANES >= 8 && row + 16 <= self.rows {
            self.rows::<A, 16>(row);
            row += 16;
        }
        while row + 8 <= self.rows {
            self.rows::<A, 8>(row);
            row += 8;
        }
        while row < self.rows {
            self.rows::<A, 1>(row);
            row += 1;
        }
    }
}

/// The product of `a`ᵀ and `b` for an `a` of few columns: inner products of whole columns.
pub(super) struct ProductOfTranspose<'a, T> {
    /// inner × rows.
    pub(super) a: &'a [T],
    /// inner × columns.
    pub(super) b: &'a [T],
    /// The start value of every column, one element per row.
    pub(super) init: &'a [T],
    /// rows × columns.
    pub(super) c: &'a mut [T],
    /// The number of columns of `a`.
    pub(super) rows: usize,
    /// The number of rows of `a` and `b`.
    pub(super) inner: usize,
}

impl<T: Real> Kernel for ProductOfTranspose<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(self) {
        for (c, b) in self.c.chunks_exact_mut(self.rows).zip(self.b.chunks_exact(self.inner)) {
            for ((c, a), init) in c.iter_mut().zip(self.a.chunks_exact(self.inner)).zip(self.init) {
                *c = *init + dot::<A, T>(a, b);
            }
        }
    }
}

/// The sum of the squares of a vector's elements.
pub(super) struct SquaredNorm<'a, T>(pub(super) &'a [T]);

impl<T: Real> Kernel for SquaredNorm<'_, T> {
    type Output = T;

    #[inline(always)]
    fn run<A: Arithmetic>(self) -> T {
        dot::<A, T>(self.0, self.0)
    }
}

/// Returns the inner product of two vectors of equal length, summed in 32 lanes.
#[inline(always)]
fn dot<A: Arithmetic, T: Real>(a: &[T], b: &[T]) -> T {
    const LANES: usize = 32;
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [T::zero(); LANES];
    for (a, b) in a.iter().zip(b) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane = A::mul_add(*a, *b, *lane);
        }
    }
    let mut width = LANES / 2;
    while width > 0 {
        let (low, high) = lanes.split_at_mut(width);
        for (low, high) in low.iter_mut().zip(high) {
            *low += *high;
        }
        width /= 2;
    }
    a_rest.iter().zip(b_rest).fold(lanes[0], |sum, (a, b)| A::mul_add(*a, *b, sum))
}

/// Multiplies a matrix (outputs × inputs) by one vector and adds another.
///
/// It always uses the plain arithmetic: acting gives the same bits on every processor.
pub(super) fn affine<T: Real>(weight: &[T], bias: &[T], x: &[T], y: &mut [T]) {
    let mut row = 0;
    while row + 32 <= y.len() {
        affine_rows::<T, 32>(weight, bias, x, y, row);
        row += 32;
    }
    while row + 8 <= y.len() {
        affine_rows::<T, 8>(weight, bias, x, y, row);
        row += 8;
    }
    while row + 2 <= y.len() {
        affine_rows::<T, 2>(weight, bias, x, y, row);
        row += 2;
    }
    if row < y.len() {
        affine_rows::<T, 1>(weight, bias, x, y, row);
    }
}

#[inline(always)]
fn affine_rows<T: Real, const R: usize>(weight: &[T], bias: &[T], x: &[T], y: &mut [T], row: usize) {
    let mut sums: [T; R] = *bias[row..].first_chunk().expect("one element per output");
    for (weight, x) in weight.chunks_exact(y.len()).zip(x) {
        let weight: &[T; R] = weight[row..].first_chunk().expect("one element per output");
        for (sum, weight) in sums.iter_mut().zip(weight) {
            *sum += *weight * *x;
        }
    }
    y[row..row + R].copy_from_slice(&sums);
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
    use crate::arithmetic::{Path, all_paths, assert_width_changes_nothing};
    use crate::normal::standard_normal;
    use base::seed::Seed;
    use nalgebra::DMatrix;

    const SIZES: [usize; 15] = [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 22, 41, 64, 65];

    fn for_all_shapes(mut check: impl FnMut(DMatrix<f64>, DMatrix<f64>, Vec<f64>)) {
        let mut stream = Seed::root(3).stream();
        for rows in SIZES {
            for inner in SIZES {
                for columns in SIZES {
                    let mut draw = |m, n| DMatrix::from_fn(m, n, |_, _| standard_normal(&mut stream));
                    check(draw(rows, inner), draw(inner, columns), draw(rows, 1).as_slice().to_vec());
                }
            }
        }
    }

    fn assert_close(found: &[f64], expected: &DMatrix<f64>) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected.iter()) {
            assert!((found - expected).abs() < 1e-12, "{found} against {expected}");
        }
    }

    #[test]
    fn products_of_all_shapes_agree_with_nalgebra() {
        for path in all_paths() {
            for_all_shapes(|a, b, init| {
                let ((rows, inner), columns) = (a.shape(), b.ncols());
                let product = &a * &b;
                let shifted = DMatrix::from_fn(rows, columns, |i, j| product[(i, j)] + init[i]);
                let (transposed_a, transposed_b) = (a.transpose(), b.transpose());
                for (init, expected) in [(None, &product), (Some(init.as_slice()), &shifted)] {
                    let (a, mut c) = (a.as_slice(), vec![f64::NAN; rows * columns]);
                    let b = b.as_slice();
                    path.run(Product::<_, false> { a, b, init, c: &mut c, rows, inner, columns });
                    assert_close(&c, expected);
                    let b = transposed_b.as_slice();
                    path.run(Product::<_, true> { a, b, init, c: &mut c, rows, inner, columns });
                    assert_close(&c, expected);
                }
                let mut c = vec![f64::NAN; rows * columns];
                let (a, b) = (transposed_a.as_slice(), b.as_slice());
                path.run(ProductOfTranspose { a, b, init: &init, c: &mut c, rows, inner });
                assert_close(&c, &shifted);
            });
        }
    }

    /// The product by copies of its rows alone, which programs with debug assertions do not use.
    struct Packed<'a, const B_TRANSPOSED: bool>(Product<'a, f32, B_TRANSPOSED>);

    impl<const B_TRANSPOSED: bool> Kernel for Packed<'_, B_TRANSPOSED> {
        type Output = ();

        #[inline(always)]
        fn run<A: Arithmetic>(mut self) {
            let mut panel = Panel([[0.0; 64]; DEPTH]);
            (0..self.0.rows).step_by(64).for_each(|row| self.0.packed_rows::<A, 64>(row, &mut panel));
        }
    }

    #[test]
    fn copies_of_rows_change_no_bit() {
        let mut stream = Seed::root(5).stream();
        for (rows, inner, columns) in [(64, 64, 20), (128, 300, 18), (64, 4, 17), (128, 128, 16), (64, 129, 21)] {
            let mut draw = |count: usize| (0..count).map(|_| standard_normal(&mut stream) as f32).collect::<Vec<f32>>();
            let (a, b, init) = (draw(rows * inner), draw(inner * columns), draw(rows));
            for (path, init) in all_paths().into_iter().flat_map(|path| [(path, None), (path, Some(init.as_slice()))]) {
                let (mut found, mut expected) = (vec![f32::NAN; rows * columns], vec![f32::NAN; rows * columns]);
                path.run(Packed(Product::<_, false> { a: &a, b: &b, init, c: &mut found, rows, inner, columns }));
                path.run(Product::<_, false> { a: &a, b: &b, init, c: &mut expected, rows, inner, columns });
                assert_eq!(found, expected, "{path:?}");
                path.run(Packed(Product::<_, true> { a: &a, b: &b, init, c: &mut found, rows, inner, columns }));
                path.run(Product::<_, true> { a: &a, b: &b, init, c: &mut expected, rows, inner, columns });
                assert_eq!(found, expected, "{path:?}");
            }
        }
    }

    #[test]
    fn wider_registers_change_no_bit() {
        let mut stream = Seed::root(4).stream();
        for (rows, inner, columns) in [(64, 64, 64), (128, 4, 37), (200, 130, 9), (135, 300, 22), (7, 65, 30)] {
            let mut draw = |count: usize| (0..count).map(|_| standard_normal(&mut stream) as f32).collect::<Vec<f32>>();
            let (a, b, init, at) = (draw(rows * inner), draw(inner * columns), draw(rows), draw(rows * inner));
            assert_width_changes_nothing(|path| {
                let mut c =
                    [vec![f32::NAN; rows * columns], vec![f32::NAN; rows * columns], vec![f32::NAN; rows * columns]];
                let [c0, c1, c2] = &mut c;
                path.run(Product::<_, false> { a: &a, b: &b, init: Some(&init), c: c0, rows, inner, columns });
                path.run(Product::<_, true> { a: &a, b: &b, init: None, c: c1, rows, inner, columns });
                path.run(ProductOfTranspose { a: &at, b: &b, init: &init, c: c2, rows, inner });
                (c, path.run(SquaredNorm(&b)))
            });
        }
    }

    #[test]
    fn the_product_with_one_vector_is_the_plain_product_bit_for_bit() {
        for_all_shapes(|a, b, init| {
            let (rows, inner) = a.shape();
            let x = &b.as_slice()[..inner];
            let (mut y, mut c) = (vec![f64::NAN; rows], vec![f64::NAN; rows]);
            affine(a.as_slice(), &init, x, &mut y);
            let (a, init) = (a.as_slice(), Some(init.as_slice()));
            Path::plain().run(Product::<_, false> { a, b: x, init, c: &mut c, rows, inner, columns: 1 });
            assert_eq!(y, c);
        });
    }

    #[test]
    fn a_squared_norm_counts_every_element_once() {
        for path in all_paths() {
            for count in 0..100 {
                let values: Vec<f64> = (0..count).map(f64::from).collect();
                let expected: f64 = values.iter().map(|x| x * x).sum();
                assert_eq!(path.run(SquaredNorm(&values)), expected);
            }
        }
    }

    #[test]
    fn a_transpose_exchanges_rows_and_columns() {
        for_all_shapes(|a, _, _| {
            let mut out = vec![f64::NAN; a.len()];
            transpose(a.as_slice(), &mut out, a.nrows(), a.ncols());
            assert_eq!(out, a.transpose().as_slice());
        });
    }
}
