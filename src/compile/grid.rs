//! A campaign's grid: what is trained, and who is tried where.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::lower::{BuiltTown, Lowering};
use super::plan::{Campaign, Driver, Evaluation, NamedTown, Pedestrian, Search, SearchKey, Training, TrainingKey};
use super::{adversary, episode, falsifier, policy, reward, training, vehicle};
use crate::env::{Adversary, EpisodeRule, PolicyMaker, RewardRule, Scenario, SpawnRule};
use crate::falsifier::Falsifier;
use crate::lang::codes;
use crate::lang::hir::{Block, Declaration};
use crate::rl::PpoConfig;
use crate::seed::Seed;
use crate::signature::{DeclarationId, Value};
use crate::sim::VehicleBlueprint;

/// Most decisions between two updates, over all environments.
const MOST_DECISIONS: usize = 1 << 22;
/// Most trainings, evaluations or searches that one block may ask for.
const MOST_CELLS: usize = 200_000;

/// A member of one axis of the grid.
#[derive(Clone)]
struct Axis<T> {
    name: String,
    value: T,
}

/// A falsifier of a `search` block.
struct Rival {
    name: String,
    method: &'static str,
    reward: Axis<RewardRule>,
    falsifier: Arc<dyn Falsifier>,
}

/// One point of the grid without its reward.
struct Point<'a> {
    town: &'a BuiltTown,
    policy: &'a PolicyMaker,
    vehicle: &'a VehicleBlueprint,
    adversary: &'a Adversary,
    spawn: &'a SpawnRule,
    episode: &'a EpisodeRule,
}

impl Point<'_> {
    fn scenario(&self, reward: &RewardRule) -> Arc<Scenario> {
        Arc::new(Scenario {
            town: self.town.town.clone(),
            obstacles: self.town.obstacles.clone(),
            vehicle: self.vehicle.clone(),
            policy: self.policy.clone(),
            adversary: self.adversary.clone(),
            spawn: self.spawn.clone(),
            reward: reward.clone(),
            episode: self.episode.clone(),
        })
    }
}

