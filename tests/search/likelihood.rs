//! Estimates of the likelihood of failures, with answers that are known.

use std::sync::atomic::{AtomicU64, Ordering};

use base::seed::Seed;
use base::statistics::normal_quantile;
use rand::RngExt;
use search::likelihood::{Encounter, Estimate, Likelihood, Limits, encounters_needed, estimate};
use verdict::Blame;

/// Four branches of the limit state of a series system (Waarts, *Structural reliability using finite element methods*, 2000): at least 0 for a
/// failure. Its probability is that of 40 million draws.
fn branches(x: f64, y: f64) -> f64 {
    let root = 2.0_f64.sqrt();
    let bend = 3.0 + 0.1 * (x - y) * (x - y);
    let sides = (x - y + 7.0 / root).min(y - x + 7.0 / root);
    -(bend - (x + y) / root).min(bend + (x + y) / root).min(sides)
}

const ANSWER: f64 = 2.234e-3;

/// Counts failures of the four branches; half of them are faults.
fn counted(seed: u64, relative_error: f64, budget: u64) -> Estimate {
    let run = |_: u64, seed: &Seed| {
        let mut stream = seed.stream();
        let [x, y] = [(); 2].map(|()| normal_quantile(stream.random::<f64>().max(1e-16)));
        let fails = branches(x, y) >= 0.0;
        Encounter { counts: true, events: [fails, false, fails && x + y > 0.0], ticks: 1 }
    };
    let limits = Limits { event: Blame::Any, relative_error, budget, stop: &|| false, progress: &|_| {} };
    estimate(&|| run, &Seed::root(seed), limits)
}

#[test]
fn estimates_are_unbiased_and_intervals_hold_the_answer() {
    let all: Vec<Estimate> = (0..40).map(|seed| counted(seed, 0.2, 1_000_000)).collect();
    let ratios: Vec<f64> = all.iter().map(|each| each.of(Blame::Any).probability / ANSWER).collect();
    let mean = ratios.iter().sum::<f64>() / 40.0;
    let spread = (ratios.iter().map(|ratio| (ratio - mean) * (ratio - mean)).sum::<f64>() / 39.0).sqrt();
    assert!((mean - 1.0).abs() < 3.0 * spread / 40.0_f64.sqrt(), "{mean} of the answer");
    let holds = |each: &&Estimate| (each.of(Blame::Any).low..=each.of(Blame::Any).high).contains(&ANSWER);
    assert!(all.iter().filter(holds).count() >= 36);
    assert!(all.iter().all(|each| each.of(Blame::Any).seen == 25 && !each.short));
    let fault = *all[0].of(Blame::Fault);
    assert!((fault.low..=fault.high).contains(&(ANSWER / 2.0)), "{fault:?}");
}

#[test]
fn a_budget_ends_an_estimate_and_an_unseen_event_has_a_bound() {
    let estimate = counted(3, 0.001, 2000);
    assert!(estimate.short && estimate.encounters >= 2000 && estimate.counted == estimate.encounters);
    let unseen = estimate.of(Blame::Preventable);
    assert_eq!((unseen.probability, unseen.low, unseen.relative_error), (0.0, 0.0, None));
    // 0 of n: 1 - 0.05^(1/n).
    assert!((unseen.high - (1.0 - libm::pow(0.05, 1.0 / estimate.counted as f64))).abs() < 1e-12);
}

#[test]
fn a_stopped_estimate_begins_no_further_encounter() {
    let begun = AtomicU64::new(0);
    let run = |_: u64, _: &Seed| {
        begun.fetch_add(1, Ordering::Relaxed);
        Encounter { counts: true, events: [false; 3], ticks: 1 }
    };
    let stop = || begun.load(Ordering::Relaxed) >= 60;
    let limits = Limits { event: Blame::Any, relative_error: 0.1, budget: 1_000_000, stop: &stop, progress: &|_| {} };
    let found = estimate(&|| run, &Seed::root(1), limits);
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get() as u64).max(64);
    assert!(found.stopped && begun.load(Ordering::Relaxed) <= 60 + threads, "{begun:?}");
}

#[test]
fn a_wanted_bound_needs_three_times_as_many_encounters_as_one_in_how_many() {
    assert_eq!([0.05, 1e-3, 1e-5].map(encounters_needed), [59, 2995, 299_572]);
    for bound in [0.05, 1e-3, 1e-5] {
        let needed = encounters_needed(bound);
        let high = |encounters| Likelihood::new(Blame::Fault, 0, encounters).high;
        assert!(high(needed) <= bound && high(needed - 1) > bound, "{bound}");
    }
}
