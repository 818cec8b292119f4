use super::student::incomplete_beta;
use super::{mcnemar, normal_quantile};

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
/// It holds 0 wherever McNemar's exact p is above `alpha`. Without a pair that disagrees it holds the maximum share that may go unseen.
///
/// # Source
/// The adjusted interval of Bonett and Price, *Adjusted Wald confidence interval for a difference of binomial proportions based on paired data*,
/// Journal of Educational and Behavioral Statistics 37, 2012.
pub fn disagreement(only_first: u64, only_second: u64, pairs: u64, alpha: f64) -> (f64, f64) {
    if only_first + only_second == 0 {
        let (_, most) = clopper_pearson(0, pairs, alpha);
        return (-most, most);
    }
    let n = pairs as f64 + 2.0;
    let share = |count: u64| (count as f64 + 1.0) / n;
    let (first, second) = (share(only_first), share(only_second));
    let difference = second - first;
    let half = normal_quantile(1.0 - alpha / 2.0) * ((first + second - difference * difference) / n).sqrt();
    let (low, high) = ((difference - half).max(-1.0), (difference + half).min(1.0));
    if mcnemar(only_first, only_second) > alpha { (low.min(0.0), high.max(0.0)) } else { (low, high) }
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
    use rand::Rng;

    use super::*;
    use crate::seed::Seed;

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
                    assert!(significant || low <= 0.0 && high >= 0.0, "{second} of {all} at {alpha}: {low}..{high}");
                }
            }
        }
        let (low, high) = disagreement(0, 12, 400, 0.05);
        assert!(low > 0.0 && high > 0.03, "a clear difference of 0.03: {low}..{high}");
    }

    #[test]
    fn the_interval_of_a_difference_of_pairs_holds_the_truth() {
        let mut stream = Seed::root(1).child("pairs").stream();
        for (pairs, first, second) in [(40, 0.0, 0.025), (40, 0.02, 0.1), (60, 0.05, 0.05), (200, 0.01, 0.03)] {
            let mut held = 0;
            for _ in 0..2_000 {
                let mut counts = [0, 0];
                for _ in 0..pairs {
                    let drawn = f64::from(stream.next_u32()) / 2_f64.powi(32);
                    counts[0] += u64::from(drawn < first);
                    counts[1] += u64::from((first..first + second).contains(&drawn));
                }
                let (low, high) = disagreement(counts[0], counts[1], pairs, 0.05);
                held += u32::from((low..=high).contains(&(second - first)));
            }
            assert!(held >= 1_880, "{held} of 2000 for {pairs} pairs with {first} and {second}");
        }
    }
}