impl Lowering<'_> {
    /// Lays out the grid of a campaign.
    pub fn campaign(&mut self, declaration: &Declaration) -> Campaign {
        let block = &declaration.block;
        let referred = |key: &str| block.arguments.reference(key);
        let car = self.vehicle(referred("vehicle"));
        let walker = self.adversary(referred("adversary"));
        let rule = episode::lower(&self.program.get(referred("episode")).block.arguments);
        let mut campaign = Campaign {
            name: declaration.name.clone(),
            docs: declaration.docs.clone(),
            settings: Vec::new(),
            words: Vec::new(),
            towns: Vec::new(),
            drivers: self.drivers(block),
            trainings: Vec::new(),
            evaluations: Vec::new(),
            searches: Vec::new(),
        };
        let mut rewards: BTreeMap<String, RewardRule> = BTreeMap::new();
        let usual = self.training(referred("training"));
        let (config, environments) = usual.clone();
        for train in block.nested("train") {
            let Some(spawn) = self.spawn(block, train) else { continue };
            let (towns, policies) = (self.towns(train), self.policies(train));
            self.probe(block, train, &towns, &spawn, &[(&car.value, &walker.value)]);
            let rewards_here = train.arguments.references("rewards").len();
            let runs = train.arguments.integer("runs") as usize;
            if !self.fits(train, [towns.len(), policies.len(), rewards_here, runs]) {
                continue;
            }
            for town in &towns {
                note_town(&mut campaign.towns, town);
                for policy in &policies {
                    let point = Point {
                        town: &town.value,
                        policy: &policy.value,
                        vehicle: &car.value,
                        adversary: &walker.value,
                        spawn: &spawn,
                        episode: &rule,
                    };
                    for reward in self.rewards(train) {
                        let scenario = point.scenario(&reward.value);
                        for run in 0..train.arguments.integer("runs") as u32 {
                            let (town, policy) = (town.name.clone(), policy.name.clone());
                            let key = TrainingKey { town, policy, reward: reward.name.clone(), run };
                            let scenario = scenario.clone();
                            campaign.trainings.push(Training { key, scenario, config: config.clone(), environments });
                        }
                        rewards.insert(reward.name, reward.value);
                    }
                }
            }
        }
        self.forbid_repeated_trainings(block, &campaign);
        let searches = block.nested("search").next().is_some() && block.nested("evaluate").next().is_none();
        if block.nested("train").next().is_none() && !searches {
            let message = "this campaign has no `train` block, so there is nobody to try".to_string();
            self.said.push(codes::contradiction(block.head, message));
        }
        for (number, evaluate) in block.nested("evaluate").enumerate() {
            let Some(spawn) = self.spawn(block, evaluate) else { continue };
            let (towns, policies) = (self.towns(evaluate), self.policies(evaluate));
            let named = |key: &str| evaluate.arguments.has(key).then(|| evaluate.arguments.references(key));
            let cars = named("vehicles").map(|ids| ids.into_iter().map(|id| self.vehicle(id)).collect());
            let walkers = named("adversaries").map(|ids| ids.into_iter().map(|id| self.adversary(id)).collect());
            let (cars, walkers): (Vec<_>, Vec<_>) =
                (cars.unwrap_or_else(|| vec![car.clone()]), walkers.unwrap_or_else(|| vec![walker.clone()]));
            let bodies: Vec<_> = cars.iter().flat_map(|c| walkers.iter().map(|w| (&c.value, &w.value))).collect();
            self.probe(block, evaluate, &towns, &spawn, &bodies);
            let who = pedestrians(evaluate.arguments.list("pedestrians"), &campaign.trainings);
            if !self.fits(evaluate, [towns.len(), policies.len(), bodies.len(), who.len().max(rewards.len())]) {
                continue;
            }
            for town in &towns {
                note_town(&mut campaign.towns, town);
                for policy in &policies {
                    for (car, walker) in cars.iter().flat_map(|car| walkers.iter().map(move |walker| (car, walker))) {
                        let point = Point {
                            town: &town.value,
                            policy: &policy.value,
                            vehicle: &car.value,
                            adversary: &walker.value,
                            spawn: &spawn,
                            episode: &rule,
                        };
                        let scenarios: BTreeMap<&String, Arc<Scenario>> =
                            rewards.iter().map(|(name, reward)| (name, point.scenario(reward))).collect();
                        campaign.evaluations.extend(who.iter().map(|(pedestrian, trained)| Evaluation {
                            pedestrian: *pedestrian,
                            trained: trained.clone(),
                            town: town.name.clone(),
                            policy: policy.name.clone(),
                            vehicle: car.name.clone(),
                            adversary: walker.name.clone(),
                            block: number as u32,
                            scenario: scenarios[&trained.reward].clone(),
                            episodes: evaluate.arguments.integer("episodes") as u32,
                        }));
                    }
                }
            }
        }
        for (number, search) in block.nested("search").enumerate() {
            let Some(spawn) = self.spawn(block, search) else { continue };
            let (towns, policies) = (self.towns(search), self.policies(search));
            self.probe(block, search, &towns, &spawn, &[(&car.value, &walker.value)]);
            let falsifiers = self.falsifiers(search, &usual);
            let runs = search.arguments.integer("runs") as usize;
            if !self.fits(search, [towns.len(), policies.len(), falsifiers.len(), runs]) {
                continue;
            }
            for town in &towns {
                note_town(&mut campaign.towns, town);
                for policy in &policies {
                    let point = Point {
                        town: &town.value,
                        policy: &policy.value,
                        vehicle: &car.value,
                        adversary: &walker.value,
                        spawn: &spawn,
                        episode: &rule,
                    };
                    for rival in &falsifiers {
                        let scenario = point.scenario(&rival.reward.value);
                        campaign.searches.extend((0..search.arguments.integer("runs") as u32).map(|run| Search {
                            key: SearchKey {
                                falsifier: rival.name.clone(),
                                method: rival.method,
                                reward: rival.reward.name.clone(),
                                town: town.name.clone(),
                                policy: policy.name.clone(),
                                block: number as u32,
                                run,
                            },
                            scenario: scenario.clone(),
                            falsifier: rival.falsifier.clone(),
                            budget: search.arguments.integer("budget") as u64,
                            tries: search.arguments.integer("episodes") as u32,
                        }));
                    }
                }
            }
        }
        campaign
    }

    /// Whether the axes of a block make no more cells than can be run, saying so otherwise.
    fn fits(&mut self, block: &Block, axes: [usize; 4]) -> bool {
        let cells = axes.into_iter().fold(1, usize::saturating_mul);
        if cells > MOST_CELLS {
            self.said.push(codes::too_many_combinations(block.head, cells, MOST_CELLS));
        }
        cells <= MOST_CELLS
    }

    fn falsifiers(&mut self, block: &Block, usual: &(PpoConfig, usize)) -> Vec<Rival> {
        let mut rivals = Vec::new();
        for id in block.arguments.references("falsifiers") {
            let declaration = self.program.get(id);
            let arguments = &declaration.block.arguments;
            let training = match falsifier::named(arguments, "training") {
                Some(id) => self.training(id),
                None => usual.clone(),
            };
            let none = Axis { name: String::new(), value: RewardRule::default() };
            rivals.push(Rival {
                name: declaration.name.clone(),
                method: declaration.kind,
                reward: falsifier::named(arguments, "reward").map_or(none, |id| self.reward(id)),
                falsifier: falsifier::lower(&self.catalog.falsifiers, declaration, &training, self.said),
            });
        }
        rivals
    }

    fn vehicle(&self, id: DeclarationId) -> Axis<VehicleBlueprint> {
        let declaration = self.program.get(id);
        let value = vehicle::lower(declaration.kind, &declaration.block.arguments);
        Axis { name: declaration.name.clone(), value }
    }

    fn adversary(&self, id: DeclarationId) -> Axis<Adversary> {
        let declaration = self.program.get(id);
        Axis { name: declaration.name.clone(), value: adversary::lower(&declaration.block.arguments) }
    }

    fn training(&mut self, id: DeclarationId) -> (PpoConfig, usize) {
        let block = &self.program.get(id).block;
        let (config, environments) = training::lower(&block.arguments);
        if config.rollout_steps.saturating_mul(environments) > MOST_DECISIONS {
            let message = format!("an update of more than {MOST_DECISIONS} decisions does not fit in memory");
            self.said.push(codes::contradiction(block.place("steps_per_update"), message));
        }
        (config, environments)
    }

    fn towns(&mut self, block: &Block) -> Vec<Axis<BuiltTown>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("towns") {
            let name = self.program.get(id).name.clone();
            axis.extend(self.town(id).map(|value| Axis { name, value }));
        }
        axis
    }

    fn policies(&mut self, block: &Block) -> Vec<Axis<PolicyMaker>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("policies") {
            let name = self.program.get(id).name.clone();
            axis.extend(self.policy(id).map(|value| Axis { name, value }));
        }
        axis
    }

    /// The drivers that a campaign names, each once, in order.
    fn drivers(&self, campaign: &Block) -> Vec<Driver> {
        let blocks = ["train", "evaluate", "search"].into_iter().flat_map(|word| campaign.nested(word));
        let mut seen = BTreeSet::new();
        let all = blocks.flat_map(|block| block.arguments.references("policies"));
        all.filter(|id| seen.insert(*id)).map(|id| policy::describe(self.program.get(id), self)).collect()
    }

    fn rewards(&self, block: &Block) -> Vec<Axis<RewardRule>> {
        block.arguments.references("rewards").into_iter().map(|id| self.reward(id)).collect()
    }

    fn reward(&self, id: DeclarationId) -> Axis<RewardRule> {
        let declaration = self.program.get(id);
        Axis { name: declaration.name.clone(), value: reward::lower(&declaration.block) }
    }

    fn spawn(&mut self, campaign: &Block, block: &Block) -> Option<SpawnRule> {
        let owner = if block.arguments.has("spawn") { block } else { campaign };
        self.spawn_rule(owner.arguments.reference("spawn"))
    }

    /// Makes sure that somebody can be placed in every town, and not inside any of the cars.
    fn probe(
        &mut self,
        campaign: &Block,
        block: &Block,
        towns: &[Axis<BuiltTown>],
        spawn: &SpawnRule,
        bodies: &[(&VehicleBlueprint, &Adversary)],
    ) {
        let place = if block.arguments.has("spawn") { block.place("spawn") } else { campaign.place("spawn") };
        for (car, walker) in bodies {
            let corner = (car.half_length * car.half_length + car.half_width * car.half_width).sqrt();
            let reach = corner + walker.body.radius;
            let nearest = spawn.distance.support().0;
            if nearest <= reach {
                let message = format!(
                    "a pedestrian {} m from the middle of the car may stand inside it: its corners reach {reach:.2} m",
                    nearest
                );
                self.said.push(codes::contradiction(place, message));
                return;
            }
        }
        for town in towns {
            let mut stream = Seed::root(0).child("probe").stream();
            if let Err(error) = spawn.probe(&town.value.town, &town.value.obstacles, &mut stream) {
                self.said.push(codes::unplaceable(place, &town.name, &error.to_string()));
            }
        }
    }

    fn forbid_repeated_trainings(&mut self, block: &Block, campaign: &Campaign) {
        let mut seen = BTreeSet::new();
        for training in &campaign.trainings {
            if !seen.insert(&training.key) {
                let TrainingKey { town, policy, reward, run } = &training.key;
                let message = format!("{town} × {policy} × {reward}, run {run}, is trained twice");
                self.said.push(codes::contradiction(block.head, message));
                return;
            }
        }
    }
}

