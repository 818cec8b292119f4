//! Intervals of proportions and of differences of pairs, and the test of pairs.

use base::seed::Seed;
use base::statistics::{
    ClusteredCount, clopper_pearson, disagreement, mcnemar, normal_quantile, sign_flip, wilson, wilson_at,
};
use rand::Rng;

use crate::recorded::recorded;

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

#[test]
fn exact_intervals_have_closed_forms_at_the_ends() {
    for trials in [1_u64, 3, 10, 400] {
        let end = 1.0 - libm::pow(0.025, 1.0 / trials as f64);
        let ((low, high), (mirrored, one)) = (clopper_pearson(0, trials, 0.05), clopper_pearson(trials, trials, 0.05));
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

#[test]
fn probabilities_are_those_of_statsmodels() {
    for case in recorded("mcnemar") {
        let [first, second, wanted] = case[..] else { panic!("{case:?}") };
        let found = mcnemar(first as u64, second as u64);
        assert!((found - wanted).abs() <= 1e-9 * wanted, "{case:?}: {found}");
        assert_eq!(found, mcnemar(second as u64, first as u64));
    }
}

#[test]
fn the_randomisation_test_counts_all_signs() {
    assert_eq!((sign_flip(&[]), sign_flip(&[0, 0]), sign_flip(&[2, -2])), (1.0, 1.0, 1.0));
    assert_eq!((sign_flip(&[1, 2, 3]), sign_flip(&[1; 6])), (0.25, mcnemar(0, 6)));
    let same = [[1; 9].as_slice(), &[-1; 2], &[0; 50]].concat();
    assert_eq!(sign_flip(&same), mcnemar(2, 9));
    let mut stream = Seed::root(5).stream();
    for _ in 0..20 {
        let numbers: Vec<i64> = (0..11).map(|_| i64::from(stream.next_u32() % 9) - 4).collect();
        let sum = |signs: u32| -> i64 {
            numbers.iter().enumerate().map(|(place, each)| if signs >> place & 1 == 1 { -each } else { *each }).sum()
        };
        let farther = (0..1 << 11).filter(|signs| sum(*signs).abs() >= sum(0).abs()).count();
        let found = sign_flip(&numbers);
        assert!((found - farther as f64 / 2048.0).abs() < 1e-12, "{numbers:?}: {found}");
    }
    // 6,000 starts, too many for all signs: the normal distribution.
    let many: Vec<i64> = (0..12_000).map(|place| [2, -2, 1, -1, 1, 2][place % 6]).take(6_300).collect();
    assert!(sign_flip(&many) < 1e-12);
}
