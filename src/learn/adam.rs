//! The Adam optimiser.

use super::arithmetic::{Arithmetic, Kernel, Path, Real};

/// The decay of the first moment.
const BETA1: f64 = 0.9;

/// The decay of the second moment.
const BETA2: f64 = 0.999;

/// The state of Adam for one flat vector of parameters.
///
/// # Source
/// Kingma and Ba (2015) in the form of `torch.optim.Adam`: ε is added after the correction of the second moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam<T> {
    /// The ε in the denominator.
    pub eps: f64,
    /// The decaying means of the gradients.
    pub first: Vec<T>,
    /// The decaying means of the gradients' squares.
    pub second: Vec<T>,
    /// β₁ and β₂ to the power of the number of steps taken.
    pub powers: [f64; 2],
}

impl<T: Real> Adam<T> {
    /// Starts with zero moments for `count` parameters.
    pub fn new(count: usize, eps: f64) -> Self {
        let zeros = vec![T::zero(); count];
        Self { eps, first: zeros.clone(), second: zeros, powers: [1.0; 2] }
    }

    /// Moves the parameters one step against `scale` times the gradient.
    pub fn step(&mut self, parameters: &mut [T], gradient: &[T], learning_rate: f64, scale: f64, path: Path) {
        self.powers[0] *= BETA1;
        self.powers[1] *= BETA2;
        path.run(AdamStep {
            parameters,
            gradient,
            first: &mut self.first,
            second: &mut self.second,
            scale: T::rounded(scale),
            step_size: T::rounded(learning_rate / (1.0 - self.powers[0])),
            correction: T::rounded(1.0 / (1.0 - self.powers[1]).sqrt()),
            eps: T::rounded(self.eps),
        });
    }
}

struct AdamStep<'a, T> {
    parameters: &'a mut [T],
    gradient: &'a [T],
    first: &'a mut [T],
    second: &'a mut [T],
    scale: T,
    /// The learning rate with the correction of the first moment.
    step_size: T,
    /// The correction of the second moment's root.
    correction: T,
    eps: T,
}

impl<T: Real> Kernel for AdamStep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic>(self) {
        let Self { scale, step_size, correction, eps, .. } = self;
        let (keep1, add1) = (T::rounded(BETA1), T::rounded(1.0 - BETA1));
        let (keep2, add2) = (T::rounded(BETA2), T::rounded(1.0 - BETA2));
        let moments = self.first.iter_mut().zip(self.second);
        for ((parameter, gradient), (first, second)) in self.parameters.iter_mut().zip(self.gradient).zip(moments) {
            let gradient = *gradient * scale;
            *first = A::mul_add(keep1, *first, add1 * gradient);
            *second = A::mul_add(keep2, *second, add2 * gradient * gradient);
            *parameter -= step_size * *first / A::mul_add(second.square_root(), correction, eps);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::all_paths;

    #[test]
    fn first_steps_by_hand() {
        for path in all_paths() {
            let mut adam = Adam::new(1, 0.5);
            let mut parameter = [1.0f64];
            // m̂ = 2, v̂ = 4: 1 − 0.1 · 2 / (2 + 0.5).
            adam.step(&mut parameter, &[4.0], 0.1, 0.5, path);
            assert!((parameter[0] - 0.92).abs() < 1e-12);
            // m = 0.9 · 0.2 − 0.1 = 0.08, m̂ = 0.08 / 0.19; v = 0.999 · 0.004 + 0.001 = 0.004996, v̂ = 0.004996 / 0.001999.
            adam.step(&mut parameter, &[-1.0], 0.1, 1.0, path);
            let expected = 0.92 - 0.1 * (0.08 / 0.19) / ((0.004_996f64 / 0.001_999).sqrt() + 0.5);
            assert!((parameter[0] - expected).abs() < 1e-12);
        }
    }
}
