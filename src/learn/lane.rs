//! One environment in mid-episode, and what acting in it needs.

use super::actor_critic::{ActorCritic, Scratch};
use super::arithmetic::Path;
use super::env::{Env, Step};
use super::frame_stack::FrameStack;
use super::gaussian::{Gaussian, Spread};
use super::log::FinishedEpisode;
use super::normal::standard_normal;
use super::rollout::Rollout;
use super::shaping::shaping;
use super::train_error::Quantity;
use base::seed::Stream;

/// The part of a collector that belongs to one environment. Lanes do not share data, so they can run in parallel.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    bounds: Vec<(f64, f64)>,
    /// The noise of the actions.
    pub(super) noise: Stream,
    /// The input of the next decision.
    pub(super) stack: FrameStack,
    /// Whether the next decision is the first of an episode.
    pub(super) start: bool,
    pub(super) running: FinishedEpisode,
    /// The discounted sum of the rewards of this episode up to now, for their normalisation.
    pub(super) discounted: f64,
    /// The outcome of the last step.
    pub(super) outcome: Step,
    /// The shaped reward of the last step.
    pub(super) earned: f64,
    /// The potential of the present state.
    pub(super) potential: f64,
    /// The episodes that ended in this rollout, each with its last step.
    pub(super) finished: Vec<(usize, FinishedEpisode)>,
    /// The quantity that was not finite, and its step.
    pub(super) failure: Option<(usize, Quantity)>,
    /// The last observation of the episode that the last step ended.
    end: FrameStack,
    frame: Vec<f64>,
    spread: Spread,
    mean: Vec<f64>,
    clipped: Vec<f64>,
    scratch: Scratch,
    chunk: usize,
}

impl Lane {
    /// Makes a lane that precedes its first episode. `chunk` is the number of observations that are valued at once.
    pub(super) fn new<E: Env>(env: &E, policy: &ActorCritic, frames: usize, chunk: usize, noise: Stream) -> Self {
        let (frame_dim, action_dim) = (env.obs_dim(), policy.action_dim());
        let stack = FrameStack::new(frame_dim, frames);
        Self {
            bounds: env.action_bounds(),
            noise,
            end: stack.clone(),
            stack,
            start: true,
            running: FinishedEpisode::default(),
            discounted: 0.0,
            outcome: Step { reward: 0.0, terminated: false, truncated: false },
            earned: 0.0,
            potential: 0.0,
            finished: Vec::new(),
            failure: None,
            frame: vec![0.0; frame_dim],
            spread: Spread::new(action_dim),
            mean: vec![0.0; action_dim],
            clipped: vec![0.0; action_dim],
            scratch: policy.scratch(chunk),
            chunk,
        }
    }

    /// Starts an episode.
    pub(super) fn begin<E: Env>(&mut self, env: &mut E) -> Result<(), Quantity> {
        env.reset(&mut self.frame);
        self.stack.begin(&self.frame);
        self.start = true;
        self.running = FinishedEpisode::default();
        self.discounted = 0.0;
        self.potential = env.potential();
        representable(&self.frame)
    }

    /// Prepares a rollout with this policy.
    pub(super) fn prepare(&mut self, policy: &ActorCritic) {
        self.finished.clear();
        self.failure = None;
        self.spread.set(policy.log_std());
    }

    /// Writes the input of the networks in step `t` of a rollout, and returns it.
    pub(super) fn look<'a>(&self, policy: &ActorCritic, rollout: &'a mut Rollout, t: usize) -> &'a [f32] {
        let input = &mut rollout.obs[t * rollout.obs_dim..(t + 1) * rollout.obs_dim];
        policy.prepare(self.stack.as_slice(), input);
        input
    }

    /// Asks the actor for the mean of the next action.
    pub(super) fn ask(&mut self, policy: &ActorCritic, input: &[f32]) {
        policy.mean(input, &mut self.mean, &mut self.scratch.actor);
    }

    /// Sets the mean of the next action.
    pub(super) fn set_mean(&mut self, mean: &[f32]) {
        for (slot, mean) in self.mean.iter_mut().zip(mean) {
            *slot = f64::from(*mean);
        }
    }

    /// Takes step `t` of a rollout with an action around the mean; [`Lane::settle`] does the part that depends on normalised numbers.
    pub(super) fn step<E: Env>(
        &mut self,
        env: &mut E,
        rollout: &mut Rollout,
        t: usize,
        gamma: f64,
    ) -> Result<(), Quantity> {
        let action = &mut rollout.actions[t * rollout.action_dim..(t + 1) * rollout.action_dim];
        for ((action, mean), std) in action.iter_mut().zip(&self.mean).zip(self.spread.std()) {
            *action = mean + std * standard_normal(&mut self.noise);
        }
        finite(action, Quantity::Action)?;
        rollout.log_probs[t] = Gaussian { mean: &self.mean, spread: &self.spread }.log_prob(action);
        rollout.episode_starts[t] = self.start;
        for ((slot, action), (low, high)) in self.clipped.iter_mut().zip(action.iter()).zip(&self.bounds) {
            *slot = action.max(*low).min(*high);
        }

        self.outcome = env.step(&self.clipped, &mut self.frame);
        let potential = env.potential();
        self.earned = self.outcome.reward + shaping(self.potential, potential, self.outcome, gamma);
        self.potential = potential;
        finite(&[self.earned], Quantity::Reward)?;
        representable(&self.frame)?;
        self.running.reward += self.outcome.reward;
        self.running.length += 1;
        self.start = self.outcome.done();
        if self.outcome.done() {
            self.end.restore(self.stack.as_slice());
            self.end.push(&self.frame);
            self.running.success = env.is_success();
            self.running.fault = env.is_fault();
            self.finished.push((t, self.running));
            self.running = FinishedEpisode::default();
            env.reset(&mut self.frame);
            self.stack.begin(&self.frame);
            self.potential = env.potential();
            representable(&self.frame)?;
        } else {
            self.stack.push(&self.frame);
        }
        Ok(())
    }

    /// Records the reward of the last step; `reward` is in the unit of the critic.
    pub(super) fn settle(&mut self, policy: &ActorCritic, rollout: &mut Rollout, t: usize, reward: f64, gamma: f64) {
        rollout.rewards[t] = reward;
        if self.outcome.truncated && !self.outcome.terminated {
            rollout.rewards[t] += gamma * policy.value(self.end.as_slice(), &mut self.scratch);
        }
        if self.outcome.done() {
            self.discounted = 0.0;
        }
    }

    /// Completes a rollout with values, advantages and returns.
    ///
    /// All observations are valued together, which is cheaper than one by one while acting. The critic does not change in
    /// between.
    pub(super) fn finish(&mut self, policy: &ActorCritic, rollout: &mut Rollout, gamma: f64, lambda: f64, path: Path) {
        let obs = rollout.obs.chunks(self.chunk * rollout.obs_dim);
        for (obs, values) in obs.zip(rollout.values.chunks_mut(self.chunk)) {
            policy.values(obs, values, &mut self.scratch, path);
        }
        let last_value = policy.value(self.stack.as_slice(), &mut self.scratch);
        rollout.finish(last_value, self.start, gamma, lambda);
    }
}

fn finite(values: &[f64], quantity: Quantity) -> Result<(), Quantity> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(quantity) }
}

/// Returns an error for observations that are infinite in the networks' precision.
fn representable(obs: &[f64]) -> Result<(), Quantity> {
    if obs.iter().all(|&value| (value as f32).is_finite()) { Ok(()) } else { Err(Quantity::Observation) }
}
