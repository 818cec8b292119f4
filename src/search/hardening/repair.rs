use std::sync::Arc;

use super::plan::Hardening;
use crate::likelihood::latin_hypercube;
use crate::optimizer::{CmaEs, Optimizer};
use base::seed::Seed;
use episode::walker::WalkPolicy;
use episode::{Scenario, walk_again};
use verdict::{Drive, Traffic, drives};
use world::sim::WalkCommand;

/// Standard deviation of the first generation of the local search; 1 is the range of a key.
const FIRST_STEP: f64 = 0.2;

/// A failure, to be met again.
#[derive(Debug, Clone)]
pub(super) struct Kept {
    /// The town, by its place.
    pub town: usize,
    /// The seed of the starts, and the number of the start.
    pub seed: Seed,
    pub start: u64,
    pub commands: Vec<WalkCommand>,
}

/// All that the rounds up to now leave for repairs.
#[derive(Default)]
pub(super) struct Lessons {
    pub kept: Vec<Kept>,
    /// Pedestrians that searches ended up with, each with its town and the seed of its episodes.
    pub walkers: Vec<(usize, Seed, Box<dyn WalkPolicy>)>,
}

/// What values of the keys lead to in all lessons.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub values: Vec<f64>,
    /// Starts that count, and those with a fault, natural traffic included.
    pub starts: u64,
    pub faults: u64,
    pub traffic: Traffic,
    /// How much the limits of progress and comfort are missed; 0 if they are kept.
    pub excess: f64,
    pub ticks: u64,
}

impl Candidate {
    /// What is minimised: the share of starts with a fault, above all others where a limit is missed.
    fn cost(&self) -> f64 {
        let share = self.faults as f64 / self.starts.max(1) as f64;
        if self.excess > 0.0 { 2.0 + self.excess } else { share }
    }

    /// Whether it is better than another: fewer faults within the limits, and if they are equal, faster.
    fn is_better_than(&self, other: &Self) -> bool {
        let speed = |candidate: &Self| candidate.traffic.speed().unwrap_or(0.0);
        let (own, others) = (self.cost(), other.cost());
        own < others || (own.total_cmp(&others).is_eq() && speed(self) > speed(other))
    }
}

/// The best of the candidates of a repair, the original, and how many there were and kept the limits.
pub(super) struct Repaired {
    pub best: Candidate,
    pub original: Candidate,
    pub candidates: u64,
    pub within: u64,
}

/// Searches the keys; `None` if it was stopped. `now` are the values before this repair.
pub(super) fn repair(
    plan: &Hardening,
    lessons: &mut Lessons,
    now: &[f64],
    seed: &Seed,
    ticks: &mut u64,
    stop: &dyn Fn() -> bool,
    progress: &dyn Fn(u64),
) -> Option<Repaired> {
    let natural = seed.child("natural");
    let mut try_out = |values: Vec<f64>, reference: Option<&Traffic>| -> Option<Candidate> {
        let candidate = meet(plan, lessons, values, &natural, reference, stop);
        if stop() {
            return None;
        }
        *ticks += candidate.ticks;
        progress(candidate.ticks);
        Some(candidate)
    };
    let original = try_out(plan.driver.before(), None)?;
    let reference = original.traffic;
    let mut best = original.clone();
    let (mut candidates, mut within) = (1, 1);
    let mut consider = |candidate: &Candidate| {
        candidates += 1;
        within += u64::from(candidate.excess == 0.0);
        if candidate.is_better_than(&best) {
            best = candidate.clone();
        }
    };
    if now != plan.driver.before() {
        consider(&try_out(now.to_vec(), Some(&reference))?);
    }
    let mut stream = seed.child("search").stream();
    let dimensions = plan.driver.keys.len();
    let spread = (plan.candidates / 2).max(1) as usize;
    let mut first = Vec::new();
    for point in latin_hypercube(spread, dimensions, &mut stream) {
        let candidate = try_out(plan.driver.values(&point), Some(&reference))?;
        consider(&candidate);
        first.push((candidate.cost(), point));
    }
    first.push((original.cost(), plan.driver.point(&original.values)));
    first.push((best_cost(&first), plan.driver.point(now)));
    // The local search starts at the best point of the first half.
    first.sort_by(|one, other| one.0.total_cmp(&other.0));
    let population = CmaEs::usual_population(dimensions).max(6);
    let mut search = CmaEs::new(first[0].1.clone(), FIRST_STEP, population);
    let mut left = (plan.candidates as usize).saturating_sub(spread);
    while left >= population {
        let points = search.ask(&mut stream);
        let mut costs = Vec::with_capacity(points.len());
        for point in &points {
            let candidate = try_out(plan.driver.values(point), Some(&reference))?;
            consider(&candidate);
            // A point outside the ranges is worth what its image is worth, and less the farther out it is.
            let outside: f64 = point.iter().map(|at| (at - at.clamp(0.0, 1.0)).abs()).sum();
            costs.push(candidate.cost() + outside);
        }
        search.tell(&points, &costs);
        left -= population;
    }
    Some(Repaired { best, original, candidates, within })
}

fn best_cost(all: &[(f64, Vec<f64>)]) -> f64 {
    // Also start from the current values, last.
    all.iter().map(|(cost, _)| *cost).fold(f64::INFINITY, f64::min) + 1e-9
}

/// Lets the driver with these values meet all lessons and natural traffic. Without a reference it is its own.
fn meet(
    plan: &Hardening,
    lessons: &mut Lessons,
    values: Vec<f64>,
    natural: &Seed,
    reference: Option<&Traffic>,
    stop: &dyn Fn() -> bool,
) -> Candidate {
    let scenarios: Vec<Arc<Scenario>> =
        plan.towns.iter().map(|(_, town)| plan.driver.scenario(town, &values)).collect();
    let mut all: Vec<Drive> = Vec::new();
    for kept in &lessons.kept {
        if stop() {
            break;
        }
        let scenario = &scenarios[kept.town];
        let met = walk_again(scenario, kept.seed, kept.start, &kept.commands);
        all.extend(met.map(|(outcome, trace)| Drive::new(scenario, &outcome, &trace)));
    }
    for (town, seed, walker) in &mut lessons.walkers {
        all.extend(drives(&scenarios[*town], walker.as_mut(), plan.lessons, seed, stop));
    }
    let mut traffic = Traffic::default();
    for ((name, _), scenario) in plan.towns.iter().zip(&scenarios) {
        let mut walker = plan.natural.walk_policy();
        let met = drives(scenario, walker.as_mut(), plan.traffic, &natural.child(name), stop);
        met.iter().for_each(|drive| traffic.add(drive));
        all.extend(met);
    }
    let excess = reference.map_or(0.0, |reference| plan.rule.excess(&traffic, reference));
    let counted = all.iter().filter(|drive| drive.counts);
    Candidate {
        values,
        starts: counted.clone().count() as u64,
        faults: counted.filter(|drive| drive.fault).count() as u64,
        traffic,
        excess,
        ticks: all.iter().map(|drive| drive.ticks).sum(),
    }
}
