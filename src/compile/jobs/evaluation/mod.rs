mod block;

use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

use super::{NO_REWARD, Origin, Planned, Training, TrainingKey};
use crate::walker::{STOCHASTIC, TRAINED, UNTRAINED};
use base::seed::Seed;
pub(super) use block::BLOCK;
use episode::Scenario;
use episode::walker::Controller;

/// Number of episodes of an evaluation in one task.
pub const CHUNK: u32 = 10_000;

/// The controller of the pedestrian of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ControllerKind {
    /// The mean of the policy of the training that the evaluation needs.
    Trained,
    /// The same policy, with commands drawn from it as in training.
    Stochastic,
    /// The mean of the policy with which a training begins: [`Evaluation::first`].
    First,
    /// A controller that learns nothing: a built-in one, or one that the files declare.
    Untrained(Controller),
}

impl ControllerKind {
    /// Its name in tables.
    pub fn name(&self) -> &str {
        match self {
            Self::Trained => TRAINED,
            Self::Stochastic => STOCHASTIC,
            Self::First => UNTRAINED,
            Self::Untrained(controller) => controller.name(),
        }
    }
}

/// One controller evaluated in one town against one policy.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Where it comes from; the digest is without the training of its pedestrian.
    pub origin: Origin,
    /// The controller of the pedestrian.
    pub controller: ControllerKind,
    /// Its training; for an untrained controller, the reward and run that its rows are compared with.
    pub trained: Arc<TrainingKey>,
    /// The training with whose first networks the pedestrian walks, for [`ControllerKind::First`].
    pub first: Option<Arc<Training>>,
    pub town: Arc<str>,
    /// Name of the driver.
    pub policy: Arc<str>,
    pub vehicle: Arc<str>,
    /// Name of the adversary, which gives the pedestrian's body and its states and actions.
    pub adversary: Arc<str>,
    /// Name of the simulator in which the car drives; `here` for ours.
    pub world: Arc<str>,
    /// The scenario of the evaluation.
    pub scenario: Arc<Scenario>,
    pub episodes: u32,
}

impl Evaluation {
    /// The name of the other simulator in which the car drives; `None` if that is ours.
    fn elsewhere(&self) -> Option<&str> {
        self.scenario.external_world.as_ref().map(|_| &*self.world)
    }

    /// The episodes of one of its parts.
    pub fn chunk(&self, part: u32) -> Range<u32> {
        let start = part * CHUNK;
        start..self.episodes.min(start.saturating_add(CHUNK))
    }
}

impl Planned for Evaluation {
    /// Controller, town and driver.
    fn title(&self) -> String {
        let key = &self.trained;
        let here = (&*self.town, &*self.policy);
        let who = match &self.controller {
            ControllerKind::Trained if (key.town.as_str(), key.policy.as_str()) == here => key.reward.clone(),
            ControllerKind::Trained => format!("{} of {} and {}", key.reward, key.town, key.policy),
            ControllerKind::Stochastic => format!("stochastic {} of {} and {}", key.reward, key.town, key.policy),
            other if key.reward == NO_REWARD => other.name().to_string(),
            other => format!("{} ({})", other.name(), key.reward),
        };
        let elsewhere = self.elsewhere().map_or_else(String::new, |world| format!(" of {world}"));
        format!("{who} in {}{elsewhere} against {}, run {}", here.0, here.1, key.run)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&*self.town, &self.scenario)]
    }

    fn parts(&self) -> u32 {
        self.episodes.div_ceil(CHUNK)
    }

    fn units(&self, part: u32) -> u64 {
        self.chunk(part).len() as u64
    }

    fn ticks(&self, part: u32) -> u64 {
        self.units(part) * u64::from(self.scenario.episode.ticks)
    }

    /// The number of episodes does not belong to it: the first ones are the same for any number.
    fn inputs(&self) -> String {
        let Self { controller, trained, first, town, policy, origin: Origin { fingerprint, .. }, .. } = self;
        let first = first.as_ref().map(|training| training.inputs());
        let world = self.elsewhere().map_or_else(String::new, |world| format!(" {world:?}"));
        format!("evaluation {town:?} {policy:?} {:?} {} {fingerprint} {first:?}{world}", controller.name(), trained.run)
    }

    fn depends_on_processor(&self) -> bool {
        self.first.as_ref().is_some_and(|training| training.depends_on_processor())
    }

    fn shorten(&mut self) {
        self.episodes = self.episodes.min(5);
    }

    fn names(&self, needed: Option<&dyn Planned>) -> Vec<String> {
        let TrainingKey { reward, town, policy, run } = &*self.trained;
        let (controller, Origin { block, fingerprint, .. }) = (self.controller.name(), &self.origin);
        let own = [block as &dyn ToString, &controller, reward, town, policy, run];
        let place = [&self.town as &dyn ToString, &self.policy, &self.vehicle, &self.adversary, fingerprint];
        let training = needed.and_then(|job| (job as &dyn Any).downcast_ref::<Training>()).or(self.first.as_deref());
        // A smoke run takes fewer steps than the files say.
        let training =
            training.map(|training| [training.origin.fingerprint.to_string(), training.config.steps.to_string()]);
        let own = own.into_iter().chain(place).map(ToString::to_string).chain(training.into_iter().flatten());
        own.chain(self.elsewhere().map(ToString::to_string)).collect()
    }
}

/// The seed of the episodes of all evaluations in a town: the same for all drivers, controllers and rewards.
pub fn episodes_seed(seed: &Seed, town: &str) -> Seed {
    seed.child("evaluate").child(town)
}
