use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::axis::{Axis, Usual};
use super::ground::note_towns;
use crate::RunId;
use crate::lowering::Lowering;
use crate::plan::{Campaign, ControllerKind, Evaluation, NO_REWARD, Training, TrainingKey};
use base::signature::{DeclarationId, Value};
use lang::diagnostics;
use lang::hir::Block;
use world::env::RewardRule;
use world::falsifier::Controller;

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
        let Some(chosen) = self.chosen(words) else { return };
        let controllers =
            if untrained { untrained_controllers(&chosen) } else { controllers(&chosen, &campaign.trainings) };
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
            let mut scenarios: BTreeMap<(&str, Option<DeclarationId>), _> = BTreeMap::new();
            for declared in std::iter::once(None).chain(chosen.iter().map(Chosen::declared).filter(Option::is_some)) {
                for (name, reward) in rewards {
                    let own = [Some(reward.id), declared].into_iter().flatten().collect::<Vec<_>>();
                    scenarios.insert((name, declared), scenario(&reward.value, &own));
                }
                if untrained {
                    let own: Vec<_> = declared.into_iter().collect();
                    scenarios.insert((NO_REWARD, declared), scenario(&RewardRule::default(), &own));
                }
            }
            let of = |controller: &ControllerKind, trained: &TrainingKey| {
                let declared = chosen.iter().find(|each| each.is(controller)).and_then(Chosen::declared);
                scenarios[&(trained.reward.as_str(), declared)].clone()
            };
            campaign.evaluations.extend(controllers.iter().map(|(controller, trained)| Evaluation {
                id: RunId::default(),
                controller: controller.clone(),
                trained: trained.clone(),
                town: place.town.name.clone(),
                policy: place.policy.name.clone(),
                vehicle: car.name.clone(),
                adversary: walker.name.clone(),
                block: number,
                scenario: of(controller, trained).0,
                episodes: block.arguments.integer("episodes") as u32,
                fingerprint: of(controller, trained).1,
                halfwidth: block.arguments.has("halfwidth").then(|| block.arguments.number("halfwidth")),
            }));
        }
    }
}

/// A member of the list of pedestrians.
enum Chosen {
    /// A built-in controller.
    Word(&'static str),
    Declared(DeclarationId, Controller),
}

impl Chosen {
    fn declared(&self) -> Option<DeclarationId> {
        match self {
            Self::Word(_) => None,
            Self::Declared(id, _) => Some(*id),
        }
    }

    /// Whether it is this declared controller.
    fn is(&self, controller: &ControllerKind) -> bool {
        matches!((self, controller), (Self::Declared(_, own), ControllerKind::Declared(other)) if own == other)
    }

    /// Its kind, if it depends on no training.
    fn untrained(&self) -> Option<ControllerKind> {
        Some(match self {
            Self::Word("random") => ControllerKind::Random,
            Self::Word("homing") => ControllerKind::Homing,
            Self::Word("intercept") => ControllerKind::Intercept,
            Self::Word("natural") => ControllerKind::Natural,
            Self::Word("scripted") => ControllerKind::Scripted,
            Self::Word(_) => return None,
            Self::Declared(_, controller) => ControllerKind::Declared(controller.clone()),
        })
    }
}

impl Lowering<'_> {
    /// The chosen controllers; none after reporting what is wrong with a declared one.
    fn chosen(&mut self, words: &[Value]) -> Option<Vec<Chosen>> {
        let each = |word: &Value| match word {
            Value::Choice(word) => Some(Chosen::Word(word)),
            Value::Reference(id) => self.controller(*id).map(|controller| Chosen::Declared(*id, controller)),
            other => panic!("checked: `pedestrians` holds {other:?}"),
        };
        words.iter().map(each).collect()
    }
}

/// The controllers of a campaign without training: each once, for no reward.
fn untrained_controllers(chosen: &[Chosen]) -> Vec<(ControllerKind, Arc<TrainingKey>)> {
    let reward = NO_REWARD.to_string();
    let key = Arc::new(TrainingKey { town: String::new(), policy: String::new(), reward, run: 0 });
    chosen.iter().filter_map(Chosen::untrained).map(|controller| (controller, key.clone())).collect()
}

/// The controllers of a campaign with trainings: every trained one, and for every run of a reward a random or natural one with draws of
/// its own.
/// The homing, the intercepting and the scripted controller draw nothing, so they are evaluated once for each reward; so is a declared one.
fn controllers(chosen: &[Chosen], trainings: &[Training]) -> Vec<(ControllerKind, Arc<TrainingKey>)> {
    let mut all = Vec::new();
    for each in chosen {
        let mut seen = BTreeSet::new();
        for (index, training) in trainings.iter().enumerate() {
            let controller = each.untrained().unwrap_or(match each {
                Chosen::Word("sampled") => ControllerKind::Sampled(index),
                _ => ControllerKind::Trained(index),
            });
            let mut key = training.key.clone();
            if !matches!(controller, ControllerKind::Trained(_) | ControllerKind::Sampled(_)) {
                key.town = String::new();
                key.policy = String::new();
                if !matches!(controller, ControllerKind::Random | ControllerKind::Natural) {
                    key.run = 0;
                }
            }
            let key = Arc::new(key);
            if seen.insert((controller.clone(), key.clone())) {
                all.push((controller, key));
            }
        }
    }
    all
}
