use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use super::campaign::{STOCHASTIC, TRAINED, UNTRAINED};
use super::{Cover, ExternalProgram, Fingerprint, Harden, Programs, RunId};
use base::seed::Seed;
use base::signature::{Arguments, Keys};
use learn::PpoConfig;
use world::av::CruiseKeys;
use world::av::external::ExternalKeys;
use world::av::sensors::SensorModel;
use world::driving::DriveRule;
use world::env::{Criterion, Scenario};
use world::falsifier::{Controller, Falsifier};
use world::judge::Blame;
use world::requirement::NamedRequirement;
use world::road::Town;

/// Everything that is run.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    /// The campaigns of the files the user named, in order.
    pub campaigns: Vec<Campaign>,
    /// The towns that these files declare themselves, in order.
    pub towns: Vec<NamedTown>,
    /// Campaigns of imported files, which are not run, with their files.
    pub imported_campaigns: Vec<(String, PathBuf)>,
    /// The settings from outside the files.
    pub settings: Vec<OutsideSetting>,
}

/// A setting from outside the files, and what depends on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideSetting {
    /// As `name = value`.
    pub text: String,
    /// The names of the campaigns of the plan that it reaches, and of the others.
    pub campaigns: [Vec<String>; 2],
}

/// `ppo_paper.steps = 10000 reaches fast, slow; not third`.
impl fmt::Display for OutsideSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, campaigns: [reached, others] } = self;
        match (reached.as_slice(), others.as_slice()) {
            ([], _) => write!(f, "`{text}` reaches no campaign"),
            (reached, []) => write!(f, "`{text}` reaches {}", reached.join(", ")),
            (reached, others) => write!(f, "`{text}` reaches {}, and not {}", reached.join(", "), others.join(", ")),
        }
    }
}

impl Plan {
    /// Why there is nothing to run, and what to do about it.
    pub fn without_campaigns(&self) -> String {
        match self.imported_campaigns.as_slice() {
            [] => "the files hold no campaign; write `campaign NAME { … }` to say what is to be run".into(),
            [(name, file), ..] => format!(
                "the files hold no campaign of their own, and `{name}` is imported: give its file, `{}`, to run it",
                file.display()
            ),
        }
    }

    /// A setting from outside the files, with the campaigns that it reaches.
    pub(super) fn reached_by(&self, text: String) -> OutsideSetting {
        let names = |reached: bool| {
            let chosen = self.campaigns.iter().filter(|campaign| campaign.settings.contains(&text) == reached);
            chosen.map(|campaign| campaign.name.clone()).collect()
        };
        OutsideSetting { campaigns: [names(true), names(false)], text }
    }

    /// Whether a town of this name is declared or used.
    pub fn has_town(&self, name: &str) -> bool {
        let used = self.campaigns.iter().flat_map(|campaign| &campaign.towns);
        self.towns.iter().chain(used).any(|town| town.name == name)
    }
}

impl Campaign {
    /// The programs of the user that its tasks depend on, each once.
    pub fn programs(&self) -> Vec<&Arc<ExternalProgram>> {
        let trained = self.trainings.iter().flat_map(|each| each.programs.iter());
        let evaluated = self.evaluations.iter().flat_map(|each| each.programs.iter());
        let searched = self.searches.iter().flat_map(|each| each.programs.iter());
        let estimated = self.estimations.iter().flat_map(|each| each.programs.iter());
        let covered = self.covers.iter().flat_map(|each| each.programs.iter());
        let hardened = self.hardenings.iter().flat_map(|each| each.programs.iter());
        let mut all: Vec<&Arc<ExternalProgram>> = Vec::new();
        for program in trained.chain(evaluated).chain(searched).chain(estimated).chain(covered).chain(hardened) {
            if !all.contains(&program) {
                all.push(program);
            }
        }
        all
    }

