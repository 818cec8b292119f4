//! The number types of the networks.

use super::arithmetic::{Arithmetic, Real};
use super::tanh;

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
