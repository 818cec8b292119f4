use super::student::incomplete_beta;

/// Clopper and Pearson's exact interval for a rate: low and high end. A share of at most `alpha` of all such intervals misses the rate. Without
/// any trial it is the whole interval from 0 to 1.
///
/// # Source
/// Clopper and Pearson, *The use of confidence or fiducial limits illustrated in the case of the binomial*, Biometrika 26, 1934.
pub fn clopper_pearson(successes: u64, trials: u64, alpha: f64) -> (f64, f64) {
    let (k, n) = (successes as f64, trials as f64);
    let low = if successes == 0 { 0.0 } else { beta_quantile(k, n - k + 1.0, alpha / 2.0) };
    let high = if successes >= trials { 1.0 } else { beta_quantile(k + 1.0, n - k, 1.0 - alpha / 2.0) };
    (low, high)
}

/// The interval of the share of pairs that are positive on the second side only, less that of the first side only, among `pairs` pairs.
/// The number of pairs that disagree is taken as given, and Clopper and Pearson's interval is for the
/// share of them that disagrees upwards. So the low end is above 0 only where McNemar's exact p is at most `alpha`. Without a pair that
/// disagrees it holds the greatest share that may go unseen.
pub fn disagreement(only_first: u64, only_second: u64, pairs: u64, alpha: f64) -> (f64, f64) {
    let all = only_first + only_second;
    if all == 0 {
        let (_, most) = clopper_pearson(0, pairs, alpha);
        return (-most, most);
    }
    let (low, high) = clopper_pearson(only_second, all, alpha);
    let share = all as f64 / pairs.max(1) as f64;
    ((2.0 * low - 1.0) * share, (2.0 * high - 1.0) * share)
}

/// The value below which a share of the beta distribution lies.
fn beta_quantile(a: f64, b: f64, share: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Each halving gives one bit: as many as a double has.
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if incomplete_beta(a, b, middle) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::mcnemar;

    #[test]
    fn exact_intervals_have_closed_forms_at_the_ends() {
        for trials in [1_u64, 3, 10, 400] {
            let end = 1.0 - libm::pow(0.025, 1.0 / trials as f64);
            let ((low, high), (mirrored, one)) =
                (clopper_pearson(0, trials, 0.05), clopper_pearson(trials, trials, 0.05));
            assert!(low == 0.0 && (high - end).abs() < 1e-12, "{trials}: {high}");
            assert!(one == 1.0 && (mirrored - (1.0 - end)).abs() < 1e-12, "{trials}: {mirrored}");
        }
        assert_eq!(clopper_pearson(0, 0, 0.05), (0.0, 1.0));
        // scipy.stats.binomtest(15, 148).proportion_ci(method="exact"), also in Newcombe, Statistics in Medicine 17, 1998: 0.0578, 0.1617.
        let (low, high) = clopper_pearson(15, 148, 0.05);
        assert!((low - 0.0578).abs() < 5e-5 && (high - 0.1617).abs() < 5e-5, "{low}..{high}");
    }

    #[test]
    fn the_sides_of_0_are_those_of_mcnemars_test() {
        for alpha in [0.05, 0.001] {
            for all in 0..40 {
                for second in 0..=all {
                    let (low, high) = disagreement(all - second, second, 400, alpha);
                    let significant = mcnemar(all - second, second) <= alpha;
                    assert_eq!(low > 0.0 || high < 0.0, significant, "{second} of {all} at {alpha}: {low}..{high}");
                }
            }
        }
    }
}
