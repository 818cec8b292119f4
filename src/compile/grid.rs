//! A campaign's grid: what is trained, and who is tried where.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::lowering::{BuiltTown, Lowering};
use super::plan::{
    Campaign, Driver, Evaluation, NamedTown, Pedestrian, Published, Search, SearchKey, Training, TrainingKey,
};
use super::{RunId, adversary, episode, falsifier, policy, published, reward, training, vehicle};
use crate::env::{
    Cast, EpisodeRule, FirstHeading, PedestrianRole, PolicyMaker, RewardRule, Scenario, SpawnRule, VehicleRole,
};
use crate::falsifier::Falsifier;
use crate::lang::codes;
use crate::lang::hir::{Block, Declaration};
use crate::rl::PpoConfig;
use crate::seed::Seed;
use crate::signature::{DeclarationId, Value, short};
use crate::sim::VehicleBlueprint;

/// Most decisions between two updates, over all environments.
const MOST_DECISIONS: usize = 1 << 22;
/// Most components of all states between two updates.
const MOST_SEEN: usize = 1 << 27;
/// Most weights of a network.
const MOST_WEIGHTS: usize = 1 << 24;
/// Most trainings, evaluations or searches that one block may ask for.
const MOST_CELLS: usize = 200_000;

/// What stands for the name of a reward where nobody is trained for one.
const NO_REWARD: &str = "none";

/// A member of one axis of the grid.
#[derive(Clone)]
struct Axis<T> {
    id: DeclarationId,
    name: Arc<str>,
    value: T,
}

/// A falsifier of a `search` block.
struct Rival {
    name: String,
    method: &'static str,
    reward: (String, RewardRule),
    /// It, and how pedestrians are trained where it does not say so.
    declarations: Vec<DeclarationId>,
    falsifier: Arc<dyn Falsifier>,
}

/// What all blocks of a campaign have in common unless they say otherwise.
struct Usual {
    car: Axis<VehicleBlueprint>,
    walker: Axis<PedestrianRole>,
    rule: Axis<EpisodeRule>,
    training: Option<Axis<(PpoConfig, usize)>>,
}

/// Where the episodes of a block happen, against whom, and how they begin.
struct Ground {
    towns: Vec<Axis<BuiltTown>>,
    policies: Vec<Axis<PolicyMaker>>,
    spawn: Axis<SpawnRule>,
}

impl Ground {
    /// Every town with every policy.
    fn places(&self) -> impl Iterator<Item = Place<'_>> {
        let place = |town, policy| Place { town, policy, spawn: &self.spawn };
        self.towns.iter().flat_map(move |town| self.policies.iter().map(move |policy| place(town, policy)))
    }
}

/// A town with a policy.
#[derive(Clone, Copy)]
struct Place<'a> {
    town: &'a Axis<BuiltTown>,
    policy: &'a Axis<PolicyMaker>,
    spawn: &'a Axis<SpawnRule>,
}

impl Place<'_> {
    fn scenario(
        &self,
        car: &VehicleBlueprint,
        walker: &PedestrianRole,
        rule: &EpisodeRule,
        reward: &RewardRule,
    ) -> Arc<Scenario> {
        Arc::new(Scenario {
            town: self.town.value.town.clone(),
            obstacles: self.town.value.obstacles.clone(),
            cast: Cast::pair(VehicleRole { blueprint: car.clone(), policy: self.policy.value.clone() }, walker.clone()),
            spawn: self.spawn.value.clone(),
            reward: reward.clone(),
            episode: rule.clone(),
        })
    }

    /// The declarations of a scenario.
    fn declarations(
        &self,
        car: &Axis<VehicleBlueprint>,
        walker: &Axis<PedestrianRole>,
        rule: &Axis<EpisodeRule>,
    ) -> [DeclarationId; 6] {
        [self.town.id, self.policy.id, self.spawn.id, car.id, walker.id, rule.id]
    }
}

