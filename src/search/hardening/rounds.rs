use serde::{Deserialize, Serialize};

use super::plan::Hardening;
use super::repair::{Kept, Lessons, Repaired, repair};
use super::tested::{Tested, faults, test};
use crate::{BudgetedSimulation, Failure, TrainError};
use base::seed::Seed;
use verdict::Traffic;

/// Most failures that a search leaves for repairs, each from another start, evenly from all of them.
const MAX_KEPT: usize = 60;

/// A round of attack and repair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Starts that its searches tried, and those with a fault of the driver as it was then.
    pub attacked: u64,
    pub faulty: u64,
    /// Failures and pedestrians that were kept up to then.
    pub kept: u64,
    pub walkers: u64,
    /// Values that were tried out, and those within the limits.
    pub candidates: u64,
    pub within: u64,
    /// Starts with a fault of the original driver and of the repaired one, in all that was kept and in natural traffic.
    pub starts: u64,
    pub faults_before: u64,
    pub faults_after: u64,
    /// The values of the keys from then on, in SI.
    pub values: Vec<f64>,
}

/// A driver before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hardened {
    pub rounds: Vec<Round>,
    /// The values of the keys at the end, in SI.
    pub values: Vec<f64>,
    pub tests: Vec<Tested>,
    /// Natural traffic in the towns of the test, before and after.
    pub traffic: [Traffic; 2],
    /// Simulator ticks of all episodes but those of the test.
    pub ticks: u64,
}

/// Hardens a driver; `None` if `stop` was true before the end. `progress` gets the ticks.
///
/// All that is drawn depends on the seed alone, so different drivers meet the same starts.
///
/// # Errors
/// A falsifier whose training fails.
pub fn harden(
    plan: &Hardening,
    seed: &Seed,
    stop: &(dyn Fn() -> bool + Sync),
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Option<Hardened>, TrainError> {
    let mut lessons = Lessons::default();
    let mut now = plan.driver.before();
    let (mut rounds, mut ticks) = (Vec::new(), 0);
    for number in 0..plan.rounds {
        let seed = seed.child("round").index(number.into());
        let [mut attacked, mut faulty] = [0, 0];
        for (name, falsifier, scenarios) in &plan.attacks {
            for (place, scenario) in scenarios.iter().enumerate() {
                let town = &plan.towns[place].0;
                let scenario = plan.driver.scenario(scenario, &now);
                let starts = seed.child("starts").child(town);
                let drawn = seed.child("attack").child(town).child(name);
                let mut simulator =
                    BudgetedSimulation::new(scenario.clone(), starts, plan.budget, stop).with_progress(progress);
                let walker = falsifier.search(&mut simulator, &drawn)?;
                let spent = simulator.into_spent();
                if spent.stopped {
                    return Ok(None);
                }
                ticks += spent.ticks;
                let faults = faults(&scenario, starts, &spent.failures);
                attacked += spent.starts.count();
                faulty += faults.len() as u64;
                lessons.kept.extend(evenly(faults).map(|failure| Kept {
                    town: place,
                    seed: starts,
                    start: failure.start,
                    commands: failure.commands.clone(),
                }));
                lessons.walkers.extend(walker.map(|walker| (place, drawn.child("lessons"), walker)));
            }
        }
        let Some(repaired) = repair(plan, &mut lessons, &now, &seed.child("repair"), &mut ticks, stop, progress) else {
            return Ok(None);
        };
        let Repaired { best, original, candidates, within } = repaired;
        now.clone_from(&best.values);
        rounds.push(Round {
            attacked,
            faulty,
            kept: lessons.kept.len() as u64,
            walkers: lessons.walkers.len() as u64,
            candidates,
            within,
            starts: original.starts,
            faults_before: original.faults,
            faults_after: best.faults,
            values: best.values,
        });
    }
    let Some((tests, traffic)) = test(plan, &now, &seed.child("test"), stop)? else { return Ok(None) };
    Ok(Some(Hardened { rounds, values: now, tests, traffic, ticks }))
}

fn evenly(all: Vec<&Failure>) -> impl Iterator<Item = &Failure> {
    let (count, kept) = (all.len(), all.len().min(MAX_KEPT));
    (0..kept).map(move |place| all[place * count / kept])
}
