/// The value below which a share of sorted numbers lies, with linear interpolation; none without numbers.
///
/// # Source
/// Hyndman and Fan, *Sample quantiles in statistical packages*, The American Statistician 50, 1996, definition 7, as in numpy
/// and pandas.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * (sorted.len().checked_sub(1)?) as f64;
    let below = place.floor();
    let (low, high) = (sorted[below as usize], sorted[place.ceil() as usize]);
    Some(low + (high - low) * (place - below))
}

/// The mean of the middle half of numbers. A quarter is cut off at either end, rounded down to whole numbers: the mean of all
/// three, or of the middle three of five. None without numbers.
///
/// # Source
/// Agarwal et al., *Deep reinforcement learning at the edge of the statistical precipice*, NeurIPS 2021; rounded as its
/// library rliable rounds (`scipy.stats.trim_mean`).
pub fn interquartile_mean(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    let middle = &sorted[cut..sorted.len() - cut];
    (!middle.is_empty()).then(|| middle.iter().sum::<f64>() / middle.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::recorded;

    #[test]
    fn quantiles_are_numpys() {
        for case in recorded("quantile") {
            let [share, wanted, ref values @ ..] = case[..] else { panic!("{case:?}") };
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            let found = quantile(&sorted, share).unwrap();
            assert!((found - wanted).abs() < 1e-12, "{case:?}: {found}");
        }
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn interquartile_means_are_those_of_scipy() {
        for case in recorded("interquartile_mean") {
            let found = interquartile_mean(&case[1..]).unwrap();
            assert!((found - case[0]).abs() < 1e-12, "{case:?}: {found}");
        }
        assert_eq!(interquartile_mean(&[]), None);
    }
}
