//! Stacked and normalised observations, and shaped rewards.

use learn::{FrameStack, RunningMoments, Step, shaping};
use proptest::prelude::*;

#[test]
fn the_oldest_comes_first_and_an_episode_begins_with_zeros() {
    let mut stack = FrameStack::new(2, 3);
    stack.begin(&[1.0, 2.0]);
    assert_eq!(stack.as_slice(), [0.0, 0.0, 0.0, 0.0, 1.0, 2.0]);
    stack.push(&[3.0, 4.0]);
    stack.push(&[5.0, 6.0]);
    stack.push(&[7.0, 8.0]);
    assert_eq!(stack.as_slice(), [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    stack.begin(&[9.0, 9.5]);
    assert_eq!(stack.as_slice(), [0.0, 0.0, 0.0, 0.0, 9.0, 9.5]);
}

#[test]
fn batches_of_any_size_give_the_moments_of_all_samples() {
    let samples: Vec<[f64; 2]> = (0..60).map(|i| [libm::sin(f64::from(i)), 5.0 + f64::from(i)]).collect();
    for size in [1, 7, 60] {
        let mut moments = RunningMoments::new(2);
        for batch in samples.chunks(size) {
            moments.update(batch.iter().map(|sample| &sample[..]));
        }
        for i in 0..2 {
            let mean = samples.iter().map(|x| x[i]).sum::<f64>() / 60.0;
            let variance = samples.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / 60.0;
            // The initial estimate weighs a ten-thousandth of a sample.
            assert!((moments.mean[i] - mean).abs() < 1e-4);
            assert!((moments.variance[i] / variance - 1.0).abs() < 1e-4);
        }
        assert!((moments.count - 60.0001).abs() < 1e-9);
    }
}

#[test]
fn normalising_shifts_scales_and_clips() {
    let moments = RunningMoments { mean: vec![2.0], variance: vec![4.0], count: 10.0 };
    assert!((moments.normalised(0, 5.0) - 1.5).abs() < 1e-8);
    assert!((moments.scaled(0, 5.0) - 2.5).abs() < 1e-8);
    assert_eq!((moments.normalised(0, -90.0), moments.scaled(0, 90.0)), (-10.0, 10.0));
    // At zero variance the epsilon keeps the quotient finite.
    let still = RunningMoments { variance: vec![0.0], ..moments };
    assert_eq!(still.normalised(0, 2.0), 0.0);
    assert!((still.normalised(0, 2.0 + 1e-4) - 1.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn every_terminated_episode_earns_the_same_from_any_of_its_states(
        potentials in prop::collection::vec(-5.0..5.0, 2..30), rewards in prop::collection::vec(-2.0..2.0, 30),
        gamma in 0.0..=1.0,
    ) {
        let last = potentials.len() - 2;
        let (mut plain, mut shaped): (f64, f64) = (0.0, 0.0);
        for t in (0..=last).rev() {
            let step = Step { reward: rewards[t], terminated: t == last, truncated: false };
            let beside: f64 = shaping(potentials[t], potentials[t + 1], step, gamma);
            plain = step.reward + gamma * plain;
            shaped = step.reward + beside + gamma * shaped;
            // In every state and for every sequence, the value with shaping is the value without it minus the potential.
            prop_assert!((shaped - (plain - potentials[t])).abs() < 1e-9, "{shaped} {plain} {}", potentials[t]);
        }
    }

    #[test]
    fn an_episode_that_is_cut_off_differs_by_the_potential_as_well(
        potentials in prop::collection::vec(-5.0..5.0, 2..30), beyond in -3.0..3.0, gamma in 0.0..=1.0,
    ) {
        // The rewards that would have followed are worth `beyond`; with shaping, `beyond` minus the potential there.
        let last = potentials.len() - 2;
        let (mut plain, mut shaped): (f64, f64) = (beyond, beyond - potentials[last + 1]);
        for t in (0..=last).rev() {
            let step = Step { reward: 1.0, terminated: false, truncated: t == last };
            plain = 1.0 + gamma * plain;
            shaped = 1.0 + shaping(potentials[t], potentials[t + 1], step, gamma) + gamma * shaped;
        }
        prop_assert!((shaped - (plain - potentials[0])).abs() < 1e-9);
    }
}
