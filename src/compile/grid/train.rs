use std::collections::{BTreeMap, BTreeSet};

use super::axis::{Axis, Usual};
use super::ground::{Place, note_towns};
use crate::campaign::{Together, TrainKeys};
use crate::lowering::Lowering;
use crate::{Campaign, Job, Training, TrainingKey};
use base::signature::{DeclarationId, Formula, VariableId};
use lang::diagnostics;
use lang::hir::{Block, Clause};
use world::env::{EpisodeRule, RewardRule};

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
        let TrainKeys { places, rewards: paid, runs, together, start } = block.keys();
        let bodies = [(&usual.car, &usual.walker)];
        let Some(ground) = self.ground(campaign_block, block, &places, &start, &bodies) else { return };
        let paid: Vec<_> = paid.into_iter().map(|id| self.reward(id)).collect();
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), paid.len(), runs as usize]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        paid.iter().for_each(|reward| self.warn_of_paid_waiting(reward, &usual.rule.value));
        let (config, environments) = &training.value;
        for places in groups(ground.places().collect(), together) {
            for reward in &paid {
                let scenario_of =
                    |place: &Place<'_>| place.scenario(car, walker, &usual.rule.value, &reward.value, &[].into());
                let scenarios: Vec<_> =
                    places.iter().map(|place| (place.town.name.to_string(), scenario_of(place))).collect();
                let ground: Vec<DeclarationId> = places
                    .iter()
                    .flat_map(|place| place.declarations(&usual.car, &usual.walker, &usual.rule))
                    .collect();
                let fingerprint = self.fingerprint(&[ground.as_slice(), &[reward.id, training.id]].concat());
                let programs = self.programs(&ground);
                let lineage = (!config.depends_on_total_steps())
                    .then(|| self.lineage(&[ground.as_slice(), &[reward.id]].concat(), training.id));
                campaign.jobs.extend((0..runs).map(|run| {
                    Job::from(Training {
                        key: TrainingKey {
                            town: joined(places.iter().map(|place| &*place.town.name)),
                            policy: joined(places.iter().map(|place| &*place.policy.name)),
                            reward: reward.name.to_string(),
                            run,
                        },
                        scenario: scenarios[0].1.clone(),
                        together: if scenarios.len() > 1 { scenarios.clone() } else { Vec::new() },
                        drive: None,
                        config: config.clone(),
                        environments: *environments,
                        fingerprint,
                        programs: programs.clone(),
                        lineage,
                    })
                }));
            }
        }
        rewards.extend(paid.into_iter().map(|reward| (reward.name.to_string(), reward)));
    }

    /// Warns of a reward that pays for every step, and so much that no touch or violation is worth ending an episode.
    fn warn_of_paid_waiting(&mut self, reward: &Axis<RewardRule>, rule: &EpisodeRule) {
        // The robustness of a requirement is no variable of the vocabulary, and has no bounds.
        let known = |id: VariableId| self.catalog.vocabulary.variables.get(id.0);
        let bounds = |formula: &Formula| {
            formula.bounds(&|id| known(id).map_or((f64::NEG_INFINITY, f64::INFINITY), |variable| variable.bounds))
        };
        let declaration = self.program.get(reward.id);
        let clauses = || declaration.block.clauses.iter();
        let Some(step) = clauses().find(|clause| clause.event == "step") else { return };
        let waiting = bounds(&step.formula).0 * f64::from(rule.ticks / rule.hold.max(1));
        let is_goal = |clause: &&Clause| clause.event == "hit" || clause.subject.is_some();
        let hits = clauses().filter(is_goal).map(|clause| bounds(&clause.formula).1);
        let hit = hits.fold(0.0, f64::max);
        if waiting > 0.0 && waiting >= hit {
            self.said.push(diagnostics::paid_waiting(step.span, &declaration.name, waiting, hit));
        }
    }

    pub(super) fn forbid_repeated_trainings(&mut self, block: &Block, campaign: &Campaign) {
        let mut seen = BTreeSet::new();
        for training in campaign.all::<Training>() {
            if !seen.insert(&training.key) {
                let TrainingKey { town, policy, reward, run } = &training.key;
                let message = format!("{town} × {policy} × {reward}, run {run}, is trained twice");
                self.said.push(diagnostics::contradiction(block.head, message));
                return;
            }
        }
    }
}

/// The places of each training: one each, or all that share what is not trained together.
fn groups<'a>(places: Vec<Place<'a>>, together: Option<Together>) -> Vec<Vec<Place<'a>>> {
    let mut groups: Vec<Vec<Place<'a>>> = Vec::new();
    for place in places {
        let joins = |group: &&mut Vec<Place<'a>>| match together {
            Some(Together::Policies) => group[0].town.id == place.town.id,
            Some(Together::Towns) => group[0].policy.id == place.policy.id,
            Some(Together::All) => true,
            None => false,
        };
        match groups.iter_mut().find(joins) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
}

/// Names joined by `+`, each once.
pub(super) fn joined<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut all: Vec<&str> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all.join("+")
}
