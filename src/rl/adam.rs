//! The Adam optimiser.

use super::real::Real;

/// The decay of the first moment.
const BETA1: f64 = 0.9;

/// The decay of the second moment.
const BETA2: f64 = 0.999;

/// The state of Adam for one flat vector of parameters.
///
/// # Source
/// Kingma and Ba (2015) in the form of `torch.optim.Adam`: ε is added after the correction of the second moment.
#[derive(Debug, Clone)]
pub struct Adam<T> {
    learning_rate: f64,
    eps: f64,
    first: Vec<T>,
    second: Vec<T>,
    beta1_power: f64,
    beta2_power: f64,
}

impl<T: Real> Adam<T> {
    /// Begins with zero moments for `count` parameters.
    pub fn new(count: usize, learning_rate: f64, eps: f64) -> Self {
        let zeros = vec![T::zero(); count];
        Self { learning_rate, eps, first: zeros.clone(), second: zeros, beta1_power: 1.0, beta2_power: 1.0 }
    }

    /// Moves the parameters one step against `scale` times the gradient.
    pub fn step(&mut self, parameters: &mut [T], gradient: &[T], scale: f64) {
        self.beta1_power *= BETA1;
        self.beta2_power *= BETA2;
        let scale = T::rounded(scale);
        let (keep1, add1) = (T::rounded(BETA1), T::rounded(1.0 - BETA1));
        let (keep2, add2) = (T::rounded(BETA2), T::rounded(1.0 - BETA2));
        let step_size = T::rounded(self.learning_rate / (1.0 - self.beta1_power));
        let correction = T::rounded(1.0 / (1.0 - self.beta2_power).sqrt());
        let eps = T::rounded(self.eps);
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((parameter, gradient), (first, second)) in parameters.iter_mut().zip(gradient).zip(moments) {
            let gradient = *gradient * scale;
            *first = keep1 * *first + add1 * gradient;
            *second = keep2 * *second + add2 * gradient * gradient;
            *parameter -= step_size * *first / (second.square_root() * correction + eps);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_steps_by_hand() {
        let mut adam = Adam::new(1, 0.1, 0.5);
        let mut parameter = [1.0f64];
        // m̂ = 2, v̂ = 4: 1 − 0.1 · 2 / (2 + 0.5).
        adam.step(&mut parameter, &[4.0], 0.5);
        assert!((parameter[0] - 0.92).abs() < 1e-12);
        // m = 0.9 · 0.2 − 0.1 = 0.08, m̂ = 0.08 / 0.19; v = 0.999 · 0.004 + 0.001 = 0.004996, v̂ = 0.004996 / 0.001999.
        adam.step(&mut parameter, &[-1.0], 1.0);
        let expected = 0.92 - 0.1 * (0.08 / 0.19) / ((0.004_996f64 / 0.001_999).sqrt() + 0.5);
        assert!((parameter[0] - expected).abs() < 1e-12);
    }
}
