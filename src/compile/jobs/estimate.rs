use std::sync::Arc;

use super::{JobBlock, Origin, Planned};
use crate::Job;
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Grid, Nested, of_places};
use crate::lowering::Lowering;
use base::keys;
use base::seed::Seed;
use base::signature::{DeclarationId, Keys, Value};
use episode::walker::Controller;
use episode::{Criterion, RewardRule, Scenario};
use verdict::Blame;

keys! {
    /// Estimates how likely failures are in an encounter with a pedestrian that walks as people do.
    pub struct EstimateKeys = "estimate" {
        ..places: PlaceKeys,
        /// Who walks, each by itself: pedestrians that learn nothing, such as `natural`, or a `pedestrian` of the file. The probability is that of an encounter with
        /// this pedestrian, from a start that the `spawn` draws.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "pedestrian") = "[natural]",
        /// The requirement whose violations are estimated, instead of collisions.
        requirement: Option<DeclarationId> as Reference("requirement"),
        /// What the `relative_error` is about: any failure, one that a careful human would have avoided, or a fault. All three are estimated.
        event: Blame = "fault",
        /// Standard error, as a share of the probability, at which it ends.
        relative_error: f64 as within(RATIO, 0.001, 1.0) = "0.1",
        /// Simulator ticks after which it ends; a batch that has begun is finished.
        budget: u64 as ticks(1, 1_000_000_000_000) = "20_000_000",
        /// Estimates of each, with different seeds.
        runs: u32 as whole(1, 10_000) = "1",
        /// Encounters per hour of driving, if you know them: then failures per hour are stated.
        encounters_per_hour: Option<f64> as within(RATIO, 0.0, 1_000_000.0),
        /// Encounters per 1,000 km, if you know them: then failures per 1,000 km are stated.
        encounters_per_1000_km: Option<f64> as within(RATIO, 0.0, 1_000_000_000.0),
        /// Body, instead of the campaign's.
        body: Option<DeclarationId> as Reference("body"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns in which they meet.")
    .explained("drivers", "Drivers whose failures are estimated.")
}

pub(super) const BLOCK: JobBlock =
    JobBlock { signature: EstimateKeys::signature, drivers: of_places, lower: |it, at, grid| it.estimate(at, grid) };

/// An estimate of how likely failures of a driver are in a town.
#[derive(Debug, Clone)]
pub struct Estimation {
    pub origin: Origin,
    pub pedestrian: String,
    /// The requirement whose violations are estimated; empty for collisions.
    pub requirement: String,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    pub scenario: Arc<Scenario>,
    /// The pedestrian.
    pub walker: Controller,
    pub criterion: Criterion,
    /// What the relative error is about.
    pub event: Blame,
    pub relative_error: f64,
    /// The number of simulator ticks after which it ends.
    pub budget: u64,
    /// Encounters per hour and per 1,000 km, as far as the user states them.
    pub exposure: [Option<f64>; 2],
}

impl Estimation {
    /// The seed of what it draws. Equal pedestrians have equal starts against all drivers.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        let place = seed.child("estimate").child(&self.town).child(&self.pedestrian);
        place.child("monte_carlo").index(self.origin.block.into()).index(self.origin.run.into())
    }
}

impl Planned for Estimation {
    /// `natural in harbour against idm, run 0`.
    fn title(&self) -> String {
        let Self { pedestrian, town, policy, origin, .. } = self;
        format!("{pedestrian} in {town} against {policy}, run {}", origin.run)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.town, &self.scenario)]
    }

    fn units(&self, _: u32) -> u64 {
        self.budget
    }

    fn inputs(&self) -> String {
        format!("{:?} {} {:?}", self.names(&[]), self.event.name(), self.relative_error)
    }

    fn shorten(&mut self) {
        self.budget = self.budget.min(10 * self.scenario.longest());
    }

    fn names(&self, _: &[Job]) -> Vec<String> {
        let Self { origin, pedestrian, requirement, town, policy, budget, .. } = self;
        let Origin { block, run, fingerprint, .. } = origin;
        let all: [&dyn ToString; 9] =
            [&"estimate", block, pedestrian, requirement, town, policy, run, fingerprint, budget];
        all.map(ToString::to_string).into()
    }
}

impl Lowering<'_> {
    fn estimate(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let keys: EstimateKeys = at.block.keys();
        let Some((ground, body)) = self.setting(at, &keys.places, &keys.start, keys.body, grid) else { return };
        let walkers: Option<Vec<_>> =
            keys.pedestrians.iter().map(|word| self.untrained(at.block, "pedestrians", word, true)).collect();
        let Some(walkers) = walkers else { return };
        if !self.takes(at, &ground, [walkers.len(), keys.runs as usize], grid) {
            return;
        }
        let Grid { usual, campaign, .. } = grid;
        let (requirements, criterion, asked) = match keys.requirement {
            None => (usual.requirements.all.clone(), Criterion::Collision, Vec::new()),
            Some(id) => {
                let all: Arc<[_]> = self.requirements(at.block, "requirement", &[id], &usual.rule.value).into();
                (all, Criterion::Violation(0), vec![id])
            }
        };
        let requirement =
            asked.first().map(|id: &DeclarationId| self.program.get(*id).name.clone()).unwrap_or_default();
        for place in ground.places() {
            for (walker, declared) in &walkers {
                let walked: Vec<DeclarationId> = declared.iter().copied().collect();
                let parts = [&usual.declarations(&place, &body)[..], &usual.requirements.ids, &asked, &walked].concat();
                let scenario = usual.scenario(&place, &body, &RewardRule::default(), &requirements);
                campaign.jobs.extend(self.origins(at, keys.runs, &parts).map(|origin| {
                    Job::from(Estimation {
                        origin,
                        pedestrian: walker.name().to_string(),
                        requirement: requirement.clone(),
                        town: place.town.name.to_string(),
                        policy: place.policy.name.to_string(),
                        scenario: scenario.clone(),
                        walker: walker.clone(),
                        criterion,
                        event: keys.event,
                        relative_error: keys.relative_error,
                        budget: keys.budget,
                        exposure: [keys.encounters_per_hour, keys.encounters_per_1000_km],
                    })
                }));
            }
        }
    }
}
