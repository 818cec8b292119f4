use super::WalkPolicy;
use crate::{ActionSpec, Cast, Scene};
use base::seed::Stream;
use learn::{ActorCritic, FrameStack, Policies, Scratch};
use world::sim::WalkCommand;

/// The choice of an action by a trained policy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionMode {
    /// Deterministic: it takes the mean of its distribution.
    Deterministic,
    /// Stochastic: it draws from its distribution, as in training.
    Stochastic,
}

/// Trained policies: one that chooses for all pedestrians of a cast or for each of them, or one for each role.
///
/// A policy gets as many of the last states as in training. It normalises them as at the end of the training.
#[derive(Debug, Clone)]
pub struct TrainedWalker {
    policies: Vec<(ActorCritic, Scratch)>,
    mode: ActionMode,
    stream: Option<Stream>,
    agents: Vec<Agent>,
    /// Memory for a state and an action.
    state: Vec<f64>,
    action: Vec<f64>,
    /// Whether the first decision of the episode has been taken.
    begun: bool,
}

/// One that a policy moves.
#[derive(Debug, Clone)]
struct Agent {
    policy: usize,
    /// The numbers of its state.
    obs_dim: usize,
    /// The last states of the episode.
    stack: FrameStack,
}

impl TrainedWalker {
    /// Makes a walk policy of trained ones, for the controlled pedestrians of a cast. A single one that chooses for one pedestrian chooses for each of them.
    ///
    /// # Panics
    /// When a policy does not expect one or several states of whom it moves, or when there is none for a role.
    pub fn new(policies: Vec<ActorCritic>, cast: &Cast, mode: ActionMode) -> Self {
        let kind = match &policies[..] {
            [joint] if joint.action_dim() > ActionSpec::DIM => None,
            [_] => Some(Policies::Shared),
            _ => Some(Policies::Each),
        };
        let agents = cast.agents(kind).into_iter().map(|learn::Agent { policy, obs_dim, .. }| {
            let seen = policies[policy].obs_dim();
            assert!(seen.is_multiple_of(obs_dim), "a policy gets whole states");
            Agent { policy, obs_dim, stack: FrameStack::new(obs_dim, seen / obs_dim) }
        });
        let with_scratch = |policy: ActorCritic| {
            let scratch = policy.scratch(1);
            (policy, scratch)
        };
        Self {
            agents: agents.collect(),
            state: vec![0.0; cast.obs_dim()],
            action: vec![0.0; cast.action_bounds().len()],
            policies: policies.into_iter().map(with_scratch).collect(),
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
        let (mut states, mut actions) = (self.state.as_slice(), self.action.as_mut_slice());
        for Agent { policy, obs_dim, stack } in &mut self.agents {
            let (networks, scratch) = &mut self.policies[*policy];
            let state = states.split_off(..*obs_dim).unwrap_or_default();
            let action = actions.split_off_mut(..networks.action_dim()).unwrap_or_default();
            match self.begun {
                true => stack.push(state),
                false => stack.begin(state),
            }
            match (self.mode, &mut self.stream) {
                (ActionMode::Stochastic, Some(stream)) => networks.sample(stack.as_slice(), action, scratch, stream),
                _ => networks.act(stack.as_slice(), action, scratch),
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
