use super::WalkPolicy;
use crate::env::Scene;
use crate::sim::WalkCommand;
use base::seed::Stream;
use learn::{ActorCritic, FrameStack, Scratch};

/// The choice of an action by a trained policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionMode {
    /// Deterministic: it takes the mean of its distribution.
    Deterministic,
    /// Stochastic: it draws from its distribution, as in training.
    Stochastic,
}

/// A trained policy.
///
/// It gets as many of the last states as in training. It normalises them as at the end of the training.
#[derive(Debug, Clone)]
pub struct TrainedWalker {
    actor_critic: ActorCritic,
    scratch: Scratch,
    mode: ActionMode,
    stream: Option<Stream>,
    /// The last states of the episode.
    stack: FrameStack,
    /// Memory for a state and an action.
    state: Vec<f64>,
    action: Vec<f64>,
    /// Whether the first decision of the episode has been taken.
    begun: bool,
}

impl TrainedWalker {
    /// Makes a walk policy of a trained policy, for environments whose states have `obs_dim` numbers.
    ///
    /// # Panics
    /// When the policy does not expect one or several such states.
    pub fn new(actor_critic: ActorCritic, obs_dim: usize, mode: ActionMode) -> Self {
        assert!(actor_critic.obs_dim().is_multiple_of(obs_dim), "a policy gets whole states");
        Self {
            scratch: actor_critic.scratch(1),
            stack: FrameStack::new(obs_dim, actor_critic.obs_dim() / obs_dim),
            state: vec![0.0; obs_dim],
            action: vec![0.0; actor_critic.action_dim()],
            actor_critic,
            mode,
            stream: None,
            begun: false,
        }
    }
}

impl WalkPolicy for TrainedWalker {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
        self.begun = false;
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        scene.write_state(&mut self.state);
        if self.begun {
            self.stack.push(&self.state);
        } else {
            self.stack.begin(&self.state);
        }
        self.begun = true;
        let seen = self.stack.as_slice();
        match (self.mode, &mut self.stream) {
            (ActionMode::Stochastic, Some(stream)) => {
                self.actor_critic.sample(seen, &mut self.action, &mut self.scratch, stream);
            }
            _ => self.actor_critic.act(seen, &mut self.action, &mut self.scratch),
        }
        for (component, (low, high)) in self.action.iter_mut().zip(scene.bounds()) {
            *component = component.clamp(*low, *high);
        }
        scene.write_commands(&self.action, commands);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
