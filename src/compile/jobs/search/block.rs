use std::sync::Arc;

use super::{Search, SearchKey};
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Axis, Grid, Nested, Usual, of_places};
use crate::jobs::JobBlock;
use crate::lowering::Lowering;
use crate::{Job, falsifier};
use base::keys;
use base::signature::{DeclarationId, Keys};
use episode::requirement::NamedRequirement;
use episode::{Criterion, PedestrianRole, RewardRule, Scenario};
use lang::diagnostics;
use lang::hir::Block;
use learn::{Credit, Policies};
use search::Falsifier;

keys! {
    /// Searches for failures by several methods, each with the same budget and the same starts.
    pub struct SearchKeys = "search" {
        ..places: PlaceKeys,
        /// Who searches.
        methods: Vec<DeclarationId> as Reference("method"),
        /// Simulator ticks that each may use.
        budget: u64 as ticks(1, 1_000_000_000_000) = "1_000_000",
        /// The requirement that the searches try to violate, instead of a collision. It takes the place of their rewards: an episode earns more the
        /// less robust it is, and more than 1 for a violation.
        goal: Option<DeclarationId> as Reference("requirement"),
        /// Searches of each, with different seeds and starts.
        runs: u32 as whole(1, 10_000) = "10",
        /// Episodes in which the pedestrian that a search returns is evaluated afterwards, outside the budget.
        episodes: u32 as whole(0, 1_000_000) = "200",
        /// Body, instead of the campaign's.
        body: Option<DeclarationId> as Reference("body"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns to search in.")
    .explained("drivers", "Drivers to find failures of.")
}

pub(crate) const BLOCK: JobBlock =
    JobBlock { signature: SearchKeys::signature, drivers: of_places, lower: |it, at, grid| it.search(at, grid) };

/// A falsifier of a `search` block.
pub(crate) struct Rival {
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
    fn search(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let keys: SearchKeys = at.block.keys();
        let Some((ground, body)) = self.setting(at, &keys.places, &keys.start, keys.body, grid) else { return };
        if !self.walks_test(at, &ground, &[(&grid.usual.car, &body)], false, grid.usual.rule.value.tick) {
            return;
        }
        let falsifiers = self.falsifiers(at, &keys.methods, &body, &grid.usual);
        if !self.takes(at, &ground, [falsifiers.len(), keys.runs as usize], grid) {
            return;
        }
        let Grid { usual, campaign, .. } = grid;
        if keys.budget < u64::from(usual.rule.value.ticks) {
            self.said.push(diagnostics::small_budget(at.block.place("budget"), keys.budget, usual.rule.value.ticks));
        }
        let goal = self.goal(at.block, keys.goal, usual);
        for (place, rival) in ground.places().flat_map(|place| falsifiers.iter().map(move |rival| (place, rival))) {
            let scenario = usual.scenario(&place, &body, &rival.reward.1, &goal.requirements);
            let scenario = match goal.criterion {
                Criterion::Collision => scenario,
                criterion => Arc::new(Scenario { criterion, ..Scenario::clone(&scenario) }),
            };
            let ground = usual.declarations(&place, &body);
            let parts = [&ground[..], &usual.requirements.ids, &goal.declared, &rival.declarations].concat();
            campaign.jobs.extend(self.origins(at, keys.runs, &parts).map(|origin| {
                Job::from(Search {
                    key: SearchKey {
                        falsifier: rival.name.clone(),
                        method: rival.method,
                        reward: rival.reward.0.clone(),
                        town: place.town.name.to_string(),
                        policy: place.policy.name.to_string(),
                        block: origin.block,
                        run: origin.run,
                    },
                    origin,
                    scenario: scenario.clone(),
                    falsifier: rival.falsifier.clone(),
                    budget: keys.budget,
                    tries: keys.episodes,
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
        let is_new = !own.ids.contains(&id);
        let (requirements, place) = self.requirements_with(block, "goal", id, usual);
        SearchGoal { requirements, criterion: Criterion::Violation(place), declared: vec![id; 1 + usize::from(is_new)] }
    }

    pub(crate) fn falsifiers(
        &mut self,
        at: Nested<'_>,
        ids: &[DeclarationId],
        body: &Axis<PedestrianRole>,
        usual: &Usual,
    ) -> Vec<Rival> {
        let (states, roles, usual) = (usual.roles.states(&body.value), &usual.roles, usual.training.as_ref());
        let mut rivals = Vec::new();
        for id in ids {
            let declaration = self.program.get(*id);
            let arguments = &declaration.block.arguments;
            let training = match falsifier::named(arguments, "training") {
                Some(id) => Some(self.training(id, &states)),
                // Its first networks were checked for the campaign's pedestrian, who may have other states.
                None => usual.map(|axis| match axis.value.from.as_ref().and_then(|from| from.networks.as_ref()) {
                    Some(_) => self.training(axis.id, &states),
                    None => axis.clone(),
                }),
            };
            let learns = falsifier::learns(&self.catalog.falsifiers, declaration);
            if training.is_none() && learns {
                self.said.push(diagnostics::no_training(at.campaign.head, declaration.block.head));
                continue;
            }
            let learnt = training.as_ref().map(|axis| &axis.value).filter(|_| learns);
            if learnt.is_some_and(|config| config.policies == Some(Policies::Shared)) && !roles.is_uniform(&body.value)
            {
                self.said.push(diagnostics::unshared_policy(declaration.block.head));
            } else if learnt.is_some_and(|config| config.credit == Some(Credit::Removal)) {
                self.said.push(diagnostics::removal_search(declaration.block.head));
            }
            let controller = falsifier::named(arguments, "pedestrian").or_else(|| falsifier::named(arguments, "from"));
            let named = falsifier::Named {
                training: training.as_ref().map(|training| training.value.clone()),
                controller: controller.and_then(|id| self.controller(id)),
            };
            if controller.is_some() && named.controller.is_none() {
                continue;
            }
            let reward = falsifier::named(arguments, "reward");
            // A goal takes the place of the reward.
            if at.block.places.iter().all(|(key, _)| *key != "goal") {
                reward.into_iter().for_each(|id| self.warn_of_no_pay(id));
            }
            let reward = reward.map(|id| self.reward(id));
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
