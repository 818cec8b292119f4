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
fn wilson_at(successes: impl Into<ClusteredCount>, trials: impl Into<ClusteredCount>, alpha: f64) -> (f64, f64) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use crate::statistics::recorded;
    use rand::Rng;

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

    /// Wilson's formula for whole numbers, without weights.
    fn of_whole_numbers(successes: u64, trials: u64) -> (f64, f64) {
        let z = normal_quantile(1.0 - 0.05 / 2.0);
        let (n, p) = (trials as f64, successes as f64 / trials as f64);
        let scale = 1.0 + z * z / n;
        let centre = (p + z * z / (2.0 * n)) / scale;
        let half = z / scale * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        let low = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
        let high = if successes == trials { 1.0 } else { (centre + half).min(1.0) };
        (low, high)
    }

    #[test]
    fn plain_counts_have_the_bits_of_whole_numbers() {
        for trials in [1, 2, 3, 7, 20, 263, 1_000, 987_654_321] {
            for hits in [0, 1, trials / 3, trials] {
                let ((low, high), found) = (of_whole_numbers(hits, trials), wilson(hits, trials));
                assert_eq!((found.0.to_bits(), found.1.to_bits()), (low.to_bits(), high.to_bits()));
            }
        }
    }

    /// The number of 2,000 intervals over 10 runs of 200 starts that miss the rate of 0.1, where all runs have the outcome of the start with this probability:
    /// with a start that counts once, and with one that counts in each run.
    fn missed_by(agreement: f64) -> [u32; 2] {
        let (runs, starts, rate) = (10, 200, 0.1);
        let mut missed = [0; 2];
        for campaign in 0..2_000 {
            let mut stream = Seed::root(11).index(campaign).stream();
            let mut draw = |p: f64| f64::from(stream.next_u32()) < p * 2_f64.powi(32);
            let mut hits = 0_u64;
            for _ in 0..starts {
                let (shared, agrees) = (draw(rate), draw(agreement));
                hits += (0..runs).map(|_| u64::from(if agrees { shared } else { draw(rate) })).sum::<u64>();
            }
            let (part, whole) = (ClusteredCount::from(hits), ClusteredCount::from(runs * starts));
            let size = runs as f64;
            for (missed, (low, high)) in
                missed.iter_mut().zip([wilson(part.of_clusters(size), whole.of_clusters(size)), wilson(part, whole)])
            {
                *missed += u32::from(!(low..=high).contains(&rate));
            }
        }
        missed
    }

    #[test]
    fn runs_that_share_their_starts_are_no_further_starts() {
        // 100 may be missed.
        let [once, each] = missed_by(1.0);
        assert!((60..=140).contains(&once), "runs that agree are one run: {once}");
        assert!(each > 1_000, "as if they were ten: {each}");
        let [once, each] = missed_by(0.5);
        assert!(once < 60 && each > 400, "half agree: {once}, {each}");
        let [once, each] = missed_by(0.0);
        assert!(once < 5 && each < 140, "runs without anything in common make it too wide: {once}, {each}");
    }
}
