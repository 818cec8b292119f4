use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, Usual};
use super::ground::note_towns;
use crate::compile::lowering::Lowering;
use crate::compile::plan::{Campaign, Training, TrainingKey};
use crate::env::RewardRule;
use crate::lang::diagnostics;
use crate::lang::hir::Block;

impl Lowering<'_> {
    /// The trainings of a `train` block; its rewards are recorded for the controllers that are evaluated later.
    pub(super) fn train(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        usual: &Usual,
        campaign: &mut Campaign,
        rewards: &mut BTreeMap<String, Axis<RewardRule>>,
    ) {
        let (car, walker) = (&usual.car.value, &usual.walker.value);
        let Some(training) = &usual.training else {
            return self.said.push(diagnostics::no_training(campaign_block.head, block.head));
        };
        let Some(ground) = self.ground(campaign_block, block, &[(&usual.car, &usual.walker)]) else { return };
        let (paid, runs) = (self.rewards(block), block.arguments.integer("runs") as u32);
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), paid.len(), runs as usize]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        let (config, environments) = &training.value;
        for place in ground.places() {
            for reward in &paid {
                let scenario = place.scenario(car, walker, &usual.rule.value, &reward.value);
                let ground = place.declarations(&usual.car, &usual.walker, &usual.rule);
                let fingerprint = self.fingerprint(&[ground.as_slice(), &[reward.id, training.id]].concat());
                let lineage = (!config.depends_on_total_steps())
                    .then(|| self.lineage(&[ground.as_slice(), &[reward.id]].concat(), training.id));
                campaign.trainings.extend((0..runs).map(|run| Training {
                    key: TrainingKey {
                        town: place.town.name.to_string(),
                        policy: place.policy.name.to_string(),
                        reward: reward.name.to_string(),
                        run,
                    },
                    scenario: scenario.clone(),
                    config: config.clone(),
                    environments: *environments,
                    fingerprint,
                    lineage,
                }));
            }
        }
        rewards.extend(paid.into_iter().map(|reward| (reward.name.to_string(), reward)));
    }

    pub(super) fn forbid_repeated_trainings(&mut self, block: &Block, campaign: &Campaign) {
        let mut seen = BTreeSet::new();
        for training in &campaign.trainings {
            if !seen.insert(&training.key) {
                let TrainingKey { town, policy, reward, run } = &training.key;
                let message = format!("{town} × {policy} × {reward}, run {run}, is trained twice");
                self.said.push(diagnostics::contradiction(block.head, message));
                return;
            }
        }
    }
}
