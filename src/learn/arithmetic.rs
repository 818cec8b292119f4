//! The instructions that the learner computes with.
//!
//! A [`Kernel`] is written once, over an [`Arithmetic`], and compiled twice: for every processor of the target, and for
//! those with AVX2 and fused multiply-add. [`Path::run`] enters one of the two.

use super::config::PpoConfig;
use super::real::Real;

/// How a product is added to a sum.
pub trait Arithmetic {
    /// Whether the product is not rounded before the sum.
    const FUSED: bool;

    /// Returns `a · b + c`.
    fn mul_add<T: Real>(a: T, b: T, c: T) -> T;
}

/// Rounds the product, then the sum: the same bits on every processor.
#[derive(Debug)]
pub struct Plain;

impl Arithmetic for Plain {
    const FUSED: bool = false;

    #[inline(always)]
    fn mul_add<T: Real>(a: T, b: T, c: T) -> T {
        a * b + c
    }
}

/// Rounds once. Slow on processors without such an instruction.
#[cfg_attr(not(any(target_arch = "x86_64", test)), expect(dead_code, reason = "only kernels for x86-64 use it"))]
#[derive(Debug)]
pub struct Fused;

impl Arithmetic for Fused {
    const FUSED: bool = true;

    #[inline(always)]
    fn mul_add<T: Real>(a: T, b: T, c: T) -> T {
        a.fused(b, c)
    }
}

/// A loop that is worth wide instructions.
///
/// Implementations are marked `#[inline(always)]`, as are all functions that they call: only code that is inlined into
/// [`Path::run`] is compiled for the wide instructions.
pub trait Kernel {
    /// The result of the loop.
    type Output;

    /// Runs the loop.
    fn run<A: Arithmetic>(self) -> Self::Output;
}

/// The instructions that kernels are run with.
///
/// A value other than [`Path::plain`] proves that the processor has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Path {
    wide: bool,
}

impl Path {
    /// The instructions that all processors of the target have: the same bits everywhere.
    pub fn plain() -> Self {
        Self { wide: false }
    }

    /// The widest instructions of this processor for which there is code.
    pub fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        let wide = std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
        #[cfg(not(target_arch = "x86_64"))]
        let wide = false;
        Self { wide }
    }

    /// The instructions that the settings ask for.
    pub fn of(config: &PpoConfig) -> Self {
        if config.portable_bits { Self::plain() } else { Self::widest() }
    }

    /// Runs a kernel.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        if self.wide {
            #[expect(unsafe_code, reason = "calls into code for instructions that not every processor has")]
            // SAFETY: `wide` is set by `Path::widest` alone, after it has found AVX2 and FMA on this processor.
            return unsafe { run_wide(kernel) };
        }
        kernel.run::<Plain>()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_wide<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Fused>()
}

/// Returns the paths to test: the plain one, and the wide one where the processor has it.
#[cfg(test)]
pub(super) fn all_paths() -> Vec<Path> {
    let mut paths = vec![Path::plain(), Path::widest()];
    paths.dedup();
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Square(f32);

    impl Kernel for Square {
        type Output = f32;

        #[inline(always)]
        fn run<A: Arithmetic>(self) -> f32 {
            A::mul_add(self.0, self.0, -1.0)
        }
    }

    #[test]
    fn the_plain_path_rounds_the_product_and_the_wide_one_does_not() {
        // (1 + 2⁻¹²)² − 1 = 2⁻¹¹ + 2⁻²⁴, whose last term a rounded product loses.
        let x = 1.0 + 2f32.powi(-12);
        assert_eq!(Path::plain().run(Square(x)), 2f32.powi(-11));
        let fused = Fused::mul_add(x, x, -1.0);
        assert_eq!(fused, 2f32.powi(-11) + 2f32.powi(-24));
        if Path::widest() != Path::plain() {
            assert_eq!(Path::widest().run(Square(x)), fused);
        }
    }
}
