use std::ops::ControlFlow;
use std::sync::Arc;

use super::Walker;
use crate::env::{PedestrianEnv, Scenario};
use crate::rl::{self, ActorCritic, PpoConfig, Scratch, TrainError, Trained, UpdateLog};
use crate::seed::{Seed, Stream};
use crate::sim::WalkCommand;

/// Trains a pedestrian in so many environments of a scenario, each with its own stream of episodes.
///
/// # Errors
/// A loss that is no number, with its update; or that the observer broke.
pub fn train(
    scenario: &Arc<Scenario>,
    environments: usize,
    config: &PpoConfig,
    seed: &Seed,
    observer: &mut dyn FnMut(&UpdateLog) -> ControlFlow<()>,
) -> Result<Trained, TrainError> {
    let episodes = seed.child("episodes");
    let mut envs: Vec<PedestrianEnv> =
        (0..environments as u64).map(|env| PedestrianEnv::new(scenario.clone(), episodes.index(env))).collect();
    rl::train(&mut envs, config, &seed.child("ppo"), observer)
}

/// How a trained pedestrian chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choosing {
    /// It does what it thinks best: the mean of its policy.
    Mean,
    /// It draws from its policy, as in training.
    Sampling,
}

/// A trained pedestrian.
#[derive(Debug, Clone)]
pub struct TrainedWalker {
    actor_critic: ActorCritic,
    scratch: Scratch,
    choosing: Choosing,
    stream: Option<Stream>,
}

impl TrainedWalker {
    /// Takes over a policy.
    pub fn new(actor_critic: ActorCritic, choosing: Choosing) -> Self {
        Self { scratch: actor_critic.scratch(1), actor_critic, choosing, stream: None }
    }
}

impl Walker for TrainedWalker {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand {
        let mut action = [0.0; 2];
        match (self.choosing, &mut self.stream) {
            (Choosing::Sampling, Some(stream)) => {
                self.actor_critic.sample(&env.state(), &mut action, &mut self.scratch, stream);
            }
            _ => self.actor_critic.act(&env.state(), &mut action, &mut self.scratch),
        }
        let bounds = env.scenario().adversary.action_bounds();
        for (component, (low, high)) in action.iter_mut().zip(bounds) {
            *component = component.clamp(low, high);
        }
        env.command(action)
    }
}
