use std::sync::Arc;

use super::Estimation;
use crate::Job;
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Grid, Nested, of_places};
use crate::jobs::JobBlock;
use crate::lowering::Lowering;
use base::keys;
use base::signature::{DeclarationId, Keys, Value};
use episode::{Criterion, RewardRule};
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

pub(crate) const BLOCK: JobBlock =
    JobBlock { signature: EstimateKeys::signature, drivers: of_places, lower: |it, at, grid| it.estimate(at, grid) };

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