    /// One scenario for every spawn rule in every town, with the town's name, each once.
    pub fn starts(&self) -> Vec<(&str, &Arc<Scenario>)> {
        let trained = self.trainings.iter().flat_map(Training::places);
        let tried = self.evaluations.iter().map(|evaluation| (&*evaluation.town, &evaluation.scenario));
        let searched = self.searches.iter().map(|search| (search.key.town.as_str(), &search.scenario));
        let estimated = self.estimations.iter().map(|estimation| (estimation.key.town.as_str(), &estimation.scenario));
        let covered = self.covers.iter().map(|cover| (cover.key.town.as_str(), &cover.scenario));
        let hardened =
            self.hardenings.iter().flat_map(|each| each.hardening.towns.iter().chain(&each.hardening.test_towns));
        let hardened = hardened.map(|(town, scenario)| (town.as_str(), scenario));
        let mut all: Vec<(&str, &Arc<Scenario>)> = Vec::new();
        for (town, scenario) in trained.chain(tried).chain(searched).chain(estimated).chain(covered).chain(hardened) {
            if all.iter().all(|(other, known)| *other != town || known.spawn != scenario.spawn) {
                all.push((town, scenario));
            }
        }
        all
    }
}

/// A campaign: trainings, evaluations of their results, searches, and estimates.
#[derive(Debug, Clone)]
pub struct Campaign {
    pub name: String,
    /// Its documentation, one string a line.
    pub docs: Vec<String>,
    /// The settings from outside the files that it depends on, and the combination of its `matrix`, as `name = value`.
    pub settings: Vec<String>,
    /// The documented declarations that it uses, in the order of the files.
    pub words: Vec<Documented>,
    /// What it requires of episodes beside no collision, in the order of the file.
    pub requirements: Arc<[NamedRequirement]>,
    /// The towns that it uses, each once.
    pub towns: Vec<NamedTown>,
    /// The drivers that it uses, each once.
    pub drivers: Vec<Driver>,
    /// The trainings, in order of town, policy, reward, run.
    pub trainings: Vec<Training>,
    /// The evaluations, in order.
    pub evaluations: Vec<Evaluation>,
    /// The searches, in order of block, town, policy, falsifier, run.
    pub searches: Vec<Search>,
    /// The estimates, in order of block, town, policy, pedestrian, run.
    pub estimations: Vec<Estimation>,
    /// The covers, in order of block, town, policy.
    pub covers: Vec<Cover>,
    /// The drivers that are hardened, in order of block, run.
    pub hardenings: Vec<Harden>,
    /// Published results, to be compared with its figures.
    pub published: Vec<Published>,
}

/// A published table.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Where it is from.
    pub source: String,
    /// Its `///` lines; they may explain why our figures differ.
    pub docs: String,
    /// The number of trainings its figures are averaged over.
    pub runs: u32,
    pub cells: Vec<PublishedCell>,
}

/// A cell of a published table: it is compared with every cell of ours with one of these rewards, towns and policies.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedCell {
    /// Names of rewards.
    pub rewards: Vec<String>,
    /// Names of towns.
    pub towns: Vec<String>,
    /// Names of driving policies.
    pub policies: Vec<String>,
    pub figures: Vec<PublishedFigure>,
}

/// A published figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedFigure {
    /// Our column for it, without `_mean`.
    pub column: &'static str,
    /// The mean over the published runs.
    pub mean: f64,
    /// Their sample standard deviation, if it is given.
    pub sd: Option<f64>,
    /// The size of a difference that matters, if it is stated (above 0).
    pub margin: Option<f64>,
}

/// A declaration that a campaign uses, with its documentation.
#[derive(Debug, Clone, PartialEq)]
pub struct Documented {
    pub form: &'static str,
    pub name: String,
    /// Its `///` lines.
    pub docs: String,
}

/// A town under the name that the files give it.
#[derive(Debug, Clone)]
pub struct NamedTown {
    pub name: String,
    /// The roads.
    pub town: Arc<Town>,
}

/// The description of a driver in reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Driver {
    /// The name that the files give it.
    pub name: String,
    pub kind: &'static str,
    /// Its keys with their values, except `sensors`.
    pub settings: Arguments,
    /// The name of its sensors, if any.
    pub sensors: Option<String>,
    /// The model of its sensors, if any.
    pub sensor_model: Option<Arc<SensorModel>>,
    /// See [`Signature::surrogate`](base::signature::Signature::surrogate).
    pub surrogate: &'static str,
}

