//! The interface between the learner and an environment.

/// An environment with continuous observations and a box of continuous actions.
///
/// The learner owns the episode: it calls [`Env::reset`] before the first step and after every step that ends an
/// episode. An environment never resets itself, so that the last observation of an episode stays visible.
pub trait Env {
    /// Returns the agents that act at once; one unless given. Their observations follow each other in that of the environment, and so do their actions.
    fn agents(&self) -> Vec<Agent> {
        vec![Agent { policy: 0, obs_dim: self.obs_dim(), action_bounds: self.action_bounds() }]
    }

    /// Returns the number of components of an observation, over all agents.
    fn obs_dim(&self) -> usize;

    /// Returns the lower and upper bound of every component of an action, over all agents, in the units of the action.
    fn action_bounds(&self) -> Vec<(f64, f64)>;

    /// Starts a new episode and writes its first observation into `obs` (length [`Env::obs_dim`]).
    fn reset(&mut self, obs: &mut [f64]);

    /// Takes one decision and writes the observation that follows it into `obs`.
    ///
    /// `action` lies inside the bounds of [`Env::action_bounds`]. At the end of an episode `obs` receives the final
    /// observation, from which the learner bootstraps when the episode was merely cut off.
    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step;

    /// Returns what an agent earned in the last step, which had this reward: its credit.
    fn credit(&self, _agent: usize, reward: f64) -> f64 {
        reward
    }

    /// Returns whether the episode that the last step ended reached its goal, for the reports of training; the learner does not use it.
    ///
    /// # Source
    /// `is_success` of stable-baselines3's environments.
    fn is_success(&self) -> bool {
        false
    }

    /// Returns whether it reached the goal in the way that counts: the driver is to blame. `None` if that is not judged.
    fn is_fault(&self) -> Option<bool> {
        None
    }

    /// Returns the potential of the present state, by which the learner's rewards are shaped; 0 for none.
    ///
    /// The learner gets γ Φ(s′) − Φ(s) in addition to the reward, with its own γ. Φ may depend on everything that the state of the
    /// environment holds, and changes no optimal policy (see [`shaping`](super::shaping)).
    fn potential(&self) -> f64 {
        0.0
    }

    /// Returns everything that the environment's future depends on, also in mid-episode; `None` if it cannot be saved.
    ///
    /// With it a training continues from [`Trainer::state`](super::Trainer::state) bit for bit. Without it the current
    /// episode is dropped and a new one starts.
    fn save(&self) -> Option<Vec<u8>> {
        None
    }

    /// Restores the state that [`Env::save`] returned; returns whether it could.
    fn load(&mut self, state: &[u8]) -> bool {
        let _ = state;
        false
    }
}

/// An agent of an environment, with an observation and an action of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// The number of the policy that moves it, from 0. Agents of one policy learn together and have equal dimensions.
    pub policy: usize,
    /// The number of components of its observation.
    pub obs_dim: usize,
    /// The lower and upper bound of every component of its action.
    pub action_bounds: Vec<(f64, f64)>,
}

/// The outcome of one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The reward of this decision, unscaled.
    pub reward: f64,
    /// The episode has reached a terminal state; no reward follows.
    pub terminated: bool,
    /// The episode was cut off by a time limit; the critic estimates the rewards that would have followed.
    ///
    /// It has no effect on the learner's targets when `terminated` is set, too.
    pub truncated: bool,
}

impl Step {
    /// Returns whether the episode is over, for either reason.
    pub fn done(&self) -> bool {
        self.terminated || self.truncated
    }
}
