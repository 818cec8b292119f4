//! The learned policy and its critic.

use std::ops::Range;

use super::arithmetic::{Path, Real};
use super::init::{ACTION_GAIN, HIDDEN_GAIN, VALUE_GAIN, orthogonal};
use super::mlp::{Mlp, MlpScratch};
use super::moments::RunningMoments;
use super::normal::standard_normal;
use base::seed::Stream;

/// A policy with normally distributed actions, and the critic that values observations.
///
/// Actor and critic are separate networks. The standard deviation of an action does not depend on the observation.
///
/// Evaluating single observations, as [`ActorCritic::act`], [`ActorCritic::sample`] and [`ActorCritic::value`] do, gives
/// the same bits on every processor. After training with `frame_stack` an observation is the content of a
/// [`FrameStack`](super::FrameStack).
///
/// # Source
/// `ActorCriticPolicy` of stable-baselines3 with `net_arch=dict(pi=hidden, vf=hidden)` and tanh.
#[derive(Debug, Clone, PartialEq)]
pub struct ActorCritic<T: Real = f32> {
    actor: Mlp,
    critic: Mlp,
    parameters: Vec<T>,
    observation_moments: Option<RunningMoments>,
}

/// The maximum absolute value of the logarithm of a standard deviation.
const MAX_LOG_STD: f64 = 20.0;

impl<T: Real> ActorCritic<T> {
    /// Draws the first weights: orthogonal matrices and zero biases.
    ///
    /// # Panics
    /// When a dimension or the width of a hidden layer is zero.
    pub fn new(obs_dim: usize, action_dim: usize, hidden: &[usize], initial_log_std: f64, stream: &mut Stream) -> Self {
        let widths = |outputs: usize| [&[obs_dim], hidden, &[outputs]].concat();
        let mut this = Self::zeros(Mlp::new(&widths(action_dim)), Mlp::new(&widths(1)));
        let (actor, critic) = (this.actor.clone(), this.critic.clone());
        for (mlp, start, head_gain) in [(&actor, 0, ACTION_GAIN), (&critic, this.critic_range().start, VALUE_GAIN)] {
            for (l, layer) in mlp.layers().iter().enumerate() {
                let gain = if l + 1 < mlp.layers().len() { HIDDEN_GAIN } else { head_gain };
                let weight = orthogonal(layer.outputs, layer.inputs, gain, stream);
                let place = &mut this.parameters[start + layer.weight.start..start + layer.weight.end];
                for (slot, value) in place.iter_mut().zip(weight.iter()) {
                    *slot = T::rounded(*value);
                }
            }
        }
        let log_std = this.log_std_range();
        this.parameters[log_std].fill(T::rounded(initial_log_std));
        this
    }

    /// Makes an actor and a critic of these shapes with all parameters zero.
    pub(super) fn zeros(actor: Mlp, critic: Mlp) -> Self {
        let count = actor.parameter_count() + critic.parameter_count() + actor.outputs();
        Self { actor, critic, parameters: vec![T::zero(); count], observation_moments: None }
    }

    /// Returns the number of components of an observation.
    pub fn obs_dim(&self) -> usize {
        self.actor.inputs()
    }

    /// Returns the number of components of an action.
    pub fn action_dim(&self) -> usize {
        self.actor.outputs()
    }

    /// Returns the shape of the network that gives the mean action.
    pub(super) fn actor(&self) -> &Mlp {
        &self.actor
    }

    /// Returns the shape of the network that values an observation.
    pub(super) fn critic(&self) -> &Mlp {
        &self.critic
    }

    /// Returns all parameters: actor, critic, logarithms of the standard deviations.
    pub fn parameters(&self) -> &[T] {
        &self.parameters
    }

    /// Gives access to all parameters, in the order of [`ActorCritic::parameters`].
    pub fn parameters_mut(&mut self) -> &mut [T] {
        &mut self.parameters
    }

    /// Returns the range of the actor's parameters.
    pub(super) fn actor_range(&self) -> Range<usize> {
        0..self.actor.parameter_count()
    }

    /// Returns the range of the critic's parameters.
    pub(super) fn critic_range(&self) -> Range<usize> {
        let start = self.actor.parameter_count();
        start..start + self.critic.parameter_count()
    }

    /// Returns the range of the logarithms of the standard deviations.
    pub(super) fn log_std_range(&self) -> Range<usize> {
        self.critic_range().end..self.parameters.len()
    }