impl Lowering<'_> {
    /// Lays out the grid of a campaign.
    pub fn campaign(&mut self, declaration: &Declaration) -> Campaign {
        let block = &declaration.block;
        let referred = |key: &str| block.arguments.reference(key);
        let usual = Usual {
            car: self.vehicle(referred("vehicle")),
            walker: self.adversary(referred("adversary")),
            rule: self.episode(referred("episode")),
            training: block.arguments.has("training").then(|| self.training(referred("training"))),
        };
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
            published: self.published(block),
        };
        let mut rewards = BTreeMap::new();
        for train in block.nested("train") {
            self.train(block, train, &usual, &mut campaign, &mut rewards);
        }
        self.forbid_repeated_trainings(block, &campaign);
        if !campaign.published.is_empty() && block.nested("train").next().is_none() {
            self.said.push(codes::beside_nobody(block.place("beside")));
        }
        if ["train", "evaluate", "search"].iter().all(|word| block.nested(word).next().is_none()) {
            let message = "this campaign trains nobody, tries nobody and searches for nothing".to_string();
            let help = "give it a block: `train { … }`, `evaluate { … }` or `search { … }`";
            self.said.push(codes::contradiction(block.head, message).help(help));
        }
        for (number, evaluate) in (0..).zip(block.nested("evaluate")) {
            self.evaluate(block, evaluate, number, &usual, &mut campaign, &rewards);
        }
        for (number, search) in (0..).zip(block.nested("search")) {
            self.search(block, search, number, &usual, &mut campaign);
        }
        campaign
    }

    /// The trainings of a `train` block; its rewards are noted for those who are tried later.
    fn train(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        usual: &Usual,
        campaign: &mut Campaign,
        rewards: &mut BTreeMap<String, Axis<RewardRule>>,
    ) {
        let (car, walker) = (&usual.car.value, &usual.walker.value);
        let Some(training) = &usual.training else {
            return self.said.push(codes::no_training(campaign_block.head, block.head));
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
                let recipe = self.recipe(&[ground.as_slice(), &[reward.id, training.id]].concat());
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
                    recipe,
                }));
            }
        }
        rewards.extend(paid.into_iter().map(|reward| (reward.name.to_string(), reward)));
    }

    fn evaluate(
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
        let untrained = campaign_block.nested("train").next().is_none();
        if untrained && words.iter().any(|word| matches!(word, Value::Choice("trained" | "sampled"))) {
            return self.said.push(codes::nobody_trained(block.place("pedestrians")));
        }
        let who = if untrained { untrained_pedestrians(words) } else { pedestrians(words, &campaign.trainings) };
        let each = who.len().max(rewards.len());
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), all.len(), each]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        for (place, (car, walker)) in ground.places().flat_map(|place| bodies().map(move |body| (place, body))) {
            let ground = place.declarations(car, walker, &usual.rule);
            let mut scenario = |rule: &RewardRule, declared: &[DeclarationId]| {
                let scenario = place.scenario(&car.value, &walker.value, &usual.rule.value, rule);
                (scenario, self.recipe(&[ground.as_slice(), declared].concat()))
            };
            let mut scenarios: BTreeMap<&str, _> = BTreeMap::new();
            for (name, reward) in rewards {
                scenarios.insert(name, scenario(&reward.value, &[reward.id]));
            }
            if untrained {
                scenarios.insert(NO_REWARD, scenario(&RewardRule::default(), &[]));
            }
            campaign.evaluations.extend(who.iter().map(|(pedestrian, trained)| Evaluation {
                id: RunId::default(),
                pedestrian: *pedestrian,
                trained: trained.clone(),
                town: place.town.name.clone(),
                policy: place.policy.name.clone(),
                vehicle: car.name.clone(),
                adversary: walker.name.clone(),
                block: number,
                scenario: scenarios[trained.reward.as_str()].0.clone(),
                episodes: block.arguments.integer("episodes") as u32,
                recipe: scenarios[trained.reward.as_str()].1,
                halfwidth: block.arguments.has("halfwidth").then(|| block.arguments.number("halfwidth")),
            }));
        }
    }

    fn search(&mut self, campaign_block: &Block, block: &Block, number: u32, usual: &Usual, campaign: &mut Campaign) {
        let (car, walker) = (&usual.car.value, &usual.walker.value);
        let Some(ground) = self.ground(campaign_block, block, &[(&usual.car, &usual.walker)]) else { return };
        let falsifiers = self.falsifiers(campaign_block, block, usual.training.as_ref());
        let runs = block.arguments.integer("runs") as u32;
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), falsifiers.len(), runs as usize]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        for (place, rival) in ground.places().flat_map(|place| falsifiers.iter().map(move |rival| (place, rival))) {
            let scenario = place.scenario(car, walker, &usual.rule.value, &rival.reward.1);
            let ground = place.declarations(&usual.car, &usual.walker, &usual.rule);
            let recipe = self.recipe(&[ground.as_slice(), &rival.declarations].concat());
            campaign.searches.extend((0..runs).map(|run| Search {
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
                budget: block.arguments.integer("budget") as u64,
                tries: block.arguments.integer("episodes") as u32,
                recipe,
            }));
        }
    }

    /// The ground of a block, on which somebody can be placed beside each of these bodies; none after saying what is wrong
    /// with how episodes begin.
    fn ground(
        &mut self,
        campaign: &Block,
        block: &Block,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
    ) -> Option<Ground> {
        let spawn = self.spawn(campaign, block)?;
        let ground = Ground { towns: self.towns(block), policies: self.policies(block), spawn };
        self.compare_ticks(campaign, block);
        self.probe(campaign, block, &ground.towns, &ground.spawn.value, bodies);
        Some(ground)
    }

    /// Says which drivers of a block are made for other ticks than they get.
    fn compare_ticks(&mut self, campaign: &Block, block: &Block) {
        let episode = self.program.get(campaign.arguments.reference("episode"));
        let tick = episode.block.arguments.number("tick");
        for (place, id) in block.arguments.references("policies").into_iter().enumerate() {
            let policy = self.program.get(id);
            let made_for = policy::signature(policy, self.catalog).and_then(|signature| signature.tick);
            if let Some(made_for) = made_for.filter(|made_for| *made_for != tick) {
                let span = block.members("policies").get(place).copied().unwrap_or(block.head);
                let given = episode.block.place("tick");
                self.said.push(codes::other_tick(span, &policy.name, made_for, tick, given));
            }
        }
    }

    /// Whether the axes of a block make no more cells than can be run, saying so otherwise.
    fn fits(&mut self, block: &Block, axes: [usize; 4]) -> bool {
        let cells = axes.into_iter().fold(1, usize::saturating_mul);
        if cells > MOST_CELLS {
            self.said.push(codes::too_many_combinations(block.head, cells, MOST_CELLS));
        }
        cells <= MOST_CELLS
    }

    fn falsifiers(&mut self, campaign: &Block, block: &Block, usual: Option<&Axis<(PpoConfig, usize)>>) -> Vec<Rival> {
        let mut rivals = Vec::new();
        for id in block.arguments.references("falsifiers") {
            let declaration = self.program.get(id);
            let arguments = &declaration.block.arguments;
            let training = match falsifier::named(arguments, "training") {
                Some(id) => Some(self.training(id)),
                None => usual.cloned(),
            };
            if training.is_none() && falsifier::learns(&self.catalog.falsifiers, declaration) {
                self.said.push(codes::no_training(campaign.head, declaration.block.head));
                continue;
            }
            let reward = falsifier::named(arguments, "reward").map(|id| self.reward(id));
            rivals.push(Rival {
                name: declaration.name.clone(),
                method: declaration.kind,
                reward: reward.map(|reward| (reward.name.to_string(), reward.value)).unwrap_or_default(),
                declarations: [Some(id), training.as_ref().map(|training| training.id)].into_iter().flatten().collect(),
                falsifier: falsifier::lower(
                    &self.catalog.falsifiers,
                    declaration,
                    training.map(|training| training.value),
                    self.said,
                ),
            });
        }
        rivals
    }

    fn vehicle(&self, id: DeclarationId) -> Axis<VehicleBlueprint> {
        let declaration = self.program.get(id);
        let value = vehicle::lower(declaration.kind, &declaration.block.arguments);
        Axis { id, name: declaration.name.as_str().into(), value }
    }

    fn adversary(&self, id: DeclarationId) -> Axis<PedestrianRole> {
        let declaration = self.program.get(id);
        Axis { id, name: declaration.name.as_str().into(), value: adversary::lower(&declaration.block.arguments) }
    }

    fn episode(&mut self, id: DeclarationId) -> Axis<EpisodeRule> {
        let declaration = self.program.get(id);
        let Block { arguments, places, .. } = &declaration.block;
        let given = |key: &str| places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
        if let Some(hold) = given("hold").filter(|_| arguments.integer("hold") > arguments.integer("ticks")) {
            self.said.push(codes::not_rising(hold, "hold", "ticks", None));
        }
        Axis { id, name: declaration.name.as_str().into(), value: episode::lower(&declaration.block.arguments) }
    }

    fn training(&mut self, id: DeclarationId) -> Axis<(PpoConfig, usize)> {
        let declaration = self.program.get(id);
        let block = &declaration.block;
        let (config, environments) = training::lower(&block.arguments);
        if config.rollout_steps.saturating_mul(environments) > MOST_DECISIONS {
            let message = format!("an update of more than {MOST_DECISIONS} decisions does not fit in memory");
            self.said.push(codes::contradiction(block.place("steps_per_update"), message));
        }
        let seen = config.rollout_steps.saturating_mul(environments).saturating_mul(4 * config.frame_stack);
        if seen > MOST_SEEN && config.rollout_steps.saturating_mul(environments) <= MOST_DECISIONS {
            let message =
                format!("an update of {seen} numbers of states does not fit in memory; at most {MOST_SEEN} do");
            self.said.push(codes::contradiction(block.place("frame_stack"), message));
        }
        let widths = [&[4 * config.frame_stack], config.hidden.as_slice(), &[2]].concat();
        let weights: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
        if weights > MOST_WEIGHTS {
            let message = format!("networks of {weights} weights do not fit in memory; at most {MOST_WEIGHTS} do");
            self.said.push(codes::contradiction(block.place("hidden"), message));
        }
        Axis { id, name: declaration.name.as_str().into(), value: (config, environments) }
    }

    fn towns(&mut self, block: &Block) -> Vec<Axis<BuiltTown>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("towns") {
            let name: Arc<str> = self.program.get(id).name.as_str().into();
            axis.extend(self.town(id).map(|value| Axis { id, name, value }));
        }
        axis
    }

    fn policies(&mut self, block: &Block) -> Vec<Axis<PolicyMaker>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("policies") {
            let name: Arc<str> = self.program.get(id).name.as_str().into();
            axis.extend(self.policy(id).map(|value| Axis { id, name, value }));
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

    fn published(&mut self, campaign: &Block) -> Vec<Published> {
        let arguments = &campaign.arguments;
        let named = if arguments.has("beside") { arguments.references("beside") } else { Vec::new() };
        named.into_iter().map(|id| published::lower(self.program.get(id), self.program, self.said)).collect()
    }

    fn rewards(&self, block: &Block) -> Vec<Axis<RewardRule>> {
        block.arguments.references("rewards").into_iter().map(|id| self.reward(id)).collect()
    }

    fn reward(&self, id: DeclarationId) -> Axis<RewardRule> {
        let declaration = self.program.get(id);
        Axis { id, name: declaration.name.as_str().into(), value: reward::lower(&declaration.block) }
    }

    fn spawn(&mut self, campaign: &Block, block: &Block) -> Option<Axis<SpawnRule>> {
        let owner = if block.arguments.has("spawn") { block } else { campaign };
        let id = owner.arguments.reference("spawn");
        let name: Arc<str> = self.program.get(id).name.as_str().into();
        self.spawn_rule(id).map(|value| Axis { id, name, value })
    }

    /// Makes sure that somebody can be placed in every town, and not inside any of the cars.
    fn probe(
        &mut self,
        campaign: &Block,
        block: &Block,
        towns: &[Axis<BuiltTown>],
        spawn: &SpawnRule,
        bodies: &[(&Axis<VehicleBlueprint>, &Axis<PedestrianRole>)],
    ) {
        let place = if block.arguments.has("spawn") { block.place("spawn") } else { campaign.place("spawn") };
        for (Axis { name, value: car, .. }, Axis { value: walker, .. }) in bodies {
            let corner = (car.half_length * car.half_length + car.half_width * car.half_width).sqrt();
            let reach = corner + walker.body.radius;
            let nearest = spawn.distance.support().0;
            if nearest <= reach {
                let message = format!(
                    "a pedestrian {} m from the middle of `{name}` may stand inside it: its corners reach {reach:.2} m",
                    short(nearest)
                );
                self.said.push(codes::contradiction(place, message));
                return;
            }
        }
        let looks = |first: &FirstHeading| bodies.iter().any(|(_, walker)| walker.value.first_heading == *first);
        let headings = [FirstHeading::Random, FirstHeading::TowardsEgo].into_iter().filter(looks);
        for town in towns {
            let probe = |first: FirstHeading| {
                let mut stream = Seed::root(0).child("probe").stream();
                spawn.probe(&town.value.town, &town.value.obstacles, first, &mut stream)
            };
            for found in headings.clone().map(probe) {
                match found {
                    Ok(None) => {}
                    Ok(Some(rarity)) => {
                        self.said.push(codes::rare_beginnings(place, &town.name, &rarity.to_string()));
                    }
                    Err(error) => {
                        self.said.push(codes::unplaceable(place, &town.name, &error.to_string()));
                        break;
                    }
                }
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

/// Notes towns, each once.
fn note_towns(noted: &mut Vec<NamedTown>, towns: &[Axis<BuiltTown>]) {
    for town in towns {
        if noted.iter().all(|known| known.name != *town.name) {
            noted.push(NamedTown { name: town.name.to_string(), town: town.value.town.clone() });
        }
    }
}

/// Who is tried where nobody is trained: each once, for no reward.
fn untrained_pedestrians(words: &[Value]) -> Vec<(Pedestrian, Arc<TrainingKey>)> {
    let reward = NO_REWARD.to_string();
    let key = Arc::new(TrainingKey { town: String::new(), policy: String::new(), reward, run: 0 });
    let untrained = |word: &Value| match word {
        Value::Choice("random") => Some(Pedestrian::Random),
        Value::Choice("homing") => Some(Pedestrian::Homing),
        Value::Choice("intercept") => Some(Pedestrian::Intercept),
        _ => None,
    };
    words.iter().filter_map(untrained).map(|pedestrian| (pedestrian, key.clone())).collect()
}

/// Who is tried: every trained pedestrian, and for every run of a reward a random one, which draws anew in each; the
/// homing and the intercepting one draw nothing, so they are tried once for each reward.
fn pedestrians(words: &[Value], trainings: &[Training]) -> Vec<(Pedestrian, Arc<TrainingKey>)> {
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
            let key = Arc::new(key);
            if seen.insert((pedestrian, key.clone())) {
                all.push((pedestrian, key));
            }
        }
    }
    all
}
