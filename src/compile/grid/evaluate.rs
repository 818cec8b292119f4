use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::axis::{Axis, Usual};
use super::ground::note_towns;
use crate::compile::RunId;
use crate::compile::lowering::Lowering;
use crate::compile::plan::{Campaign, ControllerKind, Evaluation, Training, TrainingKey};
use crate::env::RewardRule;
use crate::lang::diagnostics;
use crate::lang::hir::Block;
use crate::signature::{DeclarationId, Value};

/// Used in place of a reward's name if no pedestrian is trained for one.
const NO_REWARD: &str = "none";

impl Lowering<'_> {
    pub(super) fn evaluate(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        number: u32,
        usual: &Usual,
        campaign: &mut Campaign,
        rewards: &BTreeMap<String, Axis<RewardRule>>,
    ) {
        let named = |key: &str| block.arguments.has(key).then(|| block.arguments.references(key));
        let cars = named("vehicles").map(|ids| ids.into_iter().map(|id| self.vehicle(id)).collect());
        let walkers = named("adversaries").map(|ids| ids.into_iter().map(|id| self.adversary(id)).collect());
        let cars: Vec<_> = cars.unwrap_or_else(|| vec![usual.car.clone()]);
        let walkers: Vec<_> = walkers.unwrap_or_else(|| vec![usual.walker.clone()]);
        let bodies = || cars.iter().flat_map(|car| walkers.iter().map(move |walker| (car, walker)));
        let all: Vec<_> = bodies().collect();
        let Some(ground) = self.ground(campaign_block, block, &all) else { return };
        let words = block.arguments.list("pedestrians");
        let scripted = words.iter().any(|word| matches!(word, Value::Choice("scripted")));
        if scripted && ground.spawn.value.scripted().is_none() {
            let message = "a `scripted` pedestrian walks as a test or a path states, and the spawn rule of this block is no test and has no path";
            let help = "use a `spawn` of kind `crossing_test`, `along_test` or `given_path`";
            return self.said.push(diagnostics::contradiction(block.place("pedestrians"), message.into()).help(help));
        }
        let untrained = campaign_block.nested("train").next().is_none();
        if untrained && words.iter().any(|word| matches!(word, Value::Choice("trained" | "sampled"))) {
            return self.said.push(diagnostics::trained_without_training(block.place("pedestrians")));
        }
        let controllers =
            if untrained { untrained_controllers(words) } else { controllers(words, &campaign.trainings) };
        let each = controllers.len().max(rewards.len());
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), all.len(), each]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        for (place, (car, walker)) in ground.places().flat_map(|place| bodies().map(move |body| (place, body))) {
            let ground = place.declarations(car, walker, &usual.rule);
            let mut scenario = |rule: &RewardRule, declared: &[DeclarationId]| {
                let scenario = place.scenario(&car.value, &walker.value, &usual.rule.value, rule);
                (scenario, self.fingerprint(&[ground.as_slice(), declared].concat()))
            };
            let mut scenarios: BTreeMap<&str, _> = BTreeMap::new();
            for (name, reward) in rewards {
                scenarios.insert(name, scenario(&reward.value, &[reward.id]));
            }
            if untrained {
                scenarios.insert(NO_REWARD, scenario(&RewardRule::default(), &[]));
            }
            campaign.evaluations.extend(controllers.iter().map(|(controller, trained)| Evaluation {
                id: RunId::default(),
                controller: *controller,
                trained: trained.clone(),
                town: place.town.name.clone(),
                policy: place.policy.name.clone(),
                vehicle: car.name.clone(),
                adversary: walker.name.clone(),
                block: number,
                scenario: scenarios[trained.reward.as_str()].0.clone(),
                episodes: block.arguments.integer("episodes") as u32,
                fingerprint: scenarios[trained.reward.as_str()].1,
                halfwidth: block.arguments.has("halfwidth").then(|| block.arguments.number("halfwidth")),
            }));
        }
    }
}

/// The controllers of a campaign without training: each once, for no reward.
fn untrained_controllers(words: &[Value]) -> Vec<(ControllerKind, Arc<TrainingKey>)> {
    let reward = NO_REWARD.to_string();
    let key = Arc::new(TrainingKey { town: String::new(), policy: String::new(), reward, run: 0 });
    let untrained = |word: &Value| match word {
        Value::Choice("random") => Some(ControllerKind::Random),
        Value::Choice("homing") => Some(ControllerKind::Homing),
        Value::Choice("intercept") => Some(ControllerKind::Intercept),
        Value::Choice("scripted") => Some(ControllerKind::Scripted),
        _ => None,
    };
    words.iter().filter_map(untrained).map(|controller| (controller, key.clone())).collect()
}

/// The controllers of a campaign with trainings: every trained one, and for every run of a reward a random one with draws of its own.
/// The homing and the intercepting controller draw nothing, so they are evaluated once for each reward.
fn controllers(words: &[Value], trainings: &[Training]) -> Vec<(ControllerKind, Arc<TrainingKey>)> {
    let mut all = Vec::new();
    for word in words {
        let Value::Choice(word) = word else { panic!("checked: a choice") };
        let mut seen = BTreeSet::new();
        for (index, training) in trainings.iter().enumerate() {
            let controller = match *word {
                "random" => ControllerKind::Random,
                "homing" => ControllerKind::Homing,
                "intercept" => ControllerKind::Intercept,
                "scripted" => ControllerKind::Scripted,
                "sampled" => ControllerKind::Sampled(index),
                _ => ControllerKind::Trained(index),
            };
            let mut key = training.key.clone();
            let drawless =
                matches!(controller, ControllerKind::Homing | ControllerKind::Intercept | ControllerKind::Scripted);
            if drawless || controller == ControllerKind::Random {
                key.town = String::new();
                key.policy = String::new();
            }
            if drawless {
                key.run = 0;
            }
            let key = Arc::new(key);
            if seen.insert((controller, key.clone())) {
                all.push((controller, key));
            }
        }
    }
    all
}
