//! The number types of the networks.

use super::arithmetic::Arithmetic;
use super::tanh;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point type of the networks: `f32` for training, `f64` for checking gradients.
pub trait Real: nalgebra::RealField + Copy + sealed::Sealed {
    fn rounded(value: f64) -> Self;

    /// Widens to `f64`, without loss.
    fn widened(self) -> f64;

    /// Returns the correctly rounded square root, by the processor's own instruction.
    fn square_root(self) -> Self;

    /// Returns `self · b + c`, rounded once.
    fn fused(self, b: Self, c: Self) -> Self;

    /// Replaces every element by its hyperbolic tangent.
    fn tanh_slice<A: Arithmetic>(values: &mut [Self]);
}

impl Real for f32 {
    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn widened(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn fused(self, b: Self, c: Self) -> Self {
        Self::mul_add(self, b, c)
    }

    #[inline(always)]
    fn tanh_slice<A: Arithmetic>(values: &mut [Self]) {
        tanh::tanh_f32::<A>(values);
    }
}

impl Real for f64 {
    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn widened(self) -> f64 {
        self
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn fused(self, b: Self, c: Self) -> Self {
        Self::mul_add(self, b, c)
    }

    #[inline(always)]
    fn tanh_slice<A: Arithmetic>(values: &mut [Self]) {
        for value in values {
            *value = libm::tanh(*value);
        }
    }
}
