/// The mean; none without values.
///
/// # Source
/// Kahan, *Further remarks on reducing truncation errors*, Communications of the ACM 8, 1965: a compensated sum, so that the order of a million
/// episodes does not show in the printed digits.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut error, mut count) = (0.0, 0.0, 0u64);
    for value in values {
        let corrected = value - error;
        let next = sum + corrected;
        error = (next - sum) - corrected;
        sum = next;
        count += 1;
    }
    (count > 0).then(|| sum / count as f64)
}

/// The standard deviation of a sample, with `n − 1` in the denominator; none for fewer than two values.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_known_samples() {
        assert_eq!(mean([]), None);
        assert_eq!(mean([2.0, 4.0, 9.0]), Some(5.0));
        assert_eq!(sample_deviation([3.0]), None);
        assert_eq!(sample_deviation([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]), Some(f64::sqrt(32.0 / 7.0)));
        // Added one by one, ten million tenths are 999999.9998; the compensated sum is exact to the last digit.
        assert_eq!(mean(std::iter::repeat_n(0.1, 10_000_000)), Some(0.1));
    }
}
