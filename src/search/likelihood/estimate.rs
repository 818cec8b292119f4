use rayon::prelude::*;

use base::seed::Seed;
use base::statistics::clopper_pearson;
use verdict::Blame;

/// Significance level of the intervals, and of the one-sided bound of an event that was never seen.
const ALPHA: f64 = 0.05;
/// Minimum and maximum number of encounters between two checks of the budget; in between, as many as there were before.
const BATCH: (u64, u64) = (50, 1000);
/// Number of consecutive encounters that one worker runs.
const ROW: usize = 50;

/// When an estimate ends.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// The failures that the relative error is about.
    pub event: Blame,
    /// The relative error at which it ends.
    pub relative_error: f64,
    /// Maximum number of ticks. A batch that has begun is finished.
    pub budget: u64,
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Called with the number of ticks used so far.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// The result of an encounter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encounter {
    /// Whether it counts. The driver may be lost before a pedestrian had any part in it.
    pub counts: bool,
    pub events: [bool; Blame::COUNT],
    pub ticks: u64,
}

/// The probability of an event in an encounter, with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Likelihood {
    pub event: Blame,
    /// The probability, 0 to 1.
    pub probability: f64,
    /// The 95 % interval. If the event was never seen, it begins at 0, and its end is a one-sided bound.
    pub low: f64,
    pub high: f64,
    /// Standard error as a fraction of the probability; `None` if the event was never seen.
    pub relative_error: Option<f64>,
    /// Number of encounters in which it was seen.
    pub seen: u64,
}

/// How likely failures are.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    /// One for each event, in the order of [`Blame`].
    pub likelihoods: Vec<Likelihood>,
    pub encounters: u64,
    /// Number of these that count; probabilities are among these.
    pub counted: u64,
    pub ticks: u64,
    /// Whether it ended before the relative error was reached.
    pub short: bool,
    /// Whether it was stopped from outside.
    pub stopped: bool,
}

impl Likelihood {
    /// Of a number of independent encounters, in some of which the event was seen.
    pub fn new(event: Blame, seen: u64, encounters: u64) -> Self {
        let alpha = if seen == 0 { 2.0 * ALPHA } else { ALPHA };
        let (low, high) = clopper_pearson(seen, encounters, alpha);
        let probability = seen as f64 / (encounters.max(1)) as f64;
        let relative_error = (seen > 0).then(|| ((1.0 - probability) / seen as f64).sqrt());
        Self { event, probability, low, high, relative_error, seen }
    }
}

impl Estimate {
    pub fn of(&self, event: Blame) -> &Likelihood {
        &self.likelihoods[event as usize]
    }

    /// Fraction of the encounters that count.
    pub fn counting(&self) -> f64 {
        self.counted as f64 / self.encounters.max(1) as f64
    }
}

/// Number of encounters, none of which has the event, that bound its probability with 95 % confidence: ln α / ln(1 − p).
pub fn encounters_needed(bound: f64) -> u64 {
    (libm::log(ALPHA) / libm::log1p(-bound)).ceil() as u64
}

/// Counts the events of independent encounters. `make` makes a worker, which runs the encounter with a number and a seed.
///
/// It ends with the encounter in which the event was seen often enough for the relative error; then the probability is (r − 1) / (n − 1),
/// which has no bias (Haldane, *On a method of estimating frequencies*, Biometrika 33, 1945). The result does not depend on the number of
/// threads.
pub fn estimate<W: FnMut(u64, &Seed) -> Encounter>(
    make: &(dyn Fn() -> W + Sync),
    seed: &Seed,
    limits: Limits<'_>,
) -> Estimate {
    let wanted = (1.0 / (limits.relative_error * limits.relative_error)).ceil() as u64;
    let target = limits.event as usize;
    let (mut encounters, mut counted, mut ticks) = (0, 0, 0);
    let mut seen = [0; Blame::COUNT];
    let (mut enough, mut stopped) = (false, false);
    while !enough && ticks < limits.budget {
        let next = encounters.clamp(BATCH.0, BATCH.1);
        let batch = batch(make, seed, encounters..encounters + next, limits.stop);
        stopped = (limits.stop)();
        if stopped {
            break;
        }
        for encounter in batch {
            ticks += encounter.ticks;
            if enough {
                continue;
            }
            encounters += 1;
            counted += u64::from(encounter.counts);
            seen.iter_mut().zip(encounter.events).for_each(|(seen, event)| *seen += u64::from(event));
            enough = seen[target] == wanted;
        }
        (limits.progress)(ticks);
    }
    let likelihood = |event: &Blame| {
        let plain = Likelihood::new(*event, seen[*event as usize], counted);
        let unbiased = (plain.seen as f64 - 1.0) / (counted as f64 - 1.0);
        let probability = if enough && *event == limits.event { unbiased } else { plain.probability };
        Likelihood { probability, ..plain }
    };
    let likelihoods = Blame::ALL.iter().map(likelihood).collect();
    Estimate { likelihoods, encounters, counted, ticks, short: !enough, stopped }
}

/// Runs the encounters with these numbers, or some of them if it is stopped.
fn batch<W: FnMut(u64, &Seed) -> Encounter>(
    make: &(dyn Fn() -> W + Sync),
    seed: &Seed,
    numbers: std::ops::Range<u64>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Encounter> {
    let numbers: Vec<u64> = numbers.collect();
    let rows = numbers.par_chunks(ROW).map(|numbers| {
        let mut run = make();
        let going = numbers.iter().take_while(|_| !stop());
        going.map(|number| run(*number, &seed.index(*number))).collect::<Vec<_>>()
    });
    rows.collect::<Vec<_>>().into_iter().flatten().collect()
}
