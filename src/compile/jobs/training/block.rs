use std::collections::BTreeSet;

use super::{Training, TrainingKey};
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Axis, Grid, Nested, Place, of_places};
use crate::jobs::{JobBlock, Origin};
use crate::lowering::Lowering;
use crate::{Campaign, Job};
use base::signature::{DeclarationId, Formula, Keys, VariableId};
use base::{choice, keys};
use episode::{EpisodeRule, RewardRule};
use lang::diagnostics;
use lang::hir::{Block, Clause};
use learn::{Credit, Policies};
use world::av::external::ExternalKeys;

choice! {
    /// What a pedestrian is trained for at once.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Together {
        Drivers = "drivers",
        Towns = "towns",
        All = "all",
    }
}

keys! {
    /// Trains one pedestrian for every town, driver, reward and run.
    pub struct TrainKeys = "train" {
        ..places: PlaceKeys,
        /// Rewards to train for.
        rewards: Vec<DeclarationId> as Reference("reward"),
        /// Trainings of each, with different seeds.
        runs: u32 as whole(1, 10_000) = "5",
        /// Trainings of each run, with different seeds. The one whose pedestrian earns most on 1,000 starts that are neither trained nor evaluated on
        /// is kept.
        candidates: u32 as whole(1, 1000) = "1",
        /// Trains one pedestrian against all `drivers`, in all `towns`, or both, whose episodes alternate; without it each
        /// pair of town and driver has a pedestrian of its own.
        together: Option<Together>,
        ..start: StartKeys,
    }
    .explained("towns", "Towns to train in.")
    .explained("drivers", "Drivers to train against.")
}

pub(crate) const BLOCK: JobBlock =
    JobBlock { signature: TrainKeys::signature, drivers: of_places, lower: |it, at, grid| it.train(at, grid) };

impl Lowering<'_> {
    /// The trainings of a `train` block; its rewards are recorded for the controllers that are evaluated later.
    fn train(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let Some(training) = grid.usual.training.clone() else { return self.no_training(at) };
        let TrainKeys { places, rewards: paid, runs, candidates, together, start } = at.block.keys();
        let Some((ground, body)) = self.setting(at, &places, &start, None, grid) else { return };
        let paid: Vec<_> = paid.into_iter().map(|id| self.reward(id)).collect();
        if !self.takes(at, &ground, [paid.len(), (runs as usize).saturating_mul(candidates as usize)], grid) {
            return;
        }
        let Grid { usual, campaign, rewards } = grid;
        paid.iter().for_each(|reward| self.warn_of_pay(reward, &usual.rule.value));
        let config = &training.value;
        for places in groups(ground.places().collect(), together) {
            for reward in &paid {
                let scenario_of = |place: &Place<'_>| usual.scenario(place, &body, &reward.value, &[].into());
                let scenarios: Vec<_> =
                    places.iter().map(|place| (place.town.name.to_string(), scenario_of(place))).collect();
                if config.policies == Some(Policies::Shared) && !usual.roles.is_uniform(&body.value) {
                    return self.said.push(diagnostics::unshared_policy(at.block.head));
                }
                let is_program = |place: &Place<'_>| self.program.get(place.policy.id).kind == ExternalKeys::KIND;
                if config.credit == Some(Credit::Removal) && places.iter().any(is_program) {
                    return self.said.push(diagnostics::uncopied_removal(at.block.head));
                }
                let ground: Vec<DeclarationId> =
                    places.iter().flat_map(|place| usual.declarations(place, &body)).collect();
                let fingerprint = self.fingerprint(&[ground.as_slice(), &[reward.id, training.id]].concat());
                let lineage = (!config.depends_on_total_steps())
                    .then(|| self.lineage(&[ground.as_slice(), &[reward.id]].concat(), training.id));
                campaign.jobs.extend(self.origins(at, runs, &ground).map(|origin| {
                    Job::from(Training {
                        key: TrainingKey {
                            town: joined(places.iter().map(|place| &*place.town.name)),
                            policy: joined(places.iter().map(|place| &*place.policy.name)),
                            reward: reward.name.to_string(),
                            run: origin.run,
                        },
                        origin: Origin { fingerprint, ..origin },
                        scenario: scenarios[0].1.clone(),
                        towns: scenarios.clone(),
                        drive: None,
                        config: config.clone(),
                        candidates,
                        lineage,
                    })
                }));
            }
        }
        rewards.extend(paid.into_iter().map(|reward| (reward.name.to_string(), reward)));
    }

    /// The least and the greatest value of a formula of a reward. The robustness of a requirement is no variable of the vocabulary, and has no
    /// bounds.
    fn bounds_of_pay(&self, formula: &Formula) -> (f64, f64) {
        let known = |id: VariableId| self.catalog.vocabulary.variables.get(id.0);
        formula.bounds(&|id| known(id).map_or((f64::NEG_INFINITY, f64::INFINITY), |variable| variable.bounds))
    }

    /// Warns once of a reward for which a learner or a search looks in vain: it pays nothing, and no touch is worth more than every end without one.
    pub(crate) fn warn_of_no_pay(&mut self, reward: DeclarationId) {
        let declaration = self.program.get(reward);
        let clauses = || declaration.block.clauses.iter();
        let most = |clause: &Clause| self.bounds_of_pay(&clause.formula).1;
        let without = |event| clauses().find(|clause| clause.event == event).map_or(0.0, most);
        let is_touch = |clause: &&Clause| clause.event == "touch";
        let other =
            if clauses().any(|clause| is_touch(&clause) && clause.word.is_none()) { f64::NEG_INFINITY } else { 0.0 };
        let touch = clauses().filter(is_touch).map(most).fold(other, f64::max);
        let is_aim = ["timeout", "lost"].into_iter().all(|event| without(event) < touch);
        if !is_aim && clauses().all(|clause| most(clause) <= 0.0) {
            let warning = diagnostics::never_positive(declaration.block.head, &declaration.name);
            if !self.said.contains(&warning) {
                self.said.push(warning);
            }
        }
    }

    /// Warns of a reward that pays nothing, or that pays so much for every step that no touch or violation is worth ending an episode.
    fn warn_of_pay(&mut self, reward: &Axis<RewardRule>, rule: &EpisodeRule) {
        self.warn_of_no_pay(reward.id);
        let declaration = self.program.get(reward.id);
        let clauses = || declaration.block.clauses.iter();
        let bounds = |formula: &Formula| self.bounds_of_pay(formula);
        let Some(step) = clauses().find(|clause| clause.event == "step") else { return };
        let waiting = bounds(&step.formula).0 * f64::from(rule.ticks / rule.hold.max(1));
        let is_goal = |clause: &&Clause| clause.event == "touch" || clause.subject.is_some();
        let hits = clauses().filter(is_goal).map(|clause| bounds(&clause.formula).1);
        let hit = hits.fold(0.0, f64::max);
        if waiting > 0.0 && waiting >= hit {
            self.said.push(diagnostics::paid_waiting(step.span, &declaration.name, waiting, hit));
        }
    }

    pub(crate) fn forbid_repeated_trainings(&mut self, block: &Block, campaign: &Campaign) {
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
            Some(Together::Drivers) => group[0].town.id == place.town.id,
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
pub(crate) fn joined<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut all: Vec<&str> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all.join("+")
}
