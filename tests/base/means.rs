//! Tests and intervals of means and of their differences, by Student and Welch.

use base::statistics::{
    Uncertainty, bounded_interval, mean_interval, mean_interval_at, mean_p, student_quantile_at, student_tails,
};

use crate::recorded::recorded;

#[test]
fn the_test_of_a_mean_is_students() {
    let p = mean_p(&[1.0, 2.0, 0.5]).unwrap();
    // The mean is 7/6 and the variance 7/12. With 2 degrees of freedom Student's distribution has a closed form.
    let t = 7.0 / 6.0 / libm::sqrt(7.0 / 12.0 / 3.0);
    let closed = 1.0 - t / libm::sqrt(2.0 + t * t);
    assert!((p - closed).abs() < 1e-9, "{p} {closed}");
    assert_eq!(mean_p(&[0.0, 0.0, 0.0]), None);
    assert_eq!(mean_p(&[1.0]), None);
    assert_eq!(mean_p(&[1.0, 1.2]), None, "the spread of two is no measure of that of others");
    assert_eq!(mean_p(&[2.0; 10]), Some(2.0 / 1_024.0));
    assert_eq!(mean_p(&[0.025; 3]), Some(0.25), "their mean is 0.025000000000000005");
}

#[test]
fn the_interval_is_students() {
    // By hand: mean 2, variance 2 / 3, t = 3.182446.
    let (mean, interval) = mean_interval(&[1.0, 2.0, 2.0, 3.0]);
    let (low, high) = interval.unwrap();
    let half = 3.182_446_305_284 / 6_f64.sqrt();
    assert!((mean - 2.0).abs() < 1e-12 && (low - 2.0 + half).abs() < 1e-9 && (high - 2.0 - half).abs() < 1e-9);
    assert_eq!(mean_interval(&[4.0, 5.0, 6.0]), (5.0, None), "three are too few");
    assert_eq!(mean_interval(&[0.7; 5]).1, None, "equal numbers show no spread");
    let (wider, _) = mean_interval_at(&[1.0, 2.0, 2.0, 3.0], 0.01).unwrap();
    assert!((2.0 - wider - 5.840_909_309_733 / 6_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn tails_and_quantiles_are_those_of_scipy() {
    for case in recorded("student_tails") {
        let [t, degrees, tails] = case[..] else { panic!("{case:?}") };
        let found = student_tails(t, degrees);
        assert!((found - tails).abs() <= 1e-10 * tails, "{case:?}: {found}");
    }
    for case in recorded("student_quantile") {
        let [degrees, quantile] = case[..] else { panic!("{case:?}") };
        let found = student_quantile_at(degrees, 0.05);
        assert!((found - quantile).abs() < 1e-9 * quantile, "{case:?}: {found}");
    }
}

#[test]
fn the_interval_of_a_difference_is_scipys() {
    // scipy 1.17.1: stats.t.ppf(0.975, 2.391412) times the standard error, for 0.02 of 5 and 0.05 of 3.
    let of_mean = |sd, n| Uncertainty::of_mean(sd, n).unwrap();
    let (low, high) = of_mean(0.02, 5).of_difference(of_mean(0.05, 3)).interval(1.0);
    let half = 0.111_622_865_793;
    assert!((low - 1.0 + half).abs() < 1e-9 && (high - 1.0 - half).abs() < 1e-9, "{low}..{high}");
    assert_eq!(Uncertainty::of_mean(0.02, 1), None);
}

#[test]
fn an_interval_of_a_figure_with_bounds_holds_no_impossible_value() {
    let positive = (0.0, f64::INFINITY);
    let (low, high) = bounded_interval(2.0, 0.5, positive);
    assert!((low * high - 4.0).abs() < 1e-12 && (high / 2.0 - libm::exp(0.25)).abs() < 1e-12);
    let (low, high) = bounded_interval(0.5, 0.2, (0.0, 1.0));
    assert!((low + high - 1.0).abs() < 1e-12 && (low - 1.0 / (1.0 + libm::exp(0.8))).abs() < 1e-12, "{low} {high}");
    // Far from a bound it is Student's.
    let (low, high) = bounded_interval(1000.0, 1.0, positive);
    assert!((low - 999.0).abs() < 1e-3 && (high - 1001.0).abs() < 1e-3);
    for bounds in [positive, (0.0, 1.0)] {
        for (estimate, half) in [(0.001, 0.01), (0.3, 5.0), (0.999, 0.1), (0.0, 0.1), (1.0, 0.2)] {
            let (low, high) = bounded_interval(estimate, half, bounds);
            assert!(bounds.0 <= low && low <= estimate && estimate <= high && high <= bounds.1, "{low} {high}");
            assert!(estimate == 0.0 || low > 0.0, "{estimate} {half}: {low}");
        }
    }
    assert_eq!(bounded_interval(-1.0, 2.0, (f64::NEG_INFINITY, f64::INFINITY)), (-3.0, 1.0));
}
