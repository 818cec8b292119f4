use super::Walker;
use crate::env::PedestrianEnv;
use crate::rl::{ActorCritic, FrameStack, Scratch};
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
///
/// It sees as many of the last states as in training, and normalises them as at the end of it.
#[derive(Debug, Clone)]
pub struct TrainedWalker {
    actor_critic: ActorCritic,
    scratch: Scratch,
    choosing: Choosing,
    stream: Option<Stream>,
    /// The last states of the episode.
    stack: FrameStack,
    /// Whether the first decision of the episode has been taken.
    begun: bool,
}

impl TrainedWalker {
    /// Takes over a policy.
    ///
    /// # Panics
    /// When it does not expect one or several states of [`PedestrianEnv::STATE_DIM`] components.
    pub fn new(actor_critic: ActorCritic, choosing: Choosing) -> Self {
        let (frames, rest) =
            (actor_critic.obs_dim() / PedestrianEnv::STATE_DIM, actor_critic.obs_dim() % PedestrianEnv::STATE_DIM);
        assert!(rest == 0, "a pedestrian's policy sees whole states");
        let stack = FrameStack::new(PedestrianEnv::STATE_DIM, frames);
        Self { scratch: actor_critic.scratch(1), actor_critic, choosing, stream: None, stack, begun: false }
    }
}

impl Walker for TrainedWalker {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
        self.begun = false;
    }

    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand {
        let state = env.state();
        if self.begun {
            self.stack.push(&state);
        } else {
            self.stack.begin(&state);
        }
        self.begun = true;
        let (seen, mut action) = (self.stack.as_slice(), [0.0; 2]);
        match (self.choosing, &mut self.stream) {
            (Choosing::Sampling, Some(stream)) => {
                self.actor_critic.sample(seen, &mut action, &mut self.scratch, stream);
            }
            _ => self.actor_critic.act(seen, &mut action, &mut self.scratch),
        }
        let bounds = env.scenario().adversary.action_bounds();
        for (component, (low, high)) in action.iter_mut().zip(bounds) {
            *component = component.clamp(low, high);
        }
        env.command(action)
    }

    fn clone_for_batch(&self) -> Option<Box<dyn Walker>> {
        Some(Box::new(self.clone()))
    }
}
