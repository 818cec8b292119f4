//! The loss of PPO and its gradient.

use super::actor_critic::ActorCritic;
use super::arithmetic::{Path, Real};
use super::config::PpoConfig;
use super::gaussian::{Gaussian, Spread};
use super::minibatch::Minibatch;
use super::mlp::MlpScratch;
use super::product::SquaredNorm;

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
        self.policy - config.entropy_coefficient * self.entropy + config.value_coefficient * self.value
    }
}

/// The gradient of the loss, with the memory for computing it.
#[derive(Debug, Clone)]
pub(super) struct LossGradient<T: Real> {
    /// One element per parameter, in the order of [`ActorCritic::parameters`].
    pub(super) gradient: Vec<T>,
    path: Path,
    actor: ActorLoss<T>,
    critic: MlpScratch<T>,
}

/// The memory for the loss of the actor.
#[derive(Debug, Clone)]
struct ActorLoss<T> {
    scratch: MlpScratch<T>,
    mean: Vec<f64>,
    spread: Spread,
    log_std_gradient: Vec<f64>,
}

/// What the losses of actor and critic are computed from.
#[derive(Clone, Copy)]
struct Task<'a, T: Real> {
    policy: &'a ActorCritic<T>,
    batch: &'a Minibatch<T>,
    config: &'a PpoConfig,
    path: Path,
}

/// The number of samples times parameters from which actor and critic are computed beside each other: some 50 µs each.
const WORTH_A_THREAD: usize = 1_000_000;

impl<T: Real> LossGradient<T> {
    /// Makes room for minibatches of at most `capacity` samples.
    pub(super) fn new(policy: &ActorCritic<T>, capacity: usize, path: Path) -> Self {
        Self {
            gradient: vec![T::zero(); policy.parameters().len()],
            path,
            actor: ActorLoss {
                scratch: MlpScratch::new(policy.actor(), capacity),
                mean: vec![0.0; policy.action_dim()],
                spread: Spread::new(policy.action_dim()),
                log_std_gradient: vec![0.0; policy.action_dim()],
            },
            critic: MlpScratch::new(policy.critic(), capacity),
        }
    }

    /// Computes the loss on a minibatch and its gradient, which replaces the previous one.
    ///
    /// Actor and critic share nothing, so large minibatches take two threads of the current rayon pool.
    ///
    /// # Source
    /// Schulman et al. (2017), equations 7 and 9; `PPO.train` of stable-baselines3.
    pub(super) fn compute(&mut self, policy: &ActorCritic<T>, batch: &Minibatch<T>, config: &PpoConfig) -> LossTerms {
        let task = Task { policy, batch, config, path: self.path };
        let (networks, log_std) = self.gradient.split_at_mut(policy.log_std_range().start);
        let (actor, critic) = networks.split_at_mut(policy.actor_range().end);
        let work = batch.len() * policy.parameters().len();
        let mut of_actor = || self.actor.compute(task, actor, log_std);
        let mut of_critic = || critic_loss(&mut self.critic, task, critic);
        let (terms, value) = if work < WORTH_A_THREAD || config.threads == Some(1) {
            (of_actor(), of_critic())
        } else {
            rayon::join(of_actor, of_critic)
        };
        LossTerms { value, ..terms }
    }

    /// Returns the Euclidean norm of the gradient.
    pub(super) fn norm(&self) -> f64 {
        self.path.run(SquaredNorm(&self.gradient)).widened().sqrt()
    }
}

impl<T: Real> ActorLoss<T> {
    /// Computes all terms but that of the critic, and the gradients of the actor and of the logarithms of the standard deviations.
    fn compute(&mut self, task: Task<'_, T>, gradient: &mut [T], log_std: &mut [T]) -> LossTerms {
        let Task { policy, batch, config, path } = task;
        let clip_coef = config.clip;
        self.spread.set(policy.log_std());
        let share = 1.0 / batch.len() as f64;
        let dim = policy.action_dim();
        let parameters = &policy.parameters()[policy.actor_range()];
        policy.actor().forward(parameters, &batch.obs, &mut self.scratch, path);
        // The derivative overwrites its mean, sample by sample.
        let slots = self.scratch.output_to_gradient(policy.actor());

        let mut terms = LossTerms::default();
        self.log_std_gradient.fill(-config.entropy_coefficient);
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

        policy.actor().backward(parameters, gradient, &mut self.scratch, path);
        for (slot, value) in log_std.iter_mut().zip(&self.log_std_gradient) {
            *slot = T::rounded(*value);
        }
        terms
    }
}

/// Computes the critic's mean squared error and its gradient.
fn critic_loss<T: Real>(scratch: &mut MlpScratch<T>, task: Task<'_, T>, gradient: &mut [T]) -> f64 {
    let Task { policy, batch, config, path, .. } = task;
    let share = 1.0 / batch.len() as f64;
    let parameters = &policy.parameters()[policy.critic_range()];
    policy.critic().forward(parameters, &batch.obs, scratch, path);
    let mut loss = 0.0;
    let slots = scratch.output_to_gradient(policy.critic());
    for (slot, expected) in slots.iter_mut().zip(&batch.returns) {
        let error = slot.widened() - expected;
        loss += share * error * error;
        *slot = T::rounded(config.value_coefficient * 2.0 * share * error);
    }
    policy.critic().backward(parameters, gradient, scratch, path);
    loss
}

#[cfg(test)]
mod tests;
