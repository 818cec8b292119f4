//! What sensors miss and confuse.

use base::seed::Seed;
use world::av::sensors::{Drift, Luck};

/// Mean, and autocorrelation after `lag` steps, of a series about a known mean.
fn moments(series: &[f64], mean: f64, lag: usize) -> (f64, f64) {
    let average = series.iter().sum::<f64>() / series.len() as f64;
    let product = |lag: usize| {
        let pairs = series.iter().zip(&series[lag..]);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (series.len() - lag) as f64
    };
    (average, product(lag) / product(0))
}

#[test]
fn misses_have_the_documented_rate_and_correlation() {
    let (count, dt, time) = (400_000, 0.05, 0.3);
    let keep = libm::exp(-dt / time);
    for rate in [0.02, 0.15, 0.5] {
        let mut luck = Luck::new(Seed::root(1).child("rate").stream());
        let series: Vec<f64> = (0..count)
            .map(|_| {
                luck.advance(keep);
                if luck.fails(rate) { 1.0 } else { 0.0 }
            })
            .collect();
        // A correlated series is worth n (1 − ρ) / (1 + ρ) independent draws.
        let worth = f64::from(count) * (1.0 - keep) / (1.0 + keep);
        let deviation = (rate * (1.0 - rate) / worth).sqrt();
        let (mean, _) = moments(&series, rate, 1);
        assert!((mean - rate).abs() < 3.0 * deviation, "{mean}, not {rate} ± {deviation}");
        for lag in [1, 6, 18] {
            let wanted = libm::pow(keep, lag as f64);
            let (_, got) = moments(&series, rate, lag);
            assert!((got - wanted).abs() < 0.03, "after {lag} steps of rate {rate}: {got}, not {wanted}");
        }
        let ends = series.windows(2).filter(|pair| pair[0] > pair[1]).count();
        let length = dt * series.iter().sum::<f64>() / ends as f64;
        let wanted = dt / ((1.0 - keep) * (1.0 - rate));
        assert!((length / wanted - 1.0).abs() < 0.05, "a miss lasts {length} s, not {wanted}");
    }
}

#[test]
fn a_worse_sensor_misses_whatever_a_better_one_misses() {
    let mut luck = Luck::new(Seed::root(2).stream());
    for _ in 0..1000 {
        luck.advance(0.8);
        assert!(!luck.fails(0.1) || luck.fails(0.3));
        assert!(luck.fails(1.0) && !luck.fails(0.0));
    }
}

#[test]
fn errors_are_standard_normal_and_drift() {
    let count = 200_000;
    for keep in [0.0, 0.85] {
        let mut drift = Drift::new(Seed::root(3).stream());
        let series: Vec<[f64; Drift::COUNT]> = (0..count)
            .map(|_| {
                drift.advance(keep);
                *drift.errors()
            })
            .collect();
        let worth = f64::from(count) * (1.0 - keep) / (1.0 + keep);
        for which in 0..Drift::COUNT {
            let one: Vec<f64> = series.iter().map(|errors| errors[which]).collect();
            let (mean, correlation) = moments(&one, 0.0, 1);
            let square = one.iter().map(|error| error * error).sum::<f64>() / f64::from(count);
            assert!(mean.abs() < 4.0 / worth.sqrt(), "mean {mean}");
            assert!((square - 1.0).abs() < 6.0 / worth.sqrt(), "variance {square}");
            assert!((correlation - keep).abs() < 0.02, "correlation {correlation}");
            let tails = one.iter().filter(|error| error.abs() > 1.96).count() as f64 / f64::from(count);
            assert!((tails - 0.05).abs() < 0.005, "tails {tails}");
        }
        let product = series.iter().map(|errors| errors[0] * errors[1]).sum::<f64>() / f64::from(count);
        assert!(product.abs() < 6.0 / worth.sqrt(), "the pair is independent: {product}");
    }
}
