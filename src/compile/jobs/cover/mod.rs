mod block;

use std::sync::Arc;

use super::{Origin, Planned};
use base::seed::Seed;
pub(super) use block::BLOCK;
use episode::walker::Controller;
use episode::{Criterion, Scenario};
use verdict::Blame;

/// The words of what it counts.
const FAULT: &str = "fault";
const COLLISION: &str = "collision";

/// One box of starts of one policy in one town.
#[derive(Debug, Clone)]
pub struct Cover {
    pub origin: Origin,
    /// Name of the pedestrian that walks.
    pub pedestrian: String,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    /// Name of the spawn rule.
    pub spawn: String,
    pub scenario: Arc<Scenario>,
    pub walker: Controller,
    /// What it counts.
    pub criterion: Criterion,
    pub blame: Blame,
    /// The share of the box that is small enough.
    pub epsilon: f64,
    /// The greatest number of episodes.
    pub budget: u32,
    /// The parameters of the picture, by their places in [`Scenario::start_parameters`]: one or two.
    pub picture: Vec<usize>,
}

impl Cover {
    /// The name of what it counts.
    pub fn failure_name(&self) -> &str {
        match (self.criterion, self.blame) {
            (Criterion::Collision, Blame::Fault) => FAULT,
            (Criterion::Collision, _) => COLLISION,
            (Criterion::Violation(place), _) => self.scenario.requirements.get(place).map_or("", |named| &*named.name),
        }
    }

    /// The names of the parameters of the box.
    pub fn parameter_names(&self) -> Vec<&'static str> {
        self.scenario.start_parameters().iter().map(|drawn| drawn.parameter.name()).collect()
    }

    /// The seed of all that it draws: the same for all drivers.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("cover").child(&self.town).index(self.origin.block.into())
    }
}

impl Planned for Cover {
    /// `near by natural in harbour against idm`.
    fn title(&self) -> String {
        format!("{} by {} in {} against {}", self.spawn, self.pedestrian, self.town, self.policy)
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        vec![(&self.town, &self.scenario)]
    }

    fn units(&self, _: u32) -> u64 {
        self.budget.into()
    }

    fn ticks(&self, part: u32) -> u64 {
        self.units(part) * u64::from(self.scenario.episode.ticks)
    }

    fn shorten(&mut self) {
        self.budget = self.budget.min(30);
    }

    fn names(&self, _: Option<&dyn Planned>) -> Vec<String> {
        let Self { origin: Origin { block, fingerprint, .. }, pedestrian, town, policy, epsilon, budget, .. } = self;
        let (failure, epsilon) = (self.failure_name(), format!("{epsilon:?}"));
        let all: [&dyn ToString; 9] =
            [&"cover", block, pedestrian, town, policy, fingerprint, &failure, &epsilon, budget];
        all.map(ToString::to_string).into()
    }
}
