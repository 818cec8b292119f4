use super::WalkPolicy;
use crate::env::{ActionSpec, Cast, Scene};
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
    /// The last states of the episode: joint ones, or those of each pedestrian.
    stacks: Vec<FrameStack>,
    /// Memory for a state and an action.
    state: Vec<f64>,
    action: Vec<f64>,
    /// Whether the first decision of the episode has been taken.
    begun: bool,
}

impl TrainedWalker {
    /// Makes a walk policy of a trained policy, for the controlled pedestrians of a cast. One that chooses for one pedestrian chooses for each of them.
    ///
    /// # Panics
    /// When the policy does not expect one or several of their states.
    pub fn new(actor_critic: ActorCritic, cast: &Cast, mode: ActionMode) -> Self {
        let controlled = cast.controlled().count();
        let shared = controlled > 1 && actor_critic.action_dim() == ActionSpec::DIM;
        let obs_dim = cast.policy_dims(shared).0;
        assert!(actor_critic.obs_dim().is_multiple_of(obs_dim), "a policy gets whole states");
        let stack = FrameStack::new(obs_dim, actor_critic.obs_dim() / obs_dim);
        let agents = if shared { controlled } else { 1 };
        Self {
            scratch: actor_critic.scratch(1),
            stacks: vec![stack; agents],
            state: vec![0.0; obs_dim * agents],
            action: vec![0.0; actor_critic.action_dim() * agents],
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
        let agents = self.stacks.len();
        let states = self.state.chunks(self.state.len() / agents);
        let actions = self.action.chunks_mut(self.actor_critic.action_dim());
        for ((stack, state), action) in self.stacks.iter_mut().zip(states).zip(actions) {
            match self.begun {
                true => stack.push(state),
                false => stack.begin(state),
            }
            let seen = stack.as_slice();
            match (self.mode, &mut self.stream) {
                (ActionMode::Stochastic, Some(stream)) => {
                    self.actor_critic.sample(seen, action, &mut self.scratch, stream);
                }
                _ => self.actor_critic.act(seen, action, &mut self.scratch),
            }
        }
        self.begun = true;
        for (component, (low, high)) in self.action.iter_mut().zip(scene.bounds()) {
            *component = component.clamp(*low, *high);
        }
        scene.write_commands(&self.action, commands);
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
