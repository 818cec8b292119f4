//! The loss of PPO and its gradient.

use super::actor_critic::{ActorCritic, Scratch};
use super::arithmetic::Path;
use super::config::PpoConfig;
use super::gaussian::{Gaussian, Spread};
use super::minibatch::Minibatch;
use super::product::SquaredNorm;
use super::real::Real;

/// The parts of the loss on one minibatch, and other reported quantities.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct LossTerms {
    /// The negative of the clipped surrogate: less is better.
    pub(super) policy: f64,
    /// The critic's mean squared error.
    pub(super) value: f64,
    /// The policy's entropy (nat).
    pub(super) entropy: f64,
    /// The mean of (ratio − 1) − ln ratio (nat).
    pub(super) approx_kl: f64,
    /// The share of samples with a ratio outside the clip interval.
    pub(super) clip_fraction: f64,
}

impl LossTerms {
    /// Returns the quantity that is minimised.
    pub(super) fn total(&self, config: &PpoConfig) -> f64 {
        self.policy - config.ent_coef * self.entropy + config.vf_coef * self.value
    }
}

/// The gradient of the loss, with the memory for computing it.
#[derive(Debug, Clone)]
pub(super) struct LossGradient<T: Real> {
    /// One element per parameter, in the order of [`ActorCritic::parameters`].
    pub(super) gradient: Vec<T>,
    path: Path,
    scratch: Scratch<T>,
    mean: Vec<f64>,
    spread: Spread,
    log_std_gradient: Vec<f64>,
}

impl<T: Real> LossGradient<T> {
    /// Makes room for minibatches of at most `capacity` samples.
    pub(super) fn new(policy: &ActorCritic<T>, capacity: usize, path: Path) -> Self {
        Self {
            gradient: vec![T::zero(); policy.parameters().len()],
            path,
            scratch: policy.scratch(capacity),
            mean: vec![0.0; policy.action_dim()],
            spread: Spread::new(policy.action_dim()),
            log_std_gradient: vec![0.0; policy.action_dim()],
        }
    }

    /// Computes the loss on a minibatch and its gradient, which replaces the previous one.
    ///
    /// `clip_coef` is the one in `config` after its schedule.
    ///
    /// # Source
    /// Schulman et al. (2017), equations 7 and 9; `PPO.train` of stable-baselines3.
    pub(super) fn compute(
        &mut self,
        policy: &ActorCritic<T>,
        batch: &Minibatch<T>,
        config: &PpoConfig,
        clip_coef: f64,
    ) -> LossTerms {
        self.spread.set(policy.log_std());
        let mut terms = self.actor(policy, batch, config, clip_coef);
        terms.value = self.critic(policy, batch, config);
        terms
    }

    /// Returns the Euclidean norm of the gradient.
    pub(super) fn norm(&self) -> f64 {
        self.path.run(SquaredNorm(&self.gradient)).widened().sqrt()
    }

    fn actor(
        &mut self,
        policy: &ActorCritic<T>,
        batch: &Minibatch<T>,
        config: &PpoConfig,
        clip_coef: f64,
    ) -> LossTerms {
        let share = 1.0 / batch.len() as f64;
        let dim = policy.action_dim();
        let parameters = &policy.parameters()[policy.actor_range()];
        policy.actor().forward(parameters, &batch.obs, &mut self.scratch.actor, self.path);
        // The derivative overwrites its mean, sample by sample.
        let slots = self.scratch.actor.output_to_gradient(policy.actor());

        let mut terms = LossTerms::default();
        self.log_std_gradient.fill(-config.ent_coef);
        for (i, slot) in slots.chunks_exact_mut(dim).enumerate() {
            for (mean, slot) in self.mean.iter_mut().zip(slot.iter()) {
                *mean = slot.widened();
            }
            let action = &batch.actions[i * dim..(i + 1) * dim];
            let gaussian = Gaussian { mean: &self.mean, spread: &self.spread };
            let log_ratio = gaussian.log_prob(action) - batch.old_log_probs[i];
            let ratio = libm::exp(log_ratio);
            let advantage = batch.advantages[i];
            let free = advantage * ratio;
            let clipped = advantage * ratio.clamp(1.0 - clip_coef, 1.0 + clip_coef);

            terms.policy -= share * free.min(clipped);
            terms.approx_kl += share * ((ratio - 1.0) - log_ratio);
            terms.clip_fraction += if (ratio - 1.0).abs() > clip_coef { share } else { 0.0 };
            // Where the clipped term is the smaller one, it is constant.
            let by_log_prob = if free <= clipped { -share * free } else { 0.0 };
            for (k, slot) in slot.iter_mut().enumerate() {
                let (by_mean, by_log_std) = gaussian.log_prob_gradient(action, k);
                *slot = T::rounded(by_log_prob * by_mean);
                self.log_std_gradient[k] += by_log_prob * by_log_std;
            }
        }
        terms.entropy = Gaussian { mean: &self.mean, spread: &self.spread }.entropy();

        let gradient = &mut self.gradient[policy.actor_range()];
        policy.actor().backward(parameters, gradient, &mut self.scratch.actor, self.path);
        for (slot, value) in self.gradient[policy.log_std_range()].iter_mut().zip(&self.log_std_gradient) {
            *slot = T::rounded(*value);
        }
        terms
    }

    fn critic(&mut self, policy: &ActorCritic<T>, batch: &Minibatch<T>, config: &PpoConfig) -> f64 {
        let share = 1.0 / batch.len() as f64;
        let parameters = &policy.parameters()[policy.critic_range()];
        policy.critic().forward(parameters, &batch.obs, &mut self.scratch.critic, self.path);
        let mut loss = 0.0;
        let slots = self.scratch.critic.output_to_gradient(policy.critic());
        let targets = batch.returns.iter().zip(&batch.old_values);
        for (slot, (expected, old)) in slots.iter_mut().zip(targets) {
            let change = slot.widened() - old;
            let limit = config.clip_range_vf.unwrap_or(f64::INFINITY);
            // Beyond the limit the value is taken as constant.
            let (value, moves) =
                if change.abs() <= limit { (slot.widened(), 1.0) } else { (old + change.clamp(-limit, limit), 0.0) };
            let error = value - expected;
            loss += share * error * error;
            *slot = T::rounded(config.vf_coef * 2.0 * share * error * moves);
        }
        let gradient = &mut self.gradient[policy.critic_range()];
        policy.critic().backward(parameters, gradient, &mut self.scratch.critic, self.path);
        loss
    }
}

#[cfg(test)]
mod tests;
