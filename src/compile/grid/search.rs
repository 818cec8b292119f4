use std::sync::Arc;

use super::axis::{Axis, Usual};
use super::ground::note_towns;
use crate::campaign::SearchKeys;
use crate::lowering::Lowering;
use crate::{Campaign, Job, RunId, Search, SearchKey, falsifier};
use base::signature::DeclarationId;
use lang::diagnostics;
use lang::hir::Block;
use learn::PpoConfig;
use world::env::{Criterion, PedestrianRole, RewardRule, Scenario};
use world::falsifier::Falsifier;
use world::requirement::NamedRequirement;

/// A falsifier of a `search` block.
pub(super) struct Rival {
    pub name: String,
    method: &'static str,
    pub reward: (String, RewardRule),
    /// It, and the training of its pedestrians if it does not name one itself.
    pub declarations: Vec<DeclarationId>,
    pub falsifier: Arc<dyn Falsifier>,
}

/// The requirement of the library that every search has for its goal where no other is stated.
const COLLISION: &str = "no_collision";

/// The goal of a `search` block.
struct SearchGoal {
    /// The requirements of the campaign, and the goal if it is none of them.
    requirements: Arc<[NamedRequirement]>,
    criterion: Criterion,
    /// The declaration of the goal, for the fingerprint: once after the requirements of the campaign, and once more if it is none of them.
    declared: Vec<DeclarationId>,
}

impl Lowering<'_> {
    pub(super) fn search(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        number: u32,
        usual: &Usual,
        campaign: &mut Campaign,
    ) {
        let keys: SearchKeys = block.keys();
        let own = keys.adversary.map(|id| self.adversary(id));
        let adversary = own.as_ref().unwrap_or(&usual.walker);
        let (car, walker) = (&usual.car.value, &adversary.value);
        let bodies = [(&usual.car, adversary)];
        let Some(ground) = self.ground(campaign_block, block, &keys.places, &keys.start, &bodies) else { return };
        let falsifiers = self.falsifiers(campaign_block, &keys.falsifiers, &adversary.value, usual.training.as_ref());
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), falsifiers.len(), keys.runs as usize]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        if keys.budget < u64::from(usual.rule.value.ticks) {
            self.said.push(diagnostics::small_budget(block.place("budget"), keys.budget, usual.rule.value.ticks));
        }
        let goal = self.goal(block, keys.goal, usual);
        for (place, rival) in ground.places().flat_map(|place| falsifiers.iter().map(move |rival| (place, rival))) {
            let scenario = place.scenario(car, walker, &usual.rule.value, &rival.reward.1, &goal.requirements);
            let scenario = match goal.criterion {
                Criterion::Collision => scenario,
                criterion => Arc::new(Scenario { criterion, ..Scenario::clone(&scenario) }),
            };
            let ground = place.declarations(&usual.car, adversary, &usual.rule);
            let parts = [ground.as_slice(), &usual.requirements.ids, &goal.declared, &rival.declarations].concat();
            let (fingerprint, programs) = (self.fingerprint(&parts), self.programs(&parts));
            campaign.jobs.extend((0..keys.runs).map(|run| {
                Job::from(Search {
                    key: SearchKey {
                        id: RunId::default(),
                        falsifier: rival.name.clone(),
                        method: rival.method,
                        reward: rival.reward.0.clone(),
                        town: place.town.name.to_string(),
                        policy: place.policy.name.to_string(),
                        block: number,
                        run,
                    },
                    scenario: scenario.clone(),
                    falsifier: rival.falsifier.clone(),
                    budget: keys.budget,
                    tries: keys.episodes,
                    fingerprint,
                    programs: programs.clone(),
                })
            }));
        }
    }

    fn goal(&mut self, block: &Block, goal: Option<DeclarationId>, usual: &Usual) -> SearchGoal {
        let own = &usual.requirements;
        let Some(id) = goal else {
            if let Some(other) = own.all.iter().find(|each| &*each.name != COLLISION) {
                self.said.push(diagnostics::goalless_search(block.head, &other.name));
            }
            return SearchGoal { requirements: own.all.clone(), criterion: Criterion::Collision, declared: Vec::new() };
        };
        let known = own.ids.iter().position(|other| *other == id);
        let mut requirements = own.all.to_vec();
        let place = known.unwrap_or_else(|| {
            requirements.extend(self.requirements(block, "goal", &[id], &usual.rule.value));
            requirements.len() - 1
        });
        SearchGoal {
            requirements: requirements.into(),
            criterion: Criterion::Violation(place),
            declared: vec![id; 1 + usize::from(known.is_none())],
        }
    }

    pub(super) fn falsifiers(
        &mut self,
        campaign: &Block,
        ids: &[DeclarationId],
        walker: &PedestrianRole,
        usual: Option<&Axis<(PpoConfig, usize)>>,
    ) -> Vec<Rival> {
        let mut rivals = Vec::new();
        for id in ids {
            let declaration = self.program.get(*id);
            let arguments = &declaration.block.arguments;
            let training = match falsifier::named(arguments, "training") {
                Some(id) => Some(self.training(id, walker.observation.dim())),
                // Its first networks were checked for the campaign's pedestrian, who may have other states.
                None => usual.map(|axis| match &axis.value.0.initial {
                    Some(first) if first.obs_dim() != walker.observation.dim() * axis.value.0.frame_stack => {
                        self.training(axis.id, walker.observation.dim())
                    }
                    _ => axis.clone(),
                }),
            };
            if training.is_none() && falsifier::learns(&self.catalog.falsifiers, declaration) {
                self.said.push(diagnostics::no_training(campaign.head, declaration.block.head));
                continue;
            }
            let controller = falsifier::named(arguments, "controller");
            let named = falsifier::Named {
                training: training.as_ref().map(|training| training.value.clone()),
                controller: controller.and_then(|id| self.controller(id)),
            };
            if controller.is_some() && named.controller.is_none() {
                continue;
            }
            let reward = falsifier::named(arguments, "reward").map(|id| self.reward(id));
            rivals.push(Rival {
                name: declaration.name.clone(),
                method: declaration.kind,
                reward: reward.map(|reward| (reward.name.to_string(), reward.value)).unwrap_or_default(),
                declarations: [Some(*id), training.as_ref().map(|training| training.id)]
                    .into_iter()
                    .flatten()
                    .collect(),
                falsifier: falsifier::lower(&self.catalog.falsifiers, declaration, &named, self.said),
            });
        }
        rivals
    }
}