fn note_town(towns: &mut Vec<NamedTown>, town: &Axis<BuiltTown>) {
    if towns.iter().all(|known| known.name != town.name) {
        towns.push(NamedTown { name: town.name.clone(), town: town.value.town.clone() });
    }
}

/// Who is tried: every trained pedestrian, and for every run of a reward a random one, which draws anew in each; the
/// homing and the intercepting one draw nothing, so they are tried once for each reward.
fn pedestrians(words: &[Value], trainings: &[Training]) -> Vec<(Pedestrian, TrainingKey)> {
    let mut all = Vec::new();
    for word in words {
        let Value::Choice(word) = word else { panic!("checked: a choice") };
        let mut seen = BTreeSet::new();
        for (index, training) in trainings.iter().enumerate() {
            let pedestrian = match *word {
                "random" => Pedestrian::Random,
                "homing" => Pedestrian::Homing,
                "intercept" => Pedestrian::Intercept,
                "sampled" => Pedestrian::Sampled(index),
                _ => Pedestrian::Trained(index),
            };
            let mut key = training.key.clone();
            if matches!(pedestrian, Pedestrian::Random | Pedestrian::Homing | Pedestrian::Intercept) {
                key.town = String::new();
                key.policy = String::new();
            }
            if matches!(pedestrian, Pedestrian::Homing | Pedestrian::Intercept) {
                key.run = 0;
            }
            if seen.insert((pedestrian, key.clone())) {
                all.push((pedestrian, key));
            }
        }
    }
    all
}
