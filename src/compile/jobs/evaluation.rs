use std::ops::Range;
use std::sync::Arc;

use super::{Job, Planned, Training, TrainingKey};
use crate::campaign::{STOCHASTIC, TRAINED, UNTRAINED};
use crate::{Fingerprint, Programs, RunId};
use base::seed::Seed;
use world::env::Scenario;
use world::falsifier::Controller;

/// Number of episodes of an evaluation in one task.
pub const CHUNK: u32 = 10_000;

/// The controller of the pedestrian of an evaluation.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ControllerKind {
    /// The mean of a trained policy: the training's place in [`Campaign::jobs`](crate::Campaign::jobs).
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

impl Evaluation {
    /// The episodes of one of its parts.
    pub fn chunk(&self, part: u32) -> Range<u32> {
        let start = part * CHUNK;
        start..self.episodes.min(start.saturating_add(CHUNK))
    }
}

impl Planned for Evaluation {
    fn run_number(&self) -> u32 {
        self.trained.run
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&*self.town, &self.scenario)]
    }

    fn programs(&self) -> &Programs {
        &self.programs
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn needs(&self) -> Option<usize> {
        match self.controller {
            ControllerKind::Trained(training) | ControllerKind::Stochastic(training) => Some(training),
            ControllerKind::First | ControllerKind::Untrained(_) => None,
        }
    }

    fn needs_mut(&mut self) -> Option<&mut usize> {
        match &mut self.controller {
            ControllerKind::Trained(training) | ControllerKind::Stochastic(training) => Some(training),
            ControllerKind::First | ControllerKind::Untrained(_) => None,
        }
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
        let Self { controller, trained, first, town, policy, fingerprint, .. } = self;
        let first = first.as_ref().map(|training| training.inputs());
        format!("evaluation {town:?} {policy:?} {:?} {} {fingerprint} {first:?}", controller.name(), trained.run)
    }

    fn depends_on_processor(&self) -> bool {
        self.first.as_ref().is_some_and(|training| training.depends_on_processor())
    }

    fn shorten(&mut self) {
        self.episodes = self.episodes.min(5);
    }

    fn names(&self, jobs: &[Job]) -> Option<Vec<String>> {
        let TrainingKey { reward, town, policy, run } = &*self.trained;
        let controller = self.controller.name();
        let own = [&self.block as &dyn ToString, &controller, reward, town, policy, run];
        let place = [&self.town as &dyn ToString, &self.policy, &self.vehicle, &self.adversary, &self.fingerprint];
        let training = self.needs().and_then(|place| jobs[place].of::<Training>()).or(self.first.as_deref());
        // A smoke run takes fewer steps than the files say.
        let training =
            training.map(|training| [training.fingerprint.to_string(), training.config.total_steps.to_string()]);
        Some(own.into_iter().chain(place).map(ToString::to_string).chain(training.into_iter().flatten()).collect())
    }

    fn id(&self) -> Option<RunId> {
        Some(self.id)
    }

    fn id_mut(&mut self) -> Option<&mut RunId> {
        Some(&mut self.id)
    }
}

/// The seed of the episodes of all evaluations in a town: the same for all drivers, controllers and rewards.
pub fn episodes_seed(seed: &Seed, town: &str) -> Seed {
    seed.child("evaluate").child(town)
}
