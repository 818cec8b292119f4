mod block;

use std::fmt;
use std::sync::Arc;

use super::{Origin, Planned};
use crate::Fingerprint;
use base::seed::Seed;
pub(super) use block::{BLOCK, joined};
use episode::Scenario;
use learn::PpoConfig;
use search::driving::DriveRule;

/// Takes the place of a reward's name in a campaign that trains no pedestrian.
pub const NO_REWARD: &str = "none";

/// Maximum number of demonstrations in a quick check.
const SHORT_DEMONSTRATIONS: u32 = 1000;
/// Maximum number of candidates in a quick check.
const SHORT_CANDIDATES: u32 = 2;

/// The names that distinguish a training from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TrainingKey {
    /// Name of the town; names of several that are trained in together, joined by `+`.
    pub town: String,
    /// Name of the driver; names of several, joined by `+`.
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

    /// The seed of the training.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("train").child(&self.town).child(&self.policy).child(&self.reward).index(self.run.into())
    }
}

/// `r1 in harbour against idm, run 0`.
impl fmt::Display for TrainingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}, run {}", self.reward, self.town, self.policy, self.run)
    }
}

#[derive(Debug, Clone)]
pub struct Training {
    pub origin: Origin,
    pub key: TrainingKey,
    /// The scenario of the training, or the first of several.
    pub scenario: Arc<Scenario>,
    /// Its towns and scenarios, whose episodes alternate, the first included.
    pub towns: Vec<(String, Arc<Scenario>)>,
    /// How a car learns to drive, where a car is trained instead of a pedestrian.
    pub drive: Option<Arc<DriveRule>>,
    /// Its settings.
    pub config: PpoConfig,
    /// Number of trainings with different seeds, of which the one that does best on validation starts is kept.
    pub candidates: u32,
    /// The digest without the number of steps: a training with more steps continues a shorter one with the same lineage, bit for bit. None
    /// when the first steps depend on the number of all: with a schedule.
    pub lineage: Option<Fingerprint>,
}

impl Training {
    /// All its scenarios, in the order in which episodes alternate.
    pub fn scenarios(&self) -> Vec<Arc<Scenario>> {
        self.towns.iter().map(|(_, scenario)| scenario.clone()).collect()
    }

    /// The decisions in which a driver is imitated, before those of [`Training::config`].
    pub fn demonstrations(&self) -> u64 {
        self.drive.as_ref().map_or(0, |rule| rule.demonstrations.into())
    }

    /// Whether its candidates are compared.
    pub fn is_validated(&self) -> bool {
        self.candidates > 1
    }

    pub fn candidate_seed(&self, candidate: u32, seed: &Seed) -> Seed {
        let seed = self.key.seed(seed);
        if candidate == 0 { seed } else { seed.child("candidate").index(candidate.into()) }
    }

    /// The simulator ticks of all demonstrations and a number of further decisions.
    pub fn ticks_of(&self, decisions: u64) -> u64 {
        let hold = self.drive.as_ref().map_or(self.scenario.episode.hold, |rule| rule.hold);
        self.demonstrations().saturating_add(decisions.saturating_mul(hold.into()))
    }
}

impl Planned for Training {
    fn title(&self) -> String {
        self.key.to_string()
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        self.towns.iter().map(|(town, scenario)| (town.as_str(), scenario)).collect()
    }

    fn parts(&self) -> u32 {
        self.candidates
    }

    fn units(&self, _: u32) -> u64 {
        self.demonstrations() + self.config.steps
    }

    fn ticks(&self, _: u32) -> u64 {
        self.ticks_of(self.config.steps)
    }

    fn inputs(&self) -> String {
        let Self { key, origin, config, .. } = self;
        let steps = config.steps;
        format!("training {key:?} {} {steps} {} {}", origin.fingerprint, self.demonstrations(), self.candidates)
    }

    fn depends_on_processor(&self) -> bool {
        !self.config.portable_bits
    }

    fn lineage(&self) -> Option<Fingerprint> {
        self.lineage
    }

    fn shorten(&mut self) {
        let update = (self.config.steps_per_update * self.config.environments) as u64;
        self.config.steps = self.config.steps.min(2 * update);
        self.candidates = self.candidates.min(SHORT_CANDIDATES);
        if let Some(rule) = &mut self.drive {
            let rule = Arc::make_mut(rule);
            rule.demonstrations = rule.demonstrations.min(SHORT_DEMONSTRATIONS);
        }
    }
}
