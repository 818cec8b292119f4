//! HIR → [`Plan`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::plan::{Campaign, Evaluation, NamedTown, Pedestrian, Plan, Training, TrainingKey};
use super::{Catalog, adversary, episode, policy, reward, spawn, town, training, vehicle};
use crate::diagnostic::{Diagnostic, Severity, Sources};
use crate::env::{PolicyMaker, RewardRule, Scenario, SpawnRule};
use crate::geometry::Obstacles;
use crate::lang::hir::{Block, Declaration, Program};
use crate::lang::{self, Reader, codes};
use crate::road::Town;
use crate::seed::Seed;
use crate::signature::{Arguments, DeclarationId, Value};

/// What came of a set of files.
#[derive(Debug)]
pub struct Compiled {
    /// What is to be run; none when a diagnostic is an error.
    pub plan: Option<Plan>,
    /// Everything that is to be said.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads, checks and lowers files with all that they import.
///
/// # Errors
/// The first named file that cannot be read, with the reason. Everything else is a diagnostic.
pub fn compile(
    paths: &[PathBuf],
    catalog: &Catalog,
    read: &Reader,
    sources: &mut Sources,
) -> Result<Compiled, (PathBuf, std::io::Error)> {
    let mut loaded = lang::load(paths, read, sources)?;
    let mut diagnostics = std::mem::take(&mut loaded.diagnostics);
    let (program, said) = lang::check(&loaded, sources, &catalog.forms, &catalog.vocabulary);
    diagnostics.extend(said);
    let is_error = |each: &Diagnostic| each.severity == Severity::Error;
    if diagnostics.iter().any(is_error) {
        return Ok(Compiled { plan: None, diagnostics });
    }
    let mut lowering =
        Lowering { program: &program, catalog, sources, read, said: &mut diagnostics, towns: BTreeMap::new() };
    let plan = lowering.plan();
    lowering.warn_of_unused();
    // One mistake may show in many cells.
    lang::once(&mut diagnostics);
    let plan = (!diagnostics.iter().any(is_error)).then_some(plan);
    Ok(Compiled { plan, diagnostics })
}

/// A town with what stands in it, ready to be shared.
#[derive(Clone)]
struct BuiltTown {
    town: Arc<Town>,
    obstacles: Arc<Obstacles>,
}

struct Lowering<'a> {
    program: &'a Program,
    catalog: &'a Catalog,
    sources: &'a Sources,
    read: &'a Reader<'a>,
    said: &'a mut Vec<Diagnostic>,
    towns: BTreeMap<DeclarationId, Option<BuiltTown>>,
}

/// Most decisions between two updates, over all environments.
const MOST_DECISIONS: usize = 1 << 22;

/// A member of one axis of a grid.
#[derive(Clone)]
struct Axis<T> {
    name: String,
    value: T,
}