impl Driver {
    /// Whether it perceives no pedestrians, so that each of them can hit it. Reports show such a driver apart from those under test.
    pub fn sees_no_pedestrians(&self) -> bool {
        self.kind == CruiseKeys::KIND
    }

    /// Whether it is a program of the user.
    pub fn is_external(&self) -> bool {
        self.kind == ExternalKeys::KIND
    }
}

/// Takes the place of a reward's name in a campaign that trains no pedestrian.
pub const NO_REWARD: &str = "none";

/// The names that distinguish a training from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TrainingKey {
    /// Name of the town; names of several that are trained in together, joined by `+`.
    pub town: String,
    /// Name of the driving policy; names of several, joined by `+`.
    pub policy: String,
    pub reward: String,
    /// Number of the run, from 0.
    pub run: u32,
}

impl TrainingKey {
    /// Whether another training differs only in its run.
    pub fn is_of_same_cell(&self, other: &Self) -> bool {
        (&self.reward, &self.town, &self.policy) == (&other.reward, &other.town, &other.policy)
    }
}

/// `r1 in harbour against idm, run 0`.
impl fmt::Display for TrainingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.reward, self.town, self.policy, self.run)
    }
}

/// One training.
#[derive(Debug, Clone)]
pub struct Training {
    /// Its names.
    pub key: TrainingKey,
    /// The scenario of the training, or the first of several.
    pub scenario: Arc<Scenario>,
    /// The towns and scenarios of a training in several of them, whose episodes alternate, the first included; empty for one alone.
    pub together: Vec<(String, Arc<Scenario>)>,
    /// How a car learns to drive, where a car is trained instead of a pedestrian.
    pub drive: Option<Arc<DriveRule>>,
    /// Its settings.
    pub config: PpoConfig,
    pub environments: usize,
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
    /// The digest without the number of steps: a training with more steps continues a shorter one with the same lineage, bit for bit. None
    /// when the first steps depend on the number of all: with a schedule or a curriculum.
    pub lineage: Option<Fingerprint>,
}

impl Training {
    /// All its scenarios with the names of their towns.
    pub fn places(&self) -> impl Iterator<Item = (&str, &Arc<Scenario>)> {
        let alone = self.together.is_empty().then_some((self.key.town.as_str(), &self.scenario));
        alone.into_iter().chain(self.together.iter().map(|(town, scenario)| (town.as_str(), scenario)))
    }

    /// All its scenarios, in the order in which episodes alternate.
    pub fn scenarios(&self) -> Vec<Arc<Scenario>> {
        self.places().map(|(_, scenario)| scenario.clone()).collect()
    }

    /// The decisions in which a driver is imitated, before those of [`Training::config`].
    pub fn demonstrations(&self) -> u64 {
        self.drive.as_ref().map_or(0, |rule| rule.demonstrations.into())
    }

    /// The simulator ticks of all demonstrations and a number of further decisions.
    pub fn ticks(&self, decisions: u64) -> u64 {
        let hold = self.drive.as_ref().map_or(self.scenario.episode.hold, |rule| rule.hold);
        self.demonstrations().saturating_add(decisions.saturating_mul(hold.into()))
    }
}

/// The controller of the pedestrian of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ControllerKind {
    /// The mean of a trained policy: the training's index in [`Campaign::trainings`].
    Trained(usize),
    /// The same policy, with commands drawn from it as in training.
    Stochastic(usize),
    /// The mean of the policy with which a training begins: [`Evaluation::first`].
    First,
    /// A controller that learns nothing: a built-in one, or one that the files declare.
    Untrained(Controller),
}

impl ControllerKind {
    /// Its name in tables.
    pub fn name(&self) -> &str {
        match self {
            Self::Trained(_) => TRAINED,
            Self::Stochastic(_) => STOCHASTIC,
            Self::First => UNTRAINED,
            Self::Untrained(controller) => controller.name(),
        }
    }
}

