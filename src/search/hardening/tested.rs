use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::plan::Hardening;
use crate::{BudgetedSimulation, Failure, Falsifier, SearchOutcome, TrainError};
use base::seed::Seed;
use episode::{Criterion, Outcome, Scenario, Trace, follow};
use verdict::{Blame, Drive, Judged, Traffic, drives};

/// The driver before and after at the same starts, which no round has used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tested {
    pub town: String,
    /// Name of the pedestrian or of the falsifier.
    pub attacker: String,
    /// Whether it is a falsifier, which adapts to the driver.
    pub searches: bool,
    /// Starts that count for both.
    pub starts: u64,
    /// Of these with a fault before, and after.
    pub before: u64,
    pub after: u64,
    /// Of these with a fault after and none before.
    pub new: u64,
    /// Episodes in which a program failed.
    pub errors: u64,
}

/// The tests, and natural traffic before and after.
pub(super) type Findings = (Vec<Tested>, [Traffic; 2]);

/// Tests a driver with these values beside the driver as it was; `None` if it was stopped.
pub(super) fn test(
    plan: &Hardening,
    values: &[f64],
    seed: &Seed,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Findings>, TrainError> {
    let sides = [plan.driver.before(), values.to_vec()];
    let both = |scenario: &Arc<Scenario>| sides.each_ref().map(|values| plan.driver.scenario(scenario, values));
    let (mut tests, mut traffic) = (Vec::new(), [Traffic::default(); 2]);
    for (place, (town, scenario)) in plan.test_towns.iter().enumerate() {
        let natural = seed.child("natural").child(town);
        for (scenario, traffic) in both(scenario).iter().zip(&mut traffic) {
            let mut walker = plan.natural.walk_policy();
            let met = drives(scenario, walker.as_mut(), plan.episodes, &natural, stop);
            met.iter().for_each(|drive| traffic.add(drive));
        }
        for controller in &plan.walkers {
            let seed = seed.child("walkers").child(town).child(controller.name());
            let [before, after] = both(scenario)
                .map(|scenario| drives(&scenario, controller.walk_policy().as_mut(), plan.episodes, &seed, stop));
            tests.push(pairs(town, controller.name(), &before, &after));
        }
        for (name, falsifier, scenarios) in &plan.rivals {
            let seed = seed.child("rivals").child(town);
            let [before, after] = both(&scenarios[place])
                .map(|scenario| searched(&scenario, falsifier.as_ref(), plan.budget, &seed, name, stop));
            let ((one, faults_before), (other, faults_after)) = (before?, after?);
            let common = one.starts.common(&other.starts);
            let within = |faults: &BTreeSet<u64>| faults.iter().filter(|start| common.contains(**start)).count() as u64;
            let new = faults_after.difference(&faults_before).filter(|start| common.contains(**start)).count();
            tests.push(Tested {
                town: town.clone(),
                attacker: name.clone(),
                searches: true,
                starts: common.count(),
                before: within(&faults_before),
                after: within(&faults_after),
                new: new as u64,
                errors: 0,
            });
        }
        if stop() {
            return Ok(None);
        }
    }
    Ok(Some((tests, traffic)))
}

/// A search, and its starts with a fault.
fn searched(
    scenario: &Arc<Scenario>,
    falsifier: &dyn Falsifier,
    budget: u64,
    seed: &Seed,
    name: &str,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<(SearchOutcome, BTreeSet<u64>), TrainError> {
    let starts = seed.child("starts");
    let mut simulator = BudgetedSimulation::new(scenario.clone(), starts, budget, stop);
    falsifier.search(&mut simulator, &seed.child(name))?;
    let spent = simulator.into_spent();
    let found = faults(scenario, starts, &spent.failures).into_iter().map(|failure| failure.start).collect();
    Ok((spent, found))
}

fn pairs(town: &str, attacker: &str, before: &[Drive], after: &[Drive]) -> Tested {
    let both: Vec<_> = before.iter().zip(after).filter(|(one, other)| one.counts && other.counts).collect();
    let count =
        |chosen: fn(&Drive, &Drive) -> bool| both.iter().filter(|(one, other)| chosen(one, other)).count() as u64;
    Tested {
        town: town.into(),
        attacker: attacker.into(),
        searches: false,
        starts: both.len() as u64,
        before: count(|one, _| one.fault),
        after: count(|_, other| other.fault),
        new: count(|one, other| other.fault && !one.fault),
        errors: before.iter().chain(after).filter(|drive| drive.error).count() as u64,
    }
}

/// The first fault of each start.
pub(super) fn faults<'a>(scenario: &Arc<Scenario>, seed: Seed, failures: &'a [Failure]) -> Vec<&'a Failure> {
    let mut found: BTreeMap<u64, &Failure> = BTreeMap::new();
    for failure in failures.iter().filter(|failure| failure.outcome.is_collision()) {
        if found.contains_key(&failure.start) {
            continue;
        }
        let met = follow(scenario, seed, failure.start, &failure.commands);
        let is_fault = |(outcome, trace): (Outcome, Trace)| {
            Judged::by(Criterion::Collision, &outcome, &trace.main_pair(scenario))
                .is(Criterion::Collision, Blame::Fault)
        };
        if met.is_some_and(is_fault) {
            found.insert(failure.start, failure);
        }
    }
    found.into_values().collect()
}
