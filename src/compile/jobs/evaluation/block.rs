use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{ControllerKind, Evaluation};
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Grid, Nested, of_places};
use crate::jobs::{JobBlock, NO_REWARD, Origin, Training, TrainingKey};
use crate::lowering::Lowering;
use crate::walker::{STOCHASTIC, TRAINED, UNTRAINED};
use crate::{Campaign, Job};
use base::diagnostic::Diagnostic;
use base::keys;
use base::signature::{DeclarationId, Keys, Value};
use episode::{HERE, RewardRule, Scenario};
use lang::diagnostics;
use lang::hir::Block;
use learn::Policies;

keys! {
    /// Tries every pedestrian in every town against every driver.
    pub struct EvaluateKeys = "evaluate" {
        ..places: PlaceKeys,
        /// Episodes of each; all pedestrians have the same starts. By default 1,000, and of the `scripted` target of a test, if it alone walks, one for each of its cases.
        episodes: Option<u32> as whole(1, 1_000_000),
        // The catalogue adds the words of the others.
        /// Which pedestrians walk: trained ones with the mean action of their policy (`trained`) or drawing from it as in
        /// training (`stochastic`), the same network before its training (`untrained`), one that acts at random, one that walks straight at the ego (`homing`), one that walks to where it
        /// would meet the ego (`intercept`), one that crosses as recorded pedestrians do (`natural`), the target of a test
        /// (`scripted`), or a `pedestrian` of the file. Only the first three need a `train` block.
        pedestrians: Vec<Value> as WordOrReference(vec![TRAINED, STOCHASTIC, UNTRAINED], "pedestrian") = "[trained, random]",
        /// Models of car to try them against, instead of the campaign's `vehicle`.
        vehicles: Option<Vec<DeclarationId>> as Reference("vehicle"),
        /// Bodies, instead of the campaign's.
        bodies: Option<Vec<DeclarationId>> as Reference("body"),
        /// Simulators in which these episodes happen: ours (`here`), or a `world` of the file. All have the same starts and the same pedestrians.
        worlds: Vec<Value> as WordOrReference(vec![HERE], "world") = "[here]",
        ..start: StartKeys,
    }
    .explained("towns", "Towns to try them in.")
    .explained("drivers", "Drivers to try them against.")
}

/// The word of the targets of tests.
const SCRIPTED: &str = "scripted";
/// The number of episodes where a block gives none.
const USUAL_EPISODES: u32 = 1_000;

pub(crate) const BLOCK: JobBlock =
    JobBlock { signature: EvaluateKeys::signature, drivers: of_places, lower: |it, at, grid| it.evaluate(at, grid) };

