use rand::RngExt;
use rayon::prelude::*;

use super::moves::{Particle, Steps, run};
use super::{Estimate, Event, Likelihood, Limits, Lot, TestBed};
use base::keys;
use base::seed::{Seed, Stream};

keys! {
    /// Populations of encounters that climb from level to level towards a failure: for what plain encounters never see.
    pub struct SubsetSimulationKeys = "subset_simulation" {
        /// Encounters of a population.
        particles: usize as whole(20, 1_000_000) = "300",
        /// Populations between two looks at the error. They are independent, so their spread is the error.
        populations: usize as whole(4, 10_000) = "10",
        /// Moves from an encounter of a population to the next.
        moves: u64 as whole(1, 1000) = "2",
        /// Share of a population that reaches the next level.
        share: f64 as within(RATIO, 0.02, 0.8) = "0.2",
    }
}

/// Subset simulation, or multilevel splitting: the probability of a failure is the product of those to get from each level to the next.
///
/// A first population chooses the levels and the steps of the moves; it counts for nothing else. With fixed levels and moves each later population is an estimate
/// without bias: encounters below the next level are replaced by rows that start at those above it, and move on in ways that leave the law of
/// encounters above the level as it is. The error is the spread of the populations.
///
/// # Source
/// Au and Beck, *Estimation of small failure probabilities in high dimensions by subset simulation*, Probabilistic Engineering Mechanics 16, 2001;
/// Cérou, Del Moral, Furon and Guyader, *Sequential Monte Carlo for rare event estimation*, Statistics and Computing 22, 2012 (no bias at
/// fixed levels).
#[derive(Debug, Clone)]
pub struct SubsetSimulation {
    keys: SubsetSimulationKeys,
}

/// The fewest populations whose spread says anything.
const FEWEST: u64 = 4;
/// Rows of moves between two changes of their steps in the first population.
const ADAPTED: usize = 20;
/// The most levels; then the failure is out of reach.
const MOST_LEVELS: usize = 60;

/// The levels and the steps of the moves at each.
type Schedule = Vec<(f64, Steps)>;

/// The result of a population.
struct Population {
    /// Its estimate for each event, among all encounters.
    estimates: [f64; Event::COUNT],
    encounters: u64,
    ticks: u64,
    /// Fresh encounters that count.
    counting: u64,
    longest: usize,
    schedule: Schedule,
    stopped: bool,
}

impl SubsetSimulation {
    pub fn from_keys(keys: SubsetSimulationKeys) -> Self {
        Self { keys }
    }

