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
    let (first, second) = (only_first as f64, only_second as f64);
    adjusted(second - first, first + second, mcnemar(only_first, only_second), pairs, alpha)
}

/// The same for the mean of differences between -1 and 1, each that of a start from which several pairs began: starts are independent, and the pairs of
/// a start are not. It holds 0 wherever `p` of their sum is above `alpha`.
pub fn mean_disagreement(differences: &[f64], p: f64, alpha: f64) -> (f64, f64) {
    let (sum, squares) = (differences.iter().sum(), differences.iter().map(|each| each * each).sum());
    adjusted(sum, squares, p, differences.len() as u64, alpha)
}

/// With one more start of either sign.
fn adjusted(sum: f64, squares: f64, p: f64, starts: u64, alpha: f64) -> (f64, f64) {
    if squares == 0.0 {
        let (_, most) = clopper_pearson(0, starts, alpha);
        return (-most, most);
    }
    let n = starts as f64 + 2.0;
    let mean = sum / n;
    let half = normal_quantile(1.0 - alpha / 2.0) * (((squares + 2.0) / n - mean * mean) / n).sqrt();
    let (low, high) = ((mean - half).max(-1.0), (mean + half).min(1.0));
    if p > alpha { (low.min(0.0), high.max(0.0)) } else { (low, high) }
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
