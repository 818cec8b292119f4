use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use super::{Fingerprint, RunId};
use crate::av::sensors::SensorModel;
use crate::env::Scenario;
use crate::falsifier::Falsifier;
use crate::rl::PpoConfig;
use crate::road::Town;
use crate::signature::Arguments;

/// Everything that is to be run.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    /// The campaigns of the files the user named, in order.
    pub campaigns: Vec<Campaign>,
    /// The towns that these files declare themselves, in order.
    pub towns: Vec<NamedTown>,
    /// Campaigns of imported files, which are not run, with their files.
    pub imported_campaigns: Vec<(String, PathBuf)>,
}

impl Plan {
    /// Why nothing is to be run, and what to do about it.
    pub fn without_campaigns(&self) -> String {
        match self.imported_campaigns.as_slice() {
            [] => "the files hold no campaign; write `campaign NAME { … }` to say what is to be run".into(),
            [(name, file), ..] => format!(
                "the files hold no campaign of their own, and `{name}` is imported: give its file, `{}`, to run it",
                file.display()
            ),
        }
    }

    /// Whether a town of this name is declared or used.
    pub fn has_town(&self, name: &str) -> bool {
        let used = self.campaigns.iter().flat_map(|campaign| &campaign.towns);
        self.towns.iter().chain(used).any(|town| town.name == name)
    }
}

impl Campaign {
    /// One scenario for every spawn rule in every town, with the town's name, each once.
    pub fn starts(&self) -> Vec<(&str, &Arc<Scenario>)> {
        let trained = self.trainings.iter().map(|training| (training.key.town.as_str(), &training.scenario));
        let tried = self.evaluations.iter().map(|evaluation| (&*evaluation.town, &evaluation.scenario));
        let searched = self.searches.iter().map(|search| (search.key.town.as_str(), &search.scenario));
        let mut all: Vec<(&str, &Arc<Scenario>)> = Vec::new();
        for (town, scenario) in trained.chain(tried).chain(searched) {
            if all.iter().all(|(other, known)| *other != town || known.spawn != scenario.spawn) {
                all.push((town, scenario));
            }
        }
        all
    }
}

/// A campaign: trainings, and evaluations of what they bring forth.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Its name.
    pub name: String,
    /// Its documentation, one string a line.
    pub docs: Vec<String>,
    /// What was set from outside the files, and the combination of its `matrix`, as `name = value`.
    pub settings: Vec<String>,
    /// The documented declarations that it uses, in the order of the files.
    pub words: Vec<Documented>,
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
    /// What others have published, to stand beside its figures.
    pub published: Vec<Published>,
}

/// A published table.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Where it is from.
    pub source: String,
    /// What its `///` lines say: why ours differ, perhaps.
    pub docs: String,
    /// How many trainings its figures are averaged over.
    pub runs: u32,
    /// Its cells.
    pub cells: Vec<PublishedCell>,
}

/// A cell of a published table: it stands beside every cell of ours with one of these rewards, towns and policies.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedCell {
    /// Names of rewards.
    pub rewards: Vec<String>,
    /// Names of towns.
    pub towns: Vec<String>,
    /// Names of driving policies.
    pub policies: Vec<String>,
    /// Its figures.
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
}

/// A declaration that a campaign uses, with its documentation.
#[derive(Debug, Clone, PartialEq)]
pub struct Documented {
    /// Its form.
    pub form: &'static str,
    /// Its name.
    pub name: String,
    /// What its `///` lines say.
    pub docs: String,
}

/// A town under the name that the files give it.
#[derive(Debug, Clone)]
pub struct NamedTown {
    /// The name.
    pub name: String,
    /// The roads.
    pub town: Arc<Town>,
}

/// What a driver is, for those who read its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Driver {
    /// The name that the files give it.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Its keys with their values, but for `sensors`.
    pub settings: Arguments,
    /// The name of its sensors, if it has any.
    pub sensors: Option<String>,
    /// What they are, if it has any.
    pub sensor_model: Option<Arc<SensorModel>>,
    /// See [`Signature::surrogate`](crate::signature::Signature::surrogate).
    pub surrogate: &'static str,
}

