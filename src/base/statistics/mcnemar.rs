/// The exact test of McNemar: the probability that pairs which disagree are split at least as unevenly as `only_first` to
/// `only_second`, if both sides are equally likely. 1 when no pair disagrees.
///
/// # Source
/// McNemar, *Note on the sampling error of the difference between correlated proportions*, Psychometrika 12, 1947; exact,
/// two-sided: twice the smaller tail of the binomial distribution.
pub fn mcnemar(only_first: u64, only_second: u64) -> f64 {
    let (few, all) = (only_first.min(only_second), only_first + only_second);
    if 2 * few == all {
        return 1.0;
    }
    let (n, k) = (all as f64, few as f64);
    let chosen = libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
    // The largest term first; each other is the one above it times a ratio below 1.
    let mut term = libm::exp(chosen - n * std::f64::consts::LN_2);
    let mut tail = 0.0;
    for k in (0..=few).rev() {
        tail += term;
        if term <= tail * 1e-17 {
            break;
        }
        term *= k as f64 / (all - k + 1) as f64;
    }
    (2.0 * tail).min(1.0)
}
