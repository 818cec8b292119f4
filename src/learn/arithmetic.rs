//! The instructions that the learner computes with.
//!
//! A [`Kernel`] is written once, over an [`Arithmetic`], and compiled for the registers of several generations of processors.
//! [`Path::run`] enters one of them. The width of the registers changes no bit: a kernel adds the terms of an element in one
//! order. Whether a product is rounded before the sum does.

/// A floating-point type of the networks: `f32` for training, `f64` for checking gradients.
pub trait Real: nalgebra::RealField + Copy {
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

/// How a product is added to a sum, and how many of them at once.
pub trait Arithmetic {
    /// Whether the product is not rounded before the sum.
    const FUSED: bool;

    /// The numbers of 32 bits in a register.
    const LANES: usize;

    /// Returns `a · b + c`.
    fn mul_add<T: Real>(a: T, b: T, c: T) -> T;
}

/// Rounds the product, then the sum: the same bits on every processor.
#[derive(Debug)]
pub struct Plain<const LANES: usize = 4>;

impl<const LANES: usize> Arithmetic for Plain<LANES> {
    const FUSED: bool = false;
    const LANES: usize = LANES;

    #[inline(always)]
    fn mul_add<T: Real>(a: T, b: T, c: T) -> T {
        a * b + c
    }
}

/// Rounds once. Slow on processors without such an instruction.
#[cfg_attr(not(any(target_arch = "x86_64", test)), expect(dead_code, reason = "only kernels for x86-64 use it"))]
#[derive(Debug)]
pub struct Fused<const LANES: usize = 8>;

impl<const LANES: usize> Arithmetic for Fused<LANES> {
    const FUSED: bool = true;
    const LANES: usize = LANES;

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

/// The registers of a processor, as far as there is code for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Registers {
    /// Those that all processors of the target have.
    Base,
    /// 256 bits: AVX2 and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Bits256,
    /// 512 bits: AVX-512 F and VL beside the others.
    #[cfg(target_arch = "x86_64")]
    Bits512,
}

impl Registers {
    /// The widest of this processor.
    fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            let longer =
                std::arch::is_x86_feature_detected!("avx512f") && std::arch::is_x86_feature_detected!("avx512vl");
            return if longer { Self::Bits512 } else { Self::Bits256 };
        }
        Self::Base
    }
}

/// The instructions that kernels are run with.
///
/// A value with registers other than the base proves that the processor has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Path {
    registers: Registers,
    /// Whether products are not rounded, where the registers allow it.
    fused: bool,
}

impl Path {
    /// Rounded products: the same bits on all processors.
    pub fn plain() -> Self {
        Self { registers: Registers::widest(), fused: false }
    }

    /// The fastest instructions of this processor for which there is code.
    pub fn widest() -> Self {
        let registers = Registers::widest();
        Self { registers, fused: registers > Registers::Base }
    }

    /// The fastest instructions, or those that give the same bits on all processors.
    pub fn of(portable_bits: bool) -> Self {
        if portable_bits { Self::plain() } else { Self::widest() }
    }

    /// Runs a kernel.
    #[inline]
    #[cfg_attr(
        target_arch = "x86_64",
        expect(unsafe_code, reason = "calls into code for instructions that not every processor has")
    )]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match (self.registers, self.fused) {
            (Registers::Base, _) => kernel.run::<Plain>(),
            // SAFETY: a path with such registers is made by `Registers::widest` alone, after it has found AVX-512 F and VL, AVX2 and FMA.
            #[cfg(target_arch = "x86_64")]
            (Registers::Bits512, true) => unsafe { run_fused_512(kernel) },
            // SAFETY: as before, for AVX2 and FMA.
            #[cfg(target_arch = "x86_64")]
            (Registers::Bits256, true) => unsafe { run_fused_256(kernel) },
            // SAFETY: as before; registers of 512 bits come with those of 256.
            #[cfg(target_arch = "x86_64")]
            (_, false) => unsafe { run_plain_256(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx2,fma")]
fn run_fused_512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Fused<16>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_fused_256<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Fused<8>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_plain_256<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Plain<8>>()
}

/// Returns the paths to test: all that this processor has.
#[cfg(test)]
pub(super) fn all_paths() -> Vec<Path> {
    #[cfg(target_arch = "x86_64")]
    let narrower = [Registers::Base, Registers::Bits256];
    #[cfg(not(target_arch = "x86_64"))]
    let narrower = [Registers::Base];
    let widest = Registers::widest();
    let all = narrower.into_iter().filter(|registers| *registers < widest).chain([widest]);
    all.flat_map(|registers| [false, true].map(|fused| Path { registers, fused: fused && registers > Registers::Base }))
        .collect()
}

/// Checks that the paths which round alike give the same bits.
#[cfg(test)]
pub(super) fn assert_width_changes_nothing<T: PartialEq + std::fmt::Debug>(result: impl Fn(Path) -> T) {
    let paths = all_paths();
    for path in &paths {
        let first = paths.iter().find(|first| first.fused == path.fused).expect("at least itself");
        assert_eq!(result(*path), result(*first), "{path:?} and {first:?}");
    }
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
    fn plain_paths_round_the_product_and_fused_ones_do_not() {
        // (1 + 2⁻¹²)² − 1 = 2⁻¹¹ + 2⁻²⁴, whose last term a rounded product loses.
        let x = 1.0 + 2f32.powi(-12);
        let fused = Fused::<8>::mul_add(x, x, -1.0);
        assert_eq!(fused, 2f32.powi(-11) + 2f32.powi(-24));
        assert_eq!(Path::plain().run(Square(x)), 2f32.powi(-11));
        for path in all_paths() {
            assert_eq!(path.run(Square(x)), if path.fused { fused } else { 2f32.powi(-11) });
        }
    }
}
