//! Quantiles, moments and adjusted probabilities of lists of numbers.

use base::statistics::{holm, mean, normal_below, normal_quantile, quantile, sample_deviation};

use crate::recorded::recorded;

#[test]
fn the_normal_quantile_is_the_inverse_of_the_share_below() {
    for step in 1..2000 {
        let share = f64::from(step) / 2000.0;
        assert!((normal_below(normal_quantile(share)) - share).abs() < 1e-14, "{share}");
    }
    assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
    assert!((normal_quantile(1e-12) + 7.034_483_825_301_18).abs() < 1e-11);
}

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
fn moments_of_known_samples() {
    assert_eq!(mean([]), None);
    assert_eq!(mean([2.0, 4.0, 9.0]), Some(5.0));
    assert_eq!(sample_deviation([3.0]), None);
    assert_eq!(sample_deviation([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]), Some(f64::sqrt(32.0 / 7.0)));
    // Added one by one, ten million tenths are 999999.9998; the compensated sum is exact to the last digit.
    assert_eq!(mean(std::iter::repeat_n(0.1, 10_000_000)), Some(0.1));
}

#[test]
fn adjusted_values_are_those_of_statsmodels() {
    let near = |found: Vec<f64>, wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len());
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} is not {wanted:?}");
    };
    let raw = recorded("p");
    assert!(!raw.is_empty());
    for (p, adjusted) in raw.iter().zip(&recorded("holm")) {
        near(holm(p), adjusted);
    }
    assert!(holm(&[]).is_empty());
}