/// One controller evaluated in one town against one policy.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Its short name.
    pub id: RunId,
    /// The controller of the pedestrian.
    pub controller: ControllerKind,
    /// Its training; for an untrained controller, the reward and run that its rows are compared with.
    pub trained: Arc<TrainingKey>,
    /// The training with whose first networks the pedestrian walks, for [`ControllerKind::First`].
    pub first: Option<Arc<Training>>,
    pub town: Arc<str>,
    /// Name of the driving policy.
    pub policy: Arc<str>,
    pub vehicle: Arc<str>,
    /// Name of the adversary, which gives the pedestrian's body and its states and actions.
    pub adversary: Arc<str>,
    /// Number of the `evaluate` block in its campaign, from 0.
    pub block: u32,
    /// The scenario of the evaluation.
    pub scenario: Arc<Scenario>,
    /// The number of episodes.
    pub episodes: u32,
    /// The digest of what the files say about it, without the training of its pedestrian.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

/// The names that distinguish a search from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SearchKey {
    /// Its short name.
    pub id: RunId,
    pub falsifier: String,
    /// Its kind.
    pub method: &'static str,
    /// Name of the reward that it maximises; empty for falsifiers without one.
    pub reward: String,
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Number of the `search` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

impl SearchKey {
    /// Whether another search differs only in its run.
    pub fn is_of_same_cell(&self, other: &Self) -> bool {
        (&self.falsifier, &self.town, &self.policy, self.block)
            == (&other.falsifier, &other.town, &other.policy, other.block)
    }
}

/// `chance in harbour against idm, run 0`.
impl fmt::Display for SearchKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.falsifier, self.town, self.policy, self.run)
    }
}

/// One falsifier that looks for failures of one policy in one town.
#[derive(Debug, Clone)]
pub struct Search {
    /// Its names.
    pub key: SearchKey,
    /// The scenario of the search.
    pub scenario: Arc<Scenario>,
    pub falsifier: Arc<dyn Falsifier>,
    /// The number of simulator ticks it may use.
    pub budget: u64,
    /// The number of fresh episodes in which its final pedestrian is evaluated, if it has one.
    pub tries: u32,
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

impl Search {
    /// The seed of its starts: the same for all falsifiers and all drivers.
    pub fn starts(&self, seed: &Seed) -> Seed {
        seed.child("search").child(&self.key.town).index(self.key.run.into())
    }

    /// The seed of what its falsifier draws.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        self.own(seed).child("search")
    }

    /// The seed of what is its own: what its falsifier draws, and the tries of its controller.
    pub fn own(&self, seed: &Seed) -> Seed {
        let key = &self.key;
        seed.child("falsifier").child(&key.town).child(&key.policy).child(&key.falsifier).index(key.run.into())
    }
}

/// The names that distinguish an estimate from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct EstimationKey {
    /// Its short name.
    pub id: RunId,
    /// Name of the pedestrian.
    pub walker: String,
    /// The requirement whose violations are estimated; empty for collisions.
    pub requirement: String,
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Number of the `estimate` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

/// `natural in harbour against idm, run 0`.
impl fmt::Display for EstimationKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { walker, town, policy, run, .. } = self;
        write!(f, "{walker} in {town} against {policy}, run {run}")
    }
}

/// An estimate of how likely failures of a driver are in a town.
#[derive(Debug, Clone)]
pub struct Estimation {
    /// Its names.
    pub key: EstimationKey,
    pub scenario: Arc<Scenario>,
    /// The pedestrian.
    pub walker: Controller,
    pub criterion: Criterion,
    /// What the relative error is about.
    pub event: Blame,
    pub relative_error: f64,
    /// The number of simulator ticks after which it ends.
    pub budget: u64,
    /// Encounters per hour and per 1,000 km, as far as the user states them.
    pub exposure: [Option<f64>; 2],
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

impl Estimation {
    /// The seed of what it draws. Equal pedestrians have equal starts against all drivers.
    pub fn drawn(&self, seed: &Seed) -> Seed {
        let key = &self.key;
        let place = seed.child("estimate").child(&key.town).child(&key.walker);
        place.child("monte_carlo").index(key.block.into()).index(key.run.into())
    }
}

/// The seed of the episodes of all evaluations in a town: the same for all drivers, controllers and rewards.
pub fn episodes_seed(seed: &Seed, town: &str) -> Seed {
    seed.child("evaluate").child(town)
}