impl Lowering<'_> {
    fn evaluate(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let block = at.block;
        let EvaluateKeys { places, episodes, pedestrians, vehicles, bodies: adversaries, worlds, start } = block.keys();
        let cars = vehicles.map(|ids| ids.into_iter().map(|id| self.vehicle(id)).collect());
        let walkers = adversaries.map(|ids| ids.into_iter().map(|id| self.adversary(id)).collect());
        let cars: Vec<_> = cars.unwrap_or_else(|| vec![grid.usual.car.clone()]);
        let walkers: Vec<_> = walkers.unwrap_or_else(|| vec![grid.usual.walker.clone()]);
        let bodies = || cars.iter().flat_map(|car| walkers.iter().map(move |walker| (car, walker)));
        let all: Vec<_> = bodies().collect();
        let Some(ground) = self.ground(at, &places, &start, &all, &grid.usual) else { return };
        let Some(worlds) = self.worlds(&worlds) else { return };
        if !self.worlds_fit(block, &worlds, &ground, &grid.usual.rule.value) {
            return;
        }
        let untrained = at.campaign.nested("train").next().is_none();
        if untrained && pedestrians.iter().any(|word| matches!(word, Value::Choice(TRAINED | STOCHASTIC | UNTRAINED))) {
            return self.said.push(diagnostics::trained_without_training(block.place("pedestrians")));
        }
        let has_script = ground.spawn.value.scripted().is_some();
        let Some(chosen) = self.chosen(block, &pedestrians, has_script) else { return };
        if !untrained && grid.campaign.all::<Training>().next().is_none() {
            // The block `train` has a mistake, which is reported there.
            return;
        }
        let test = ground.spawn.value.target_walk.as_ref().filter(|_| pedestrians.contains(&Value::Choice(SCRIPTED)));
        if let (Some(_), None) = (&ground.spawn.value.target_walk, test) {
            self.said.push(diagnostics::untested(block.place("pedestrians"), &ground.spawn.name));
        }
        let cases = test.map(|walk| walk.cases.len() as u32);
        let rule = &grid.usual.rule;
        let tests = cases.is_some();
        if tests
            && !(self.walks_test(at, &ground, &all, true, rule.value.tick) && self.can_fail(at, &ground, &all, rule))
        {
            return;
        }
        if let (Some(episodes), Some(cases)) = (episodes, cases)
            && episodes % cases != 0
        {
            self.said.push(diagnostics::partial_test(block.place("episodes"), episodes, cases));
        }
        let of_test = cases.filter(|_| pedestrians.len() == 1);
        let episodes = episodes.or(of_test).unwrap_or(USUAL_EPISODES);
        let controllers =
            if untrained { untrained_controllers(&chosen) } else { controllers(&chosen, &grid.campaign.jobs) };
        let each = controllers.len().max(grid.rewards.len());
        if !self.takes(at, &ground, [all.len() * worlds.len(), each], grid) {
            return;
        }
        let Grid { usual, campaign, rewards } = grid;
        let places = worlds.iter().flat_map(|world| ground.places().map(move |place| (world, place)));
        for (world, place, (car, walker)) in
            places.flat_map(|(world, place)| bodies().map(move |body| (world, place, body)))
        {
            let mut ground =
                [place.declarations(car, walker, &usual.rule).as_slice(), &usual.requirements.ids].concat();
            ground.extend(world.as_ref().map(|world| world.id));
            let mut scenario = |rule: &RewardRule, declared: &[DeclarationId]| {
                let scenario = place.scenario(car, walker, &usual.rule, rule, &usual.requirements.all);
                let external_world = world.as_ref().map(|world| world.value.clone());
                let scenario = Arc::new(Scenario { external_world, ..Scenario::clone(&scenario) });
                let parts = [ground.as_slice(), declared].concat();
                (scenario, self.origins(at, 1, &parts).next().expect("one run has one origin"))
            };
            let mut scenarios: BTreeMap<(&str, Option<DeclarationId>), _> = BTreeMap::new();
            for declared in std::iter::once(None).chain(chosen.iter().map(|each| each.declared).filter(Option::is_some))
            {
                for (name, reward) in &*rewards {
                    let own = [Some(reward.id), declared].into_iter().flatten().collect::<Vec<_>>();
                    scenarios.insert((name, declared), scenario(&reward.value, &own));
                }
                if untrained {
                    let own: Vec<_> = declared.into_iter().collect();
                    scenarios.insert((NO_REWARD, declared), scenario(&RewardRule::default(), &own));
                }
            }
            for each in &chosen {
                let ControllerKind::Untrained(controller) = &each.controller else { continue };
                let (scenario, _) = scenarios.values().next().expect("there is a scenario");
                let (policy, place) = (controller.walk_policy(), block.place("pedestrians"));
                if let Err(reason) = policy.fits(&scenario.cast, &scenario.episode) {
                    self.said.push(diagnostics::unfit_pedestrian(place, controller.name(), &walker.name, reason));
                } else if let Some(difference) = policy.differs(&scenario.cast, &scenario.episode) {
                    let message = format!("`{}` was trained otherwise: {difference}", controller.name());
                    let warning = Diagnostic::warning("unfit-pedestrian", place, message);
                    self.said.push(warning.help("give it the `body` and the `hold` of its training"));
                }
            }
            let of = |controller: &ControllerKind, trained: &TrainingKey| {
                let declared = chosen.iter().find(|each| each.controller == *controller).and_then(|each| each.declared);
                scenarios[&(trained.reward.as_str(), declared)].clone()
            };
            let shared = usual.training.as_ref().is_some_and(|axis| axis.value.policies == Some(Policies::Shared));
            for (controller, trained, _) in &controllers {
                let training = campaign.all::<Training>().find(|training| training.key == **trained);
                let state = |scenario: &Scenario| {
                    let mut dims: Vec<usize> =
                        scenario.cast.controlled().map(|(_, role)| role.observation.dim()).collect();
                    dims.dedup_by(|one, other| shared && one == other);
                    dims
                };
                if !matches!(controller, ControllerKind::Untrained(_))
                    && training.is_some_and(|training| state(&training.scenario) != state(&of(controller, trained).0))
                {
                    let (place, reason) = (block.place("pedestrians"), "its training saw states of another size");
                    self.said.push(diagnostics::unfit_pedestrian(place, controller.name(), &walker.name, reason));
                    return;
                }
            }
            let evaluations = controllers.iter().map(|(controller, trained, needs)| {
                let (scenario, origin) = of(controller, trained);
                Job::from(Evaluation {
                    origin: Origin { run: trained.run, needs: *needs, ..origin },
                    controller: controller.clone(),
                    trained: trained.clone(),
                    first: (*controller == ControllerKind::First).then(|| first_of(campaign, trained)),
                    town: place.town.name.clone(),
                    policy: place.policy.name.clone(),
                    vehicle: car.name.clone(),
                    adversary: walker.name.clone(),
                    world: world.as_ref().map_or_else(|| HERE.into(), |world| world.name.clone()),
                    scenario,
                    episodes,
                })
            });
            let evaluations: Vec<Job> = evaluations.collect();
            campaign.jobs.extend(evaluations);
        }
    }
}

