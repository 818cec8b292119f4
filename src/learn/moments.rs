//! Running mean and variance.

/// The weight of the initial estimate, mean 0 and variance 1, in samples.
const FIRST_GUESS: f64 = 1e-4;

/// The ε that is added to a variance before it divides.
const EPSILON: f64 = 1e-8;

/// The bound of a normalised number.
pub(super) const LIMIT: f64 = 10.0;

/// The running mean and variance of every component of a vector.
///
/// # Source
/// `RunningMeanStd` and `VecNormalize` of stable-baselines3.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningMoments {
    /// The mean of every component, in its unit.
    pub mean: Vec<f64>,
    /// The variance of every component, in the square of its unit.
    pub variance: Vec<f64>,
    /// The number of samples, plus a ten-thousandth for the initial estimate.
    pub count: f64,
}

impl RunningMoments {
    /// Starts with mean 0 and variance 1, which the first samples outweigh.
    pub fn new(components: usize) -> Self {
        Self { mean: vec![0.0; components], variance: vec![1.0; components], count: FIRST_GUESS }
    }

    /// Adds several samples at once.
    pub fn update<'a>(&mut self, samples: impl Iterator<Item = &'a [f64]> + Clone) {
        let added = samples.clone().count() as f64;
        let total = self.count + added;
        for (i, (mean, variance)) in self.mean.iter_mut().zip(&mut self.variance).enumerate() {
            let values = samples.clone().map(|sample| sample[i]);
            let added_mean = values.clone().sum::<f64>() / added;
            let added_variance = values.map(|x| (x - added_mean) * (x - added_mean)).sum::<f64>() / added;
            let delta = added_mean - *mean;
            let squares = *variance * self.count + added_variance * added + delta * delta * self.count * added / total;
            *mean += delta * added / total;
            *variance = squares / total;
        }
        self.count = total;
    }

    /// Returns component `i` of a sample minus its mean, divided by its deviation, within ±10.
    pub fn normalised(&self, i: usize, value: f64) -> f64 {
        ((value - self.mean[i]) / (self.variance[i] + EPSILON).sqrt()).clamp(-LIMIT, LIMIT)
    }

    /// Returns the divisors of the components.
    pub(super) fn deviations(&self) -> impl Iterator<Item = f64> {
        self.variance.iter().map(|variance| (variance + EPSILON).sqrt())
    }

    /// Returns component `i` of a sample divided by the deviation, within ±10.
    pub fn scaled(&self, i: usize, value: f64) -> f64 {
        (value / (self.variance[i] + EPSILON).sqrt()).clamp(-LIMIT, LIMIT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_of_any_size_give_the_moments_of_all_samples() {
        let samples: Vec<[f64; 2]> = (0..60).map(|i| [libm::sin(f64::from(i)), 5.0 + f64::from(i)]).collect();
        for size in [1, 7, 60] {
            let mut moments = RunningMoments::new(2);
            for batch in samples.chunks(size) {
                moments.update(batch.iter().map(|sample| &sample[..]));
            }
            for i in 0..2 {
                let mean = samples.iter().map(|x| x[i]).sum::<f64>() / 60.0;
                let variance = samples.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / 60.0;
                // The initial estimate weighs a ten-thousandth of a sample.
                assert!((moments.mean[i] - mean).abs() < 1e-4);
                assert!((moments.variance[i] / variance - 1.0).abs() < 1e-4);
            }
            assert!((moments.count - 60.0001).abs() < 1e-9);
        }
    }

    #[test]
    fn normalising_shifts_scales_and_clips() {
        let moments = RunningMoments { mean: vec![2.0], variance: vec![4.0], count: 10.0 };
        assert!((moments.normalised(0, 5.0) - 1.5).abs() < 1e-8);
        assert!((moments.scaled(0, 5.0) - 2.5).abs() < 1e-8);
        assert_eq!((moments.normalised(0, -90.0), moments.scaled(0, 90.0)), (-10.0, 10.0));
        // At zero variance the epsilon keeps the quotient finite.
        let still = RunningMoments { variance: vec![0.0], ..moments };
        assert_eq!(still.normalised(0, 2.0), 0.0);
        assert!((still.normalised(0, 2.0 + 1e-4) - 1.0).abs() < 1e-6);
    }
}
