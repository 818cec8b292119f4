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