/// A member of the list of pedestrians.
struct Chosen {
    controller: ControllerKind,
    /// Whether it draws, or begins as a training does, so that every run is another.
    draws: bool,
    /// The declaration that it comes from, if it is not built in.
    declared: Option<DeclarationId>,
}

impl Lowering<'_> {
    /// The chosen controllers; `None` after reporting what is wrong with one.
    fn chosen(&mut self, block: &Block, words: &[Value], has_script: bool) -> Option<Vec<Chosen>> {
        let each = |word: &Value| {
            let (controller, draws, declared) = match word {
                Value::Choice(TRAINED) => (ControllerKind::Trained, true, None),
                Value::Choice(STOCHASTIC) => (ControllerKind::Stochastic, true, None),
                Value::Choice(UNTRAINED) => (ControllerKind::First, true, None),
                word => {
                    let (controller, declared) = self.untrained(block, "pedestrians", word, has_script)?;
                    let draws = declared.is_none() && self.walker_kind(word).draws;
                    (ControllerKind::Untrained(controller), draws, declared)
                }
            };
            Some(Chosen { controller, draws, declared })
        };
        words.iter().map(each).collect()
    }
}

/// A controller, its training, and the place of the job that it needs.
type ControllerOf = (ControllerKind, Arc<TrainingKey>, Option<usize>);

/// The controllers of a campaign without training: each once, for no reward.
fn untrained_controllers(chosen: &[Chosen]) -> Vec<ControllerOf> {
    let reward = NO_REWARD.to_string();
    let key = Arc::new(TrainingKey { town: String::new(), policy: String::new(), reward, run: 0 });
    chosen.iter().map(|each| (each.controller.clone(), key.clone(), None)).collect()
}

/// The key of a controller without training, whose rows are compared with those of a reward.
fn without_place(key: &TrainingKey, run: u32) -> TrainingKey {
    TrainingKey { town: String::new(), policy: String::new(), reward: key.reward.clone(), run }
}

/// The first training for the reward of a key with its run: its first networks stand for those of all such trainings.
fn first_of(campaign: &Campaign, key: &TrainingKey) -> Arc<Training> {
    let found = campaign.all::<Training>().find(|each| (&each.key.reward, each.key.run) == (&key.reward, key.run));
    Arc::new(found.expect("the key is made of a training").clone())
}

/// The controllers of a campaign with trainings: every trained one, and for every run of a reward one that draws, with draws of its own, and
/// the networks with which a training begins. One that draws nothing is evaluated once for each reward; so is a declared one.
fn controllers(chosen: &[Chosen], jobs: &[Job]) -> Vec<ControllerOf> {
    let mut all = Vec::new();
    for each in chosen {
        let mut seen = BTreeSet::new();
        let trainings = jobs.iter().enumerate().filter_map(|(place, job)| Some((place, job.of::<Training>()?)));
        for (index, Training { key, .. }) in trainings.filter(|(_, each)| each.drive.is_none()) {
            let is_trained = matches!(each.controller, ControllerKind::Trained | ControllerKind::Stochastic);
            let run = if each.draws { key.run } else { 0 };
            let key = Arc::new(if is_trained { key.clone() } else { without_place(key, run) });
            if seen.insert(key.clone()) {
                all.push((each.controller.clone(), key, is_trained.then_some(index)));
            }
        }
    }
    all
}
