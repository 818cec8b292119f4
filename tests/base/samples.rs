//! Figures of trainings that are estimated from episodes: how often their intervals hold the truth.

use base::seed::{Seed, Stream};
use base::statistics::{Sample, mean_interval, normal_quantile, student_quantile_at, student_tails};
use rand::Rng;

use crate::recorded::recorded;

/// A number between 0 and 1, never at an end.
fn uniform(stream: &mut Stream) -> f64 {
    ((stream.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// Members without noise of episodes.
fn exact(first: &[f64], second: &[f64]) -> Sample {
    let values = [first, second].concat();
    let covariance = vec![0.0; values.len() * values.len()];
    Sample { covariance, first: first.len(), values, trained: [true; 2], episodes: 1_000.into() }
}

#[test]
fn without_noise_of_episodes_the_test_is_welchs() {
    for case in recorded("welch") {
        let (first, second) = case[4..].split_at(case[0] as usize);
        let found = exact(first, second);
        let uncertainty = found.uncertainty().unwrap();
        let (p, (low, high)) = (uncertainty.p(found.estimate()), uncertainty.interval(found.estimate()));
        assert!((p - case[1]).abs() < 1e-9 * case[1], "{case:?}: {p}");
        assert!((low - case[2]).abs() < 1e-9 && (high - case[3]).abs() < 1e-9, "{case:?}: {low}..{high}");
        let few = [first.len(), second.len()].iter().any(|runs| *runs < 4);
        assert_eq!(found.interval(), (!few).then_some((low, high)), "fewer than four have no interval");
    }
}

#[test]
fn a_single_training_says_nothing_about_others_and_an_untrained_pedestrian_does() {
    assert_eq!(exact(&[0.9], &[0.5, 0.6]).p(), None);
    let mut sample = exact(&[0.8, 0.9, 0.8, 0.9], &[0.5]);
    assert_eq!((sample.p(), sample.interval()), (None, None));
    sample.trained[1] = false;
    sample.covariance[24] = 0.0025 / 3.0;
    let (low, high) = sample.interval().unwrap();
    // By hand: variances 0.01 / 3 / 4 between trainings and as much of the episodes: 2² · 3 degrees of freedom.
    let half = student_quantile_at(12.0, 0.05) * (0.005_f64 / 3.0).sqrt();
    assert!((low - 0.35 + half).abs() < 1e-12 && (high - 0.35 - half).abs() < 1e-12, "{low}..{high}");
}

#[test]
fn what_common_episodes_add_to_both_groups_cancels() {
    let mut sample = exact(&[0.8, 0.9, 0.85], &[0.5, 0.6, 0.55]);
    let without = sample.uncertainty().unwrap();
    sample.covariance.fill(0.01);
    assert_eq!(sample.uncertainty().unwrap(), without);
}

#[test]
fn where_nothing_varies_one_episode_is_the_error() {
    let p = exact(&[1.0, 1.0, 1.0], &[0.0, 0.0, 0.0]).p().unwrap();
    assert!((p - student_tails(1_000.0, 2.0)).abs() < 1e-12 && p > 0.0, "{p}");
    assert!(exact(&[1.0; 3], &[1.0; 3]).p().unwrap() > 0.999);
}

/// How often the intervals contain the truth, in campaigns whose trainings are drawn from a known distribution.
#[test]
fn intervals_hold_the_truth_as_often_as_the_readme_says() {
    const CAMPAIGNS: u64 = 200;
    for trainings in [3, 5, 10] {
        let mut held = 0;
        for campaign in 0..CAMPAIGNS {
            let mut stream = Seed::root(7).index(trainings).index(campaign).child("truth").stream();
            let values = (0..trainings).map(|_| 0.8 + 0.05 * normal_quantile(uniform(&mut stream))).collect::<Vec<_>>();
            let sample = exact(&values, &[]);
            let (low, high) = sample.uncertainty().unwrap().interval(sample.estimate());
            held += u64::from(low <= 0.8 && 0.8 <= high);
        }
        let share = held as f64 / CAMPAIGNS as f64;
        assert!((0.925..0.985).contains(&share), "{trainings}: {share}");
    }
}

/// A campaign in which trainings and starts are crossed: figures of `trainings` at `starts`, x = 0.5 + t + s + e with these standard
/// deviations, and their covariance as [`Sample`] wants it.
fn crossed(stream: &mut Stream, trainings: usize, starts: usize, [t, s, e]: [f64; 3]) -> Sample {
    let mut normal = |deviation: f64| deviation * normal_quantile(uniform(stream));
    let common: Vec<f64> = (0..starts).map(|_| normal(s)).collect();
    let rows: Vec<Vec<f64>> = (0..trainings)
        .map(|_| {
            let own = 0.5 + normal(t);
            common.iter().map(|start| own + start + normal(e)).collect()
        })
        .collect();
    let n = starts as f64;
    let values: Vec<f64> = rows.iter().map(|row| row.iter().sum::<f64>() / n).collect();
    let pull = |row: usize, start: usize| (rows[row][start] - values[row]) / n;
    let covariance = |(a, b): (usize, usize)| (0..starts).map(|start| pull(a, start) * pull(b, start)).sum();
    let pairs = (0..trainings).flat_map(|a| (0..trainings).map(move |b| (a, b)));
    let covariance = pairs.map(covariance).collect();
    Sample { values, covariance, first: trainings, trained: [true; 2], episodes: (starts as u64).into() }
}

/// How often the interval contains the truth when all trainings meet the same starts. The spread between trainings shows nothing of
/// what the starts add, so an interval from it alone is too narrow.
#[test]
fn intervals_hold_the_truth_when_starts_are_common() {
    const CAMPAIGNS: u64 = 400;
    for (deviations, alone_at_most) in [([0.02, 0.3, 0.2], 0.8), ([0.02, 0.1, 0.4], 0.95), ([0.05, 0.0, 0.4], 1.0)] {
        let (mut both, mut alone) = (0, 0);
        for campaign in 0..CAMPAIGNS {
            let sample = crossed(&mut Seed::root(11).index(campaign).stream(), 5, 200, deviations);
            let (low, high) = sample.interval().unwrap();
            both += u64::from((low..=high).contains(&0.5));
            let (low, high) = mean_interval(&sample.values).1.unwrap();
            alone += u64::from((low..=high).contains(&0.5));
        }
        let share = |held: u64| held as f64 / CAMPAIGNS as f64;
        // Of 400 campaigns 95 % have a standard deviation of 1.1 points.
        assert!((0.92..0.985).contains(&share(both)), "{deviations:?}: {}", share(both));
        assert!(share(alone) <= alone_at_most, "{deviations:?}: {}", share(alone));
    }
}

/// Two trainings whose spread is small by chance would have a p of 1e-7.
#[test]
fn two_trainings_have_no_p() {
    let of = |first: &[f64], second: &[f64]| exact(first, second).p();
    assert_eq!(of(&[0.8, 0.8001], &[0.5, 0.4, 0.45]), None);
    assert_eq!(of(&[0.8, 0.81, 0.79], &[0.5, 0.5001]), None);
    assert!(of(&[0.8, 0.81, 0.79], &[0.5, 0.4, 0.45]).unwrap() < 0.05);
}
