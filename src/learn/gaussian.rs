//! A diagonal normal distribution with a standard deviation that does not depend on the state.

use super::arithmetic::Real;

/// Half the natural logarithm of 2π, with which the density is normalised.
const HALF_LOG_TAU: f64 = 0.918_938_533_204_672_8;

/// The standard deviations of a policy's actions, with values derived from them that are needed repeatedly.
#[derive(Debug, Clone)]
pub struct Spread {
    log_std: Vec<f64>,
    std: Vec<f64>,
    inverse_std: Vec<f64>,
}

impl Spread {
    /// Makes room for this number of components, all with the standard deviation 1.
    pub fn new(components: usize) -> Self {
        Self { log_std: vec![0.0; components], std: vec![1.0; components], inverse_std: vec![1.0; components] }
    }

    /// Sets the natural logarithms of the standard deviations.
    pub fn set<T: Real>(&mut self, log_std: &[T]) {
        for (i, log_std) in log_std.iter().enumerate() {
            self.log_std[i] = log_std.widened();
            self.std[i] = libm::exp(log_std.widened());
            self.inverse_std[i] = libm::exp(-log_std.widened());
        }
    }

    /// Returns the standard deviations, in the units of the action.
    pub fn std(&self) -> &[f64] {
        &self.std
    }
}

/// A normal distribution of independent components.
///
/// The density is that of the action as it was sampled, before it is clipped to the bounds of the environment.
///
/// # Source
/// `DiagGaussianDistribution` of stable-baselines3.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian<'a> {
    /// The mean of every component, in the units of the action.
    pub mean: &'a [f64],
    /// The standard deviations.
    pub spread: &'a Spread,
}

impl Gaussian<'_> {
    /// Returns the natural logarithm of the density at `action`.
    pub fn log_prob(&self, action: &[f64]) -> f64 {
        let spread = self.spread.log_std.iter().zip(&self.spread.inverse_std);
        let components = action.iter().zip(self.mean).zip(spread);
        components
            .map(|((action, mean), (log_std, inverse_std))| {
                let z = (action - mean) * inverse_std;
                -0.5 * z * z - log_std - HALF_LOG_TAU
            })
            .sum()
    }

    /// Returns the entropy in nats.
    pub fn entropy(&self) -> f64 {
        self.spread.log_std.iter().map(|log_std| 0.5 + HALF_LOG_TAU + log_std).sum()
    }

    /// Returns the derivatives of the log-density at `action[i]` with respect to the mean and to `log_std` of component
    /// `i`.
    pub fn log_prob_gradient(&self, action: &[f64], i: usize) -> (f64, f64) {
        let inverse_std = self.spread.inverse_std[i];
        let z = (action[i] - self.mean[i]) * inverse_std;
        (z * inverse_std, z * z - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(log_std: &[f64]) -> Spread {
        let mut spread = Spread::new(log_std.len());
        spread.set(log_std);
        spread
    }

    #[test]
    fn log_density_and_entropy_by_hand() {
        // σ = (1, 2), z = (1, −0.5): −½(1 + ¼) − ln 2 − ln 2π.
        let spread = spread(&[0.0, libm::log(2.0)]);
        let gaussian = Gaussian { mean: &[1.0, 3.0], spread: &spread };
        let expected = -0.625 - libm::log(2.0) - libm::log(std::f64::consts::TAU);
        assert!((gaussian.log_prob(&[2.0, 2.0]) - expected).abs() < 1e-14);
        // ½ ln(2πe) each, plus ln 2: 1.418 938 5 · 2 + 0.693 147 2.
        assert!((gaussian.entropy() - 3.531_024_2).abs() < 1e-6);
    }

    #[test]
    fn gradients_agree_with_differences() {
        let (mean, log_std, action) = ([0.3, -0.7], [0.4, -0.6], [1.1, -1.9]);
        let h = 1e-6;
        for i in 0..2 {
            let at = |delta_mean: f64, delta_log_std: f64| {
                let (mut mean, mut log_std) = (mean, log_std);
                mean[i] += delta_mean;
                log_std[i] += delta_log_std;
                Gaussian { mean: &mean, spread: &spread(&log_std) }.log_prob(&action)
            };
            let (by_mean, by_log_std) =
                Gaussian { mean: &mean, spread: &spread(&log_std) }.log_prob_gradient(&action, i);
            assert!((by_mean - (at(h, 0.0) - at(-h, 0.0)) / (2.0 * h)).abs() < 1e-8);
            assert!((by_log_std - (at(0.0, h) - at(0.0, -h)) / (2.0 * h)).abs() < 1e-8);
        }
    }
}
