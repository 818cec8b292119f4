/// The mean; `None` without values.
///
/// # Source
/// Kahan, *Further remarks on reducing truncation errors*, Communications of the ACM 8, 1965: a compensated sum, so that the order of a million
/// episodes does not show in the printed digits.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut mean = RunningMean::default();
    values.into_iter().for_each(|value| mean.include(value));
    mean.value()
}

/// The mean of values that come one by one, with Kahan's compensation. Equal values in equal order give equal bits.
#[derive(Debug, Clone, Copy, Default)]
pub struct RunningMean {
    sum: f64,
    error: f64,
    count: u64,
}

impl RunningMean {
    /// Adds a value.
    pub fn include(&mut self, value: f64) {
        let corrected = value - self.error;
        let next = self.sum + corrected;
        self.error = (next - self.sum) - corrected;
        self.sum = next;
        self.count += 1;
    }

    /// The mean; `None` without any value.
    pub fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// The standard deviation of a sample, with `n − 1` in the denominator; `None` for fewer than two values.
///
/// # Source
/// Welford, *Note on a method for calculating corrected sums of squares and products*, Technometrics 4, 1962.
pub fn sample_deviation(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut squares, mut mean, mut count) = (0.0, 0.0, 0u64);
    for value in values {
        count += 1;
        let before = value - mean;
        mean += before / count as f64;
        squares += before * (value - mean);
    }
    (count > 1).then(|| f64::sqrt(squares / (count - 1) as f64))
}