/// What distinguishes a training from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TrainingKey {
    /// Name of the town.
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Name of the reward.
    pub reward: String,
    /// Number of the run, from 0.
    pub run: u32,
}

impl TrainingKey {
    /// Whether another training differs in its run alone.
    pub fn is_of_same_cell(&self, other: &Self) -> bool {
        (&self.reward, &self.town, &self.policy) == (&other.reward, &other.town, &other.policy)
    }
}

/// `r1 in harbour against careful, run 0`.
impl fmt::Display for TrainingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.reward, self.town, self.policy, self.run)
    }
}

/// One training.
#[derive(Debug, Clone)]
pub struct Training {
    /// What it is.
    pub key: TrainingKey,
    /// What is trained in.
    pub scenario: Arc<Scenario>,
    /// How.
    pub config: PpoConfig,
    /// In how many environments.
    pub environments: usize,
    /// What the files say about it.
    pub fingerprint: Fingerprint,
}

/// What controls the pedestrian of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ControllerKind {
    /// The result of a training, which takes the mean of its policy: the training's place in [`Campaign::trainings`].
    Trained(usize),
    /// The same, which draws its commands from its policy, as in training.
    Sampled(usize),
    /// Draws every command uniformly from its range.
    Random,
    /// Walks straight at the ego.
    Homing,
    /// Walks to where it would meet an ego that keeps its velocity.
    Intercept,
}

impl ControllerKind {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trained(_) => "trained",
            Self::Sampled(_) => "sampled",
            Self::Random => "random",
            Self::Homing => "homing",
            Self::Intercept => "intercept",
        }
    }
}

/// One pedestrian tried in one town against one policy.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Its short name.
    pub id: RunId,
    /// What controls the pedestrian.
    pub controller: ControllerKind,
    /// What it was trained in; for the untrained ones, whose reward and run these rows are compared with.
    pub trained: Arc<TrainingKey>,
    /// Name of the town.
    pub town: Arc<str>,
    /// Name of the driving policy.
    pub policy: Arc<str>,
    /// Name of the vehicle.
    pub vehicle: Arc<str>,
    /// Name of the adversary, whose body and reading of states and actions the pedestrian takes over.
    pub adversary: Arc<str>,
    /// Number of the `evaluate` block in its campaign, from 0.
    pub block: u32,
    /// What is tried.
    pub scenario: Arc<Scenario>,
    /// How many episodes, at most when there is a half-width.
    pub episodes: u32,
    /// What the files say about it, without how its pedestrian was trained.
    pub fingerprint: Fingerprint,
    /// The half-width of the collision rate's 95 % interval at which it ends before that.
    pub halfwidth: Option<f64>,
}

/// What distinguishes a search from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SearchKey {
    /// Its short name.
    pub id: RunId,
    /// Name of the falsifier.
    pub falsifier: String,
    /// Its kind.
    pub method: &'static str,
    /// Name of the reward that it maximises; empty for those that know none.
    pub reward: String,
    /// Name of the town.
    pub town: String,
    /// Name of the driving policy.
    pub policy: String,
    /// Number of the `search` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

impl SearchKey {
    /// Whether another search differs in its run alone.
    pub fn is_of_same_cell(&self, other: &Self) -> bool {
        (&self.falsifier, &self.town, &self.policy, self.block)
            == (&other.falsifier, &other.town, &other.policy, other.block)
    }
}

/// `chance in harbour against careful, run 0`.
impl fmt::Display for SearchKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.falsifier, self.town, self.policy, self.run)
    }
}

/// One falsifier that looks for failures of one policy in one town.
#[derive(Debug, Clone)]
pub struct Search {
    /// What it is.
    pub key: SearchKey,
    /// What is searched.
    pub scenario: Arc<Scenario>,
    /// By whom.
    pub falsifier: Arc<dyn Falsifier>,
    /// How many simulator ticks it may use.
    pub budget: u64,
    /// In how many fresh episodes the pedestrian that it ends up with is tried, if it has one.
    pub tries: u32,
    /// What the files say about it.
    pub fingerprint: Fingerprint,
}
