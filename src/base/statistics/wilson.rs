use super::{ClusteredCount, normal_quantile};

/// Wilson's score interval for a rate at 95 %: low and high end.
///
/// Without any trial it is the whole interval from 0 to 1. Trials in clusters count as their effective number.
///
/// # Source
/// Wilson, *Probable inference, the law of succession, and statistical inference*, JASA 22, 1927. With the effective number of trials: Franco,
/// Little, Louis and Slud, *Comparative study of confidence intervals for proportions in complex sample surveys*, Journal of Survey Statistics
/// and Methodology 7, 2019.
pub fn wilson(successes: impl Into<ClusteredCount>, trials: impl Into<ClusteredCount>) -> (f64, f64) {
    wilson_at(successes, trials, 0.05)
}

/// [`wilson`] where a share `alpha` of all intervals may miss the rate, instead of 0.05.
pub fn wilson_at(successes: impl Into<ClusteredCount>, trials: impl Into<ClusteredCount>, alpha: f64) -> (f64, f64) {
    let (successes, trials) = (successes.into(), trials.into());
    let Some(p) = successes.share_of(&trials) else { return (0.0, 1.0) };
    let z = normal_quantile(1.0 - alpha / 2.0);
    let n = effective_trials(&successes, &trials, p);
    let scale = 1.0 + z * z / n;
    let centre = (p + z * z / (2.0 * n)) / scale;
    let half = z / scale * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    // At the ends of the scale only rounding errors remain.
    let low = if successes.count() == 0 { 0.0 } else { (centre - half).max(0.0) };
    let high = if successes.count() == trials.count() { 1.0 } else { (centre + half).min(1.0) };
    (low, high)
}

/// The number of plain trials that estimate the rate equally well.
fn effective_trials(successes: &ClusteredCount, trials: &ClusteredCount, p: f64) -> f64 {
    if successes.is_plain() && trials.is_plain() {
        return trials.sum();
    }
    let failures = *trials - *successes;
    let variance =
        (successes.squares() * (1.0 - p) * (1.0 - p) + failures.squares() * p * p) / (trials.sum() * trials.sum());
    let both = successes.count() > 0 && failures.count() > 0;
    if both && variance > 0.0 { p * (1.0 - p) / variance } else { trials.effective_size() }
}
