use super::normal_quantile;

/// Wilson's score interval for a rate at 95 %: low and high end.
///
/// Without any trial it is the whole of 0 to 1.
///
/// # Source
/// Wilson, *Probable inference, the law of succession, and statistical inference*, JASA 22, 1927.
pub fn wilson(successes: u64, trials: u64) -> (f64, f64) {
    wilson_at(successes, trials, 0.05)
}

/// [`wilson`] where a share `alpha` of all intervals may miss the rate, instead of 0.05.
pub fn wilson_at(successes: u64, trials: u64, alpha: f64) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let z = normal_quantile(1.0 - alpha / 2.0);
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let scale = 1.0 + z * z / n;
    let centre = (p + z * z / (2.0 * n)) / scale;
    let half = z / scale * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    // At the ends of the scale nothing but rounding is left.
    let low = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
    let high = if successes == trials { 1.0 } else { (centre + half).min(1.0) };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::recorded;

    #[test]
    fn ends_agree_with_published_values() {
        // Newcombe, Statistics in Medicine 17, 1998, table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
        for ((r, n), (low, high)) in [
            ((81, 263), (0.2553, 0.3662)),
            ((15, 148), (0.0624, 0.1605)),
            ((0, 20), (0.0, 0.1611)),
            ((1, 29), (0.0061, 0.1718)),
        ] {
            let found = wilson(r, n);
            assert!((found.0 - low).abs() < 5e-5 && (found.1 - high).abs() < 5e-5, "{r} of {n}: {found:?}");
        }
        assert_eq!(wilson(0, 0), (0.0, 1.0));
    }

    #[test]
    fn ends_at_other_levels_are_those_of_statsmodels() {
        for case in recorded("wilson") {
            let [hits, trials, alpha, low, high] = case[..] else { panic!("{case:?}") };
            let found = wilson_at(hits as u64, trials as u64, alpha);
            assert!((found.0 - low).abs() < 1e-12 && (found.1 - high).abs() < 1e-12, "{case:?}: {found:?}");
        }
    }
}