    pub(super) fn estimate<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        seed: &Seed,
        limits: Limits<'_>,
    ) -> Estimate {
        let first = self.population(&mut make(), None, 1, &seed.child("levels"), limits);
        let (schedule, longest) = (&first.schedule, first.longest);
        let mut ticks = first.ticks;
        let mut encounters = first.encounters;
        let mut all: Vec<Population> = Vec::new();
        let mut stopped = first.stopped;
        (limits.progress)(ticks);
        let reached = schedule.last().is_some_and(|(level, _)| *level >= 0.0);
        let values = |all: &[Population], event: Event| -> Vec<f64> {
            all.iter().map(|population| population.estimates[event as usize]).collect()
        };
        let mut enough = false;
        // Without a way up, or without budget for a few populations, fresh encounters bound the probability.
        while reached && !stopped && !enough {
            let possible = limits.budget.saturating_sub(ticks) / first.ticks.max(1);
            let batch = possible.min(self.keys.populations as u64);
            if batch < FEWEST {
                break;
            }
            let next = all.len() as u64..all.len() as u64 + batch;
            let numbers: Vec<u64> = next.collect();
            let more: Vec<Population> = numbers
                .into_par_iter()
                .map(|number| {
                    let seed = seed.child("population").index(number);
                    self.population(&mut make(), Some(schedule), longest, &seed, limits)
                })
                .collect();
            stopped = more.iter().any(|population| population.stopped);
            if stopped {
                break;
            }
            ticks += more.iter().map(|population| population.ticks).sum::<u64>();
            encounters += more.iter().map(|population| population.encounters).sum::<u64>();
            all.extend(more);
            (limits.progress)(ticks);
            let error = Likelihood::of_estimates(limits.event, &values(&all, limits.event), 1).relative_error;
            enough = error.is_some_and(|error| error <= limits.relative_error);
        }
        let drawn = (self.keys.particles * all.len().max(1)) as u64;
        let fresh = if all.is_empty() { first.counting } else { all.iter().map(|each| each.counting).sum() };
        let counting = fresh as f64 / drawn as f64;
        let likelihood = |event: &Event| {
            let likelihood = Likelihood::of_estimates(*event, &values(&all, *event), fresh);
            if likelihood.seen > 0 { likelihood.among(counting) } else { likelihood }
        };
        Estimate {
            likelihoods: Event::ALL.iter().map(likelihood).collect(),
            encounters,
            ticks,
            counting,
            fresh,
            levels: schedule.iter().map(|(level, _)| *level).collect(),
            populations: values(&all, Event::Failure),
            greatest_weight: 0.0,
            short: !enough,
            stopped,
        }
    }

    /// Runs a population; one without a schedule makes it.
    fn population<B: TestBed>(
        &self,
        bed: &mut B,
        schedule: Option<&Schedule>,
        longest: usize,
        seed: &Seed,
        limits: Limits<'_>,
    ) -> Population {
        let SubsetSimulationKeys { particles, moves, share, .. } = self.keys;
        let first = schedule.and_then(|schedule| schedule.first()).map_or(f64::INFINITY, |(level, _)| *level);
        let fresh = seed.child("fresh");
        let mut all: Vec<Particle<B::Mark>> = Vec::with_capacity(particles);
        let mut encounters = 0;
        let result = |probability: [f64; Event::COUNT], bed: &B, all: &[_], encounters, schedule, stopped| Population {
            estimates: probability,
            encounters,
            ticks: bed.ticks(),
            counting: 0,
            longest: all.iter().map(|particle: &Particle<B::Mark>| particle.climb.len()).max().unwrap_or(1),
            schedule,
            stopped,
        };
        for number in 0..particles as u64 {
            if number.is_multiple_of(16) && (limits.stop)() {
                return result([0.0; Event::COUNT], bed, &all, encounters, Vec::new(), true);
            }
            all.push(run(bed, Lot::new(number, &fresh.index(number)), first));
            encounters += 1;
        }
        let counting = all.iter().filter(|particle| particle.counts).count() as u64;
        let longest =
            if schedule.is_some() { longest } else { all.iter().map(|each| each.climb.len()).max().unwrap_or(1) };
        let mut made = Schedule::new();
        let mut steps = Steps::new();
        let mut probability = 1.0;
        for stage in 0..MOST_LEVELS {
            let level = match schedule {
                Some(schedule) => schedule[stage].0,
                None => {
                    let before = made.last().map_or(f64::NEG_INFINITY, |(level, _)| *level);
                    match next_level(&all, share, before) {
                        Some(level) => level,
                        None => break,
                    }
                }
            };
            steps = schedule.map_or(steps, |schedule| schedule[stage].1);
            let mut above: Vec<Particle<B::Mark>> = all.iter().filter(|each| each.height >= level).cloned().collect();
            probability *= above.len() as f64 / particles as f64;
            if above.is_empty() {
                break;
            }
            let stage_seed = seed.child("stage").index(stage as u64);
            let copies = copies(above.len(), particles, &mut stage_seed.stream());
            for (parent, count) in copies.into_iter().enumerate() {
                if (limits.stop)() {
                    return Population { counting, ..result([0.0; Event::COUNT], bed, &all, encounters, made, true) };
                }
                let mut particle = above[parent].clone();
                let seed = stage_seed.index(parent as u64);
                for round in 0..(count as u64 - 1) * moves {
                    encounters += u64::from(particle.vary(bed, level, &mut steps, longest, seed.index(round)));
                    if (round + 1).is_multiple_of(moves) {
                        above.push(particle.clone());
                    }
                }
                if schedule.is_none() && parent % ADAPTED == 0 {
                    steps.adapt();
                }
            }
            made.push((level, steps));
            all = above;
            if level >= 0.0 {
                let estimates = verdicts(bed, &mut all, &mut encounters, schedule.is_some());
                let estimates = estimates.map(|share| share * probability);
                return Population { counting, ..result(estimates, bed, &all, encounters, made, false) };
            }
        }
        Population { counting, ..result([0.0; Event::COUNT], bed, &all, encounters, made, false) }
    }
}

/// The share of the failures in which each event happened.
fn verdicts<B: TestBed>(
    bed: &mut B,
    failures: &mut [Particle<B::Mark>],
    encounters: &mut u64,
    wanted: bool,
) -> [f64; Event::COUNT] {
    let mut seen = [0.0; Event::COUNT];
    if wanted {
        for failure in failures.iter_mut() {
            let events = bed.judge(&mut failure.lot);
            *encounters += 1;
            seen.iter_mut().zip(events).for_each(|(seen, event)| *seen += f64::from(u8::from(event)));
        }
    }
    seen.map(|seen| seen / failures.len() as f64)
}

/// The level that this share of the population reaches, at most 0; none if that is no higher than the level before.
fn next_level<M>(all: &[Particle<M>], share: f64, before: f64) -> Option<f64> {
    let mut heights: Vec<f64> = all.iter().map(|each| each.height).collect();
    heights.sort_by(|a, b| b.total_cmp(a));
    let place = ((share * all.len() as f64) as usize).clamp(1, all.len() - 1);
    let level = heights[place - 1].min(0.0);
    (level > before).then_some(level)
}

/// How many each of some particles makes of the next population: as equally often as possible, the rest drawn without replacement.
fn copies(own: usize, all: usize, stream: &mut Stream) -> Vec<usize> {
    let mut counts = vec![all / own; own];
    let mut order: Vec<usize> = (0..own).collect();
    for place in 0..all % own {
        let other = stream.random_range(place..own);
        order.swap(place, other);
        counts[order[place]] += 1;
    }
    counts
}
