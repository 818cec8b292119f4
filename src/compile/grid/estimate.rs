use std::sync::Arc;

use super::axis::Usual;
use super::ground::note_towns;
use crate::campaign::EstimateKeys;
use crate::lowering::Lowering;
use crate::{Campaign, Estimation, EstimationKey, Job, RunId};
use base::signature::{DeclarationId, Value};
use lang::hir::Block;
use world::env::{Criterion, RewardRule};
use world::falsifier::Controller;

impl Lowering<'_> {
    pub(super) fn estimate(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        number: u32,
        usual: &Usual,
        campaign: &mut Campaign,
    ) {
        let keys: EstimateKeys = block.keys();
        let own = keys.adversary.map(|id| self.adversary(id));
        let adversary = own.as_ref().unwrap_or(&usual.walker);
        let (car, body) = (&usual.car.value, &adversary.value);
        let bodies = [(&usual.car, adversary)];
        let Some(ground) = self.ground(campaign_block, block, &keys.places, &keys.start, &bodies) else { return };
        let walkers: Option<Vec<_>> = keys.pedestrians.iter().map(|word| self.walker(word)).collect();
        let Some(walkers) = walkers else { return };
        let axes = [ground.towns.len(), ground.policies.len(), walkers.len(), keys.runs as usize];
        if !self.fits(block, axes) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        let (requirements, criterion, asked) = match keys.requirement {
            None => (usual.requirements.all.clone(), Criterion::Collision, Vec::new()),
            Some(id) => {
                let all: Arc<[_]> = self.requirements(block, "requirement", &[id], &usual.rule.value).into();
                (all, Criterion::Violation(0), vec![id])
            }
        };
        let requirement =
            asked.first().map(|id: &DeclarationId| self.program.get(*id).name.clone()).unwrap_or_default();
        for place in ground.places() {
            for walker in &walkers {
                let ground = place.declarations(&usual.car, adversary, &usual.rule);
                let walked: Vec<DeclarationId> = walker.1.into_iter().collect();
                let parts = [ground.as_slice(), &usual.requirements.ids, &asked, &walked].concat();
                let (fingerprint, programs) = (self.fingerprint(&parts), self.programs(&parts));
                let scenario = place.scenario(car, body, &usual.rule.value, &RewardRule::default(), &requirements);
                campaign.jobs.extend((0..keys.runs).map(|run| {
                    Job::from(Estimation {
                        key: EstimationKey {
                            id: RunId::default(),
                            walker: walker.0.name().to_string(),
                            requirement: requirement.clone(),
                            town: place.town.name.to_string(),
                            policy: place.policy.name.to_string(),
                            block: number,
                            run,
                        },
                        scenario: scenario.clone(),
                        walker: walker.0.clone(),
                        criterion,
                        event: keys.event,
                        relative_error: keys.relative_error,
                        budget: keys.budget,
                        exposure: [keys.encounters_per_hour, keys.encounters_per_1000_km],
                        fingerprint,
                        programs: programs.clone(),
                    })
                }));
            }
        }
    }

    /// A pedestrian that learns nothing, and its declaration; none after reporting what is wrong with it.
    fn walker(&mut self, word: &Value) -> Option<(Controller, Option<DeclarationId>)> {
        if let Value::Reference(id) = word {
            return Some((self.controller(*id)?, Some(*id)));
        }
        let found = self.catalog.walkers.iter().find(|kind| *word == Value::Choice(kind.word()));
        Some((found.expect("checked: the word is in the catalogue").controller.clone(), None))
    }
}