    /// Bounds the standard deviations: with an entropy bonus and nothing against it they would grow without limit.
    ///
    /// stable-baselines3 has no such bounds and ends there with an error. Values within the bounds are not changed.
    pub(super) fn hold_spread(&mut self) {
        let range = self.log_std_range();
        for slot in &mut self.parameters[range] {
            *slot = T::rounded(slot.widened().clamp(-MAX_LOG_STD, MAX_LOG_STD));
        }
    }

    /// Returns the natural logarithm of the standard deviation of every action component.
    pub fn log_std(&self) -> &[T] {
        &self.parameters[self.critic_range().end..]
    }

    /// Returns the mean over the action's components of the standard deviation.
    pub(super) fn mean_std(&self) -> f64 {
        let log_std = self.log_std();
        log_std.iter().map(|log_std| libm::exp(log_std.widened())).sum::<f64>() / log_std.len() as f64
    }

    /// Returns the moments that observations are normalised with before the networks see them, if any.
    pub fn observation_moments(&self) -> Option<&RunningMoments> {
        self.observation_moments.as_ref()
    }

    /// Gives access to the moments that observations are normalised with.
    pub fn observation_moments_mut(&mut self) -> &mut Option<RunningMoments> {
        &mut self.observation_moments
    }

    /// Writes the input of the networks for an observation into `input`.
    pub(super) fn prepare(&self, obs: &[f64], input: &mut [T]) {
        match &self.observation_moments {
            None => input.iter_mut().zip(obs).for_each(|(slot, obs)| *slot = T::rounded(*obs)),
            Some(moments) => {
                for (i, (slot, obs)) in input.iter_mut().zip(obs).enumerate() {
                    *slot = T::rounded(moments.normalised(i, *obs));
                }
            }
        }
    }

    /// Makes room for evaluating up to `capacity` observations at once.
    pub fn scratch(&self, capacity: usize) -> Scratch<T> {
        Scratch {
            input: vec![T::zero(); self.obs_dim()],
            actor: MlpScratch::new(&self.actor, capacity),
            critic: MlpScratch::new(&self.critic, capacity),
        }
    }

    /// Writes the mean action for one observation into `out`: the deterministic policy, not clipped to any bounds.
    pub fn act(&self, obs: &[f64], out: &mut [f64], scratch: &mut Scratch<T>) {
        self.prepare(obs, &mut scratch.input);
        self.mean(&scratch.input, out, &mut scratch.actor);
    }

    /// Writes the mean action for the input of one observation into `out`.
    pub(super) fn mean(&self, input: &[T], out: &mut [f64], scratch: &mut MlpScratch<T>) {
        let mean = self.actor.forward_one(&self.parameters[self.actor_range()], input, scratch);
        for (out, mean) in out.iter_mut().zip(mean) {
            *out = mean.widened();
        }
    }

    /// Draws an action for one observation into `out`, not clipped to any bounds.
    pub fn sample(&self, obs: &[f64], out: &mut [f64], scratch: &mut Scratch<T>, stream: &mut Stream) {
        self.act(obs, out, scratch);
        for (out, log_std) in out.iter_mut().zip(self.log_std()) {
            *out += libm::exp(log_std.widened()) * standard_normal(stream);
        }
    }

    /// Returns the critic's estimate of the discounted reward that follows one observation.
    ///
    /// If rewards are normalised, it is an estimate of the normalised ones.
    pub fn value(&self, obs: &[f64], scratch: &mut Scratch<T>) -> f64 {
        self.prepare(obs, &mut scratch.input);
        let parameters = &self.parameters[self.critic_range()];
        self.critic.forward_one(parameters, &scratch.input, &mut scratch.critic)[0].widened()
    }

    /// Writes the critic's values of several observations into `out`; `inputs` are those of the networks (obs_dim × batch).
    pub(super) fn values(&self, inputs: &[T], out: &mut [f64], scratch: &mut Scratch<T>, path: Path) {
        let values = self.critic.forward(&self.parameters[self.critic_range()], inputs, &mut scratch.critic, path);
        for (out, value) in out.iter_mut().zip(values) {
            *out = value.widened();
        }
    }
}

/// The memory for evaluating an [`ActorCritic`].
#[derive(Debug, Clone)]
pub struct Scratch<T: Real = f32> {
    pub(super) input: Vec<T>,
    pub(super) actor: MlpScratch<T>,
    pub(super) critic: MlpScratch<T>,
}
