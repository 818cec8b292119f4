use rayon::prelude::*;

use super::{Estimate, Event, Events, Likelihood, Limits, Lot, TestBed};
use base::keys;
use base::seed::Seed;

keys! {
    /// Fresh encounters, counted.
    pub struct MonteCarloKeys = "monte_carlo" {}
}

/// Fresh encounters, counted.
///
/// It ends with the encounter in which the event was seen often enough for the relative error; then the probability is (r − 1) / (n − 1), which has no
/// bias (Haldane, *On a method of estimating frequencies*, Biometrika 33, 1945).
#[derive(Debug, Clone, Copy, Default)]
pub struct MonteCarlo;

/// The fewest and the most encounters between two looks at the budget; in between, as many as there were before.
const BATCH: (u64, u64) = (50, 1000);
/// Encounters in a row that use one test bed.
const ROW: usize = 50;

/// A fresh encounter.
struct Fresh {
    counts: bool,
    events: Events,
    ticks: u64,
}

impl MonteCarlo {
    pub fn from_keys(_: MonteCarloKeys) -> Self {
        Self
    }

    pub(super) fn estimate<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        seed: &Seed,
        limits: Limits<'_>,
    ) -> Estimate {
        let wanted = (1.0 / (limits.relative_error * limits.relative_error)).ceil() as u64;
        let target = limits.event as usize;
        let (mut encounters, mut counting, mut ticks) = (0, 0, 0);
        let mut seen = [0; Event::COUNT];
        let mut enough = false;
        let mut stopped = false;
        while !enough && ticks < limits.budget {
            stopped = (limits.stop)();
            if stopped {
                break;
            }
            let next = encounters.clamp(BATCH.0, BATCH.1);
            for fresh in batch(make, seed, encounters..encounters + next) {
                ticks += fresh.ticks;
                if enough {
                    continue;
                }
                encounters += 1;
                counting += u64::from(fresh.counts);
                seen.iter_mut().zip(fresh.events).for_each(|(seen, event)| *seen += u64::from(event));
                enough = seen[target] == wanted;
            }
            (limits.progress)(ticks);
        }
        let likelihood = |event: &Event| {
            let plain = Likelihood::of_share(*event, seen[*event as usize], counting);
            let unbiased = (plain.seen as f64 - 1.0) / (counting as f64 - 1.0);
            let probability = if enough && *event == limits.event { unbiased } else { plain.probability };
            Likelihood { probability, ..plain }
        };
        Estimate {
            likelihoods: Event::ALL.iter().map(likelihood).collect(),
            encounters,
            ticks,
            counting: counting as f64 / encounters.max(1) as f64,
            fresh: counting,
            levels: Vec::new(),
            populations: Vec::new(),
            greatest_weight: 0.0,
            short: !enough,
            stopped,
        }
    }
}

/// Runs the encounters with these numbers.
fn batch<B: TestBed>(make: &(dyn Fn() -> B + Sync), seed: &Seed, numbers: std::ops::Range<u64>) -> Vec<Fresh> {
    let numbers: Vec<u64> = numbers.collect();
    let rows = numbers.par_chunks(ROW).map(|numbers| {
        let mut bed = make();
        let run = |number: &u64| {
            let before = bed.ticks();
            let mut lot = Lot::new(*number, &seed.index(*number));
            bed.begin(&mut lot);
            while bed.step(&mut lot) {}
            let trial = bed.trial();
            let events = if trial.fails() { bed.judge(&mut lot) } else { [false; Event::COUNT] };
            Fresh { counts: trial.counts, events, ticks: bed.ticks() - before }
        };
        numbers.iter().map(run).collect::<Vec<_>>()
    });
    rows.collect::<Vec<_>>().into_iter().flatten().collect()
}
