//! A hyperbolic tangent that the compiler can vectorise.

use super::arithmetic::{Arithmetic, Kernel, Real};

/// The argument beyond which the approximation equals ±1 in `f32`.
const LIMIT: f32 = 7.905_311;

/// The coefficients of x, x³, … x¹³ in the numerator.
const NUMERATOR: [f32; 7] =
    [4.893_524_6e-3, 6.372_619_3e-4, 1.485_722_36e-5, 5.122_297_1e-8, -8.604_672e-11, 2.000_188e-13, -2.760_768_4e-16];

/// The coefficients of 1, x², x⁴ and x⁶ in the denominator.
const DENOMINATOR: [f32; 4] = [4.893_525e-3, 2.268_434_7e-3, 1.185_347_1e-4, 1.198_258_4e-6];

/// Replaces every element by its hyperbolic tangent, with an absolute error below 10⁻⁶; NaN stays NaN.
///
/// # Source
/// The rational approximation of degree 13/6 in Eigen's `generic_fast_tanh_float` and in XLA.
#[inline(always)]
pub fn tanh_f32<A: Arithmetic>(values: &mut [f32]) {
    for value in values {
        let x = value.clamp(-LIMIT, LIMIT);
        let square = x * x;
        let numerator = NUMERATOR.iter().rev().fold(0.0, |sum, c| A::mul_add(sum, square, *c));
        let denominator = DENOMINATOR.iter().rev().fold(0.0, |sum, c| A::mul_add(sum, square, *c));
        *value = x * numerator / denominator;
    }
}

/// Replaces every element by its hyperbolic tangent.
pub struct Tanh<'a, T>(pub &'a mut [T]);

impl<T: Real> Kernel for Tanh<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(self) {
        T::tanh_slice::<A>(self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::all_paths;

    #[test]
    fn the_error_stays_below_a_millionth() {
        let grid: Vec<f32> = (-400_000..=400_000).map(|i| i as f32 * 5e-5).collect();
        for path in all_paths() {
            let mut values = grid.clone();
            path.run(Tanh(&mut values));
            for (x, y) in grid.iter().zip(&values) {
                let error = (f64::from(*y) - libm::tanh(f64::from(*x))).abs();
                assert!(error < 1e-6, "tanh({x}) is off by {error}");
            }
        }
    }

    #[test]
    fn extreme_arguments_saturate_and_nan_survives() {
        for path in all_paths() {
            let mut values = [f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 0.0, f32::NAN];
            path.run(Tanh(&mut values));
            for (value, expected) in values.iter().zip([1.0, -1.0, 1.0, 0.0]) {
                assert!((value - expected).abs() < 1e-6);
            }
            assert!(values[4].is_nan());
        }
    }
}