impl Lowering<'_> {
    fn plan(&mut self) -> Plan {
        let program = self.program;
        // Towns of the named files are built even when nothing uses them: a library of towns is checked that way.
        let mut towns = Vec::new();
        for declaration in program.of_form("town") {
            let built = self.town(declaration.id);
            towns.extend(built.map(|built| NamedTown { name: declaration.name.clone(), town: built.town }));
        }
        self.forbid_equal_names();
        let campaigns = program.of_form("campaign").map(|campaign| self.campaign(campaign)).collect();
        Plan { campaigns, towns }
    }

    /// Campaigns of different files may share a name as far as the language goes, but their reports may not.
    fn forbid_equal_names(&mut self) {
        let mut seen: BTreeMap<&str, &Declaration> = BTreeMap::new();
        for campaign in self.program.of_form("campaign") {
            if let Some(first) = seen.insert(&campaign.name, campaign) {
                let (here, there) = (campaign.block.head, first.block.head);
                self.said.push(codes::duplicate_declaration(here, "campaign", &campaign.name, there));
            }
        }
    }

    fn town(&mut self, id: DeclarationId) -> Option<BuiltTown> {
        if let Some(built) = self.towns.get(&id) {
            return built.clone();
        }
        let built = town::lower(self.program.get(id), self.sources, self.read, self.said)
            .map(|town| BuiltTown { obstacles: Arc::new(Obstacles::new(&town.obstacles)), town: Arc::new(town) });
        self.towns.insert(id, built.clone());
        built
    }

    fn towns(&mut self, block: &Block) -> Vec<Axis<BuiltTown>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("towns") {
            let name = self.program.get(id).name.clone();
            axis.extend(self.town(id).map(|value| Axis { name, value }));
        }
        axis
    }

    fn policies(&self, block: &Block) -> Vec<Axis<PolicyMaker>> {
        let each = |id: DeclarationId| {
            let declaration = self.program.get(id);
            let value = policy::lower(&self.catalog.policies, declaration.kind, &declaration.block.arguments);
            Axis { name: declaration.name.clone(), value }
        };
        block.arguments.references("policies").into_iter().map(each).collect()
    }

    fn rewards(&self, block: &Block) -> Vec<Axis<RewardRule>> {
        let each = |id: DeclarationId| {
            let declaration = self.program.get(id);
            Axis { name: declaration.name.clone(), value: reward::lower(&declaration.block.clauses) }
        };
        block.arguments.references("rewards").into_iter().map(each).collect()
    }

    fn spawn(&self, campaign: &Block, block: &Block) -> SpawnRule {
        let owner = if block.arguments.has("spawn") { block } else { campaign };
        spawn::lower(&self.program.get(owner.arguments.reference("spawn")).block.arguments)
    }

    fn campaign(&mut self, declaration: &Declaration) -> Campaign {
        let block = &declaration.block;
        let referred = |key: &str| self.program.get(block.arguments.reference(key));
        let (car, walker, length) = (referred("vehicle"), referred("adversary"), referred("episode"));
        let base = (
            vehicle::lower(car.kind, &car.block.arguments),
            adversary::lower(&walker.block.arguments),
            episode::lower(&length.block.arguments),
        );
        let (config, environments) = training::lower(&referred("training").block.arguments);
        if config.rollout_steps.saturating_mul(environments) > MOST_DECISIONS {
            let place = referred("training").block.place("steps_per_update");
            let message = format!("an update of more than {MOST_DECISIONS} decisions does not fit in memory");
            self.said.push(codes::contradiction(place, message));
        }
        let mut campaign = Campaign {
            name: declaration.name.clone(),
            docs: declaration.docs.clone(),
            towns: Vec::new(),
            trainings: Vec::new(),
            evaluations: Vec::new(),
        };
        let scenario = |town: &BuiltTown, policy: &PolicyMaker, reward: &RewardRule, spawn: &SpawnRule| {
            Arc::new(Scenario {
                town: town.town.clone(),
                obstacles: town.obstacles.clone(),
                vehicle: base.0.clone(),
                policy: policy.clone(),
                adversary: base.1.clone(),
                spawn: spawn.clone(),
                reward: reward.clone(),
                episode: base.2.clone(),
            })
        };
        let corner = base.0.half_length * base.0.half_length + base.0.half_width * base.0.half_width;
        let car = corner.sqrt() + base.1.body.radius;
        let mut rules: BTreeMap<String, RewardRule> = BTreeMap::new();
        for train in block.nested("train") {
            let spawn = self.spawn(block, train);
            let (towns, policies, rewards) = (self.towns(train), self.policies(train), self.rewards(train));
            self.probe(block, train, &towns, &spawn, car);
            for town in &towns {
                note_town(&mut campaign.towns, town);
                for policy in &policies {
                    for reward in &rewards {
                        rules.insert(reward.name.clone(), reward.value.clone());
                        let scenario = scenario(&town.value, &policy.value, &reward.value, &spawn);
                        for run in 0..train.arguments.integer("runs") as u32 {
                            let key = TrainingKey {
                                town: town.name.clone(),
                                policy: policy.name.clone(),
                                reward: reward.name.clone(),
                                run,
                            };
                            let scenario = scenario.clone();
                            campaign.trainings.push(Training { key, scenario, config: config.clone(), environments });
                        }
                    }
                }
            }
        }
        self.forbid_repeated_trainings(block, &campaign);
        if campaign.trainings.is_empty() {
            let message = "this campaign has no `train` block, so there is nobody to try".to_string();
            self.said.push(codes::contradiction(block.head, message));
        }

        for (number, evaluate) in block.nested("evaluate").enumerate() {
            let spawn = self.spawn(block, evaluate);
            let (towns, policies) = (self.towns(evaluate), self.policies(evaluate));
            self.probe(block, evaluate, &towns, &spawn, car);
            let words: Vec<&Value> = evaluate.arguments.list("pedestrians").iter().collect();
            for town in &towns {
                note_town(&mut campaign.towns, town);
                for policy in &policies {
                    let scenarios: BTreeMap<&str, Arc<Scenario>> = rules
                        .iter()
                        .map(|(name, rule)| (name.as_str(), scenario(&town.value, &policy.value, rule, &spawn)))
                        .collect();
                    for (pedestrian, trained) in pedestrians(&words, &campaign.trainings) {
                        campaign.evaluations.push(Evaluation {
                            pedestrian,
                            scenario: scenarios[trained.reward.as_str()].clone(),
                            trained,
                            town: town.name.clone(),
                            policy: policy.name.clone(),
                            block: number as u32,
                            episodes: evaluate.arguments.integer("episodes") as u32,
                        });
                    }
                }
            }
        }
        campaign
    }

    /// Makes sure that somebody can be placed in every town, and not inside the car, whose corners reach so far (m).
    fn probe(&mut self, campaign: &Block, block: &Block, towns: &[Axis<BuiltTown>], spawn: &SpawnRule, car: f64) {
        let owner = if block.arguments.has("spawn") { block } else { campaign };
        if spawn.distance.0 <= car {
            let message = format!(
                "a pedestrian {} m from the middle of the car may stand inside it: its corners reach {car:.2} m",
                spawn.distance.0
            );
            self.said.push(codes::contradiction(owner.place("spawn"), message));
            return;
        }
        for town in towns {
            let mut stream = Seed::root(0).child("probe").stream();
            if let Err(error) = spawn.probe(&town.value.town, &town.value.obstacles, &mut stream) {
                self.said.push(codes::unplaceable(owner.place("spawn"), &town.name, &error.to_string()));
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

    fn warn_of_unused(&mut self) {
        let program = self.program;
        let mut used: BTreeSet<DeclarationId> = BTreeSet::new();
        let mut open: Vec<DeclarationId> = program.of_form("campaign").map(|campaign| campaign.id).collect();
        // A file without a campaign is a library: nothing in it is unused.
        let with_campaign: BTreeSet<_> = program.of_form("campaign").map(|campaign| campaign.source).collect();
        while let Some(id) = open.pop() {
            if used.insert(id) {
                references(&program.get(id).block, &mut open);
            }
        }
        for declaration in &program.declarations {
            if with_campaign.contains(&declaration.source) && !used.contains(&declaration.id) {
                self.said.push(codes::unused(declaration.block.head, declaration.form, &declaration.name));
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
/// intercepting one draws nothing, so it is tried once for each reward.
fn pedestrians(words: &[&Value], trainings: &[Training]) -> Vec<(Pedestrian, TrainingKey)> {
    let mut all = Vec::new();
    for word in words {
        let Value::Choice(word) = word else { panic!("checked: a choice") };
        let mut seen = BTreeSet::new();
        for (index, training) in trainings.iter().enumerate() {
            let pedestrian = match *word {
                "random" => Pedestrian::Random,
                "intercept" => Pedestrian::Intercept,
                "sampled" => Pedestrian::Sampled(index),
                _ => Pedestrian::Trained(index),
            };
            let mut key = training.key.clone();
            if matches!(pedestrian, Pedestrian::Random | Pedestrian::Intercept) {
                key.town = String::new();
                key.policy = String::new();
            }
            if pedestrian == Pedestrian::Intercept {
                key.run = 0;
            }
            if seen.insert((pedestrian, key.clone())) {
                all.push((pedestrian, key));
            }
        }
    }
    all
}

fn references(block: &Block, found: &mut Vec<DeclarationId>) {
    let mut note = |arguments: &Arguments| {
        for (_, value) in arguments.iter() {
            match value {
                Value::Reference(id) => found.push(*id),
                Value::List(members) => found.extend(members.iter().filter_map(|member| match member {
                    Value::Reference(id) => Some(*id),
                    _ => None,
                })),
                _ => {}
            }
        }
    };
    note(&block.arguments);
    for child in &block.children {
        references(child, found);
    }
}
