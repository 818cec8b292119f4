use super::{Weighted, normal_quantile};

/// Wilson's score interval for a rate at 95 %: low and high end.
///
/// Without any trial it is the whole interval from 0 to 1. See [`wilson_at`] for trials with weights.
///
/// # Source
/// Wilson, *Probable inference, the law of succession, and statistical inference*, JASA 22, 1927.
pub fn wilson(successes: impl Into<Weighted>, trials: impl Into<Weighted>) -> (f64, f64) {
    wilson_at(successes, trials, 0.05)
}

/// [`wilson`] where a share `alpha` of all intervals may miss the rate, instead of 0.05.
///
/// Trials with weights estimate the rate p by Σ w x / Σ w. The interval is that of the number of plain trials with the same
/// variance: p (1 − p) / v, with v = Σ w² (x − p)² / (Σ w)². If v is 0, since all trials succeed or none does, that number is
/// Kish's effective size. With equal weights both are the number of trials.
///
/// # Source
/// Korn and Graubard, *Confidence intervals for proportions with small expected number of positive counts estimated from survey
/// data*, Survey Methodology 24, 1998, for the effective number of trials; with Wilson's interval in Franco, Little, Louis and
/// Slud, *Comparative study of confidence intervals for proportions in complex sample surveys*, Journal of Survey Statistics and
/// Methodology 7, 2019. v is the linearised variance of a ratio, as of self-normalised importance sampling (Owen, *Monte Carlo
/// theory, methods and examples*, 2013, section 9.2).
fn wilson_at(successes: impl Into<Weighted>, trials: impl Into<Weighted>, alpha: f64) -> (f64, f64) {
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
fn effective_trials(successes: &Weighted, trials: &Weighted, p: f64) -> f64 {
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

    /// Successes and trials with these weights.
    fn weighted(trials: impl IntoIterator<Item = (bool, f64)>) -> (Weighted, Weighted) {
        let (mut hits, mut all) = (Weighted::default(), Weighted::default());
        for (hit, weight) in trials {
            all.include(weight);
            if hit {
                hits.include(weight);
            }
        }
        (hits, all)
    }

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
    fn weights_of_1_change_no_bit() {
        for trials in [1, 2, 3, 7, 20, 263, 1_000] {
            for hits in 0..=trials {
                let (part, whole) = weighted((0..trials).map(|trial| (trial < hits, 1.0)));
                let (low, high) = of_whole_numbers(hits, trials);
                for found in [wilson(part, whole), wilson(hits, trials)] {
                    assert_eq!((found.0.to_bits(), found.1.to_bits()), (low.to_bits(), high.to_bits()));
                }
            }
        }
        // Larger than the squares that 53 bits hold.
        let (hits, trials) = (123_456_789, 987_654_321);
        assert_eq!(wilson(hits, trials), of_whole_numbers(hits, trials));
    }

    #[test]
    fn equal_weights_say_what_plain_trials_say() {
        let (part, whole) = weighted((0..148).map(|trial| (trial < 15, 0.3)));
        let (found, plain) = (wilson(part, whole), wilson(15, 148));
        assert!((found.0 - plain.0).abs() < 1e-12 && (found.1 - plain.1).abs() < 1e-12, "{found:?} {plain:?}");
    }

    #[test]
    fn the_effective_number_of_trials_has_a_closed_form_for_two_weights() {
        // 20 successes of weight 1/2 and 30 failures of weight 2: p = 10/70, v = (5 (60/70)² + 120 (10/70)²) / 70².
        let (part, whole) = weighted((0..50).map(|trial| (trial < 20, if trial < 20 { 0.5 } else { 2.0 })));
        let p: f64 = 1.0 / 7.0;
        let n = p * (1.0 - p) * 4_900.0 / (5.0 * 36.0 / 49.0 + 120.0 / 49.0);
        assert!((effective_trials(&part, &whole, p) - n).abs() < 1e-9, "{n}");
        // Without any success there is only Kish's size: 50 trials of weights 1 and 3 are 100² / 250 = 40.
        let (none, all) = weighted((0..50).map(|trial| (false, if trial < 25 { 1.0 } else { 3.0 })));
        assert_eq!((effective_trials(&none, &all, 0.0), wilson(none, all)), (40.0, wilson(0, 40)));
    }

    #[test]
    fn intervals_of_weighted_trials_hold_the_rate_of_the_target() {
        // Drawn with a rate of 0.6 where the target's is 0.1: weights 0.1 / 0.6 and 0.9 / 0.4.
        let (campaigns, target, drawn) = (2_000, 0.1, 0.6);
        let mut missed = 0;
        for campaign in 0..campaigns {
            let mut stream = Seed::root(7).index(campaign).stream();
            let trial = |_| match f64::from(stream.next_u32()) < drawn * 2_f64.powi(32) {
                true => (true, target / drawn),
                false => (false, (1.0 - target) / (1.0 - drawn)),
            };
            let (part, whole) = weighted((0..300).map(trial));
            let (low, high) = wilson(part, whole);
            missed += u32::from(!(low..=high).contains(&target));
        }
        // 100 are expected, with a standard deviation of 9.7.
        assert!((71..=129).contains(&missed), "{missed} of {campaigns}");
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
            let (part, whole) = (Weighted::from(hits), Weighted::from(runs * starts));
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
