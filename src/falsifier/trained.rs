use super::Walker;
use crate::env::PedestrianEnv;
use crate::rl::{ActorCritic, Scratch};
use crate::seed::Stream;
use crate::sim::WalkCommand;

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

    fn twin(&self) -> Option<Box<dyn Walker>> {
        Some(Box::new(self.clone()))
    }
}
