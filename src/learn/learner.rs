//! The half of PPO that learns from rollouts.

use super::actor_critic::ActorCritic;
use super::adam::Adam;
use super::arithmetic::Path;
use super::config::{ADAM_EPS, PpoConfig};
use super::loss::LossGradient;
use super::minibatch::Minibatch;
use super::rollout::Rollout;
use super::train_error::Quantity;

/// The multiple of its target at which the divergence ends an update.
const KL_TOLERANCE: f64 = 1.5;

/// The means of an update's minibatches.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct UpdateMeans {
    pub(super) policy: f64,
    pub(super) value: f64,
    pub(super) entropy: f64,
    /// Over the minibatches of the last epoch.
    pub(super) approx_kl: f64,
    pub(super) clip_fraction: f64,
    pub(super) grad_norm: f64,
    pub(super) gradient_steps: u64,
}

/// The state that improves a policy.
#[derive(Debug, Clone)]
pub(super) struct Learner {
    pub(super) adam: Adam<f32>,
    loss: LossGradient<f32>,
    batch: Minibatch<f32>,
    /// The numbers of the policy's samples among those of all rollouts.
    samples: Vec<usize>,
    order: Vec<usize>,
    path: Path,
}

impl Learner {
    /// Makes room for updates of a policy on the samples with these numbers, which count by lane, then step.
    pub(super) fn new(policy: &ActorCritic, config: &PpoConfig, samples: Vec<usize>, path: Path) -> Self {
        let capacity = config.batch_size.min(samples.len());
        Self {
            adam: Adam::new(policy.parameters().len(), ADAM_EPS),
            loss: LossGradient::new(policy, capacity, path),
            batch: Minibatch::with_capacity(capacity, policy.obs_dim(), policy.action_dim()),
            order: samples.clone(),
            samples,
            path,
        }
    }

    /// Takes the gradient steps of one update; `reorder` brings the numbers of the samples into the order of the next epoch.
    ///
    /// # Source
    /// `PPO.train` of stable-baselines3. A minibatch whose divergence is too high counts in the means of the losses, but no
    /// step is taken on it.
    pub(super) fn learn(
        &mut self,
        policy: &mut ActorCritic,
        rollouts: &[Rollout],
        config: &PpoConfig,
        learning_rate: f64,
        reorder: &mut dyn FnMut(&mut [usize]),
    ) -> Result<UpdateMeans, Quantity> {
        // It starts from a fixed order, so that an update does not depend on the orders of earlier ones.
        self.order.copy_from_slice(&self.samples);
        let limit = config.target_kl.map_or(f64::INFINITY, |target| KL_TOLERANCE * target);
        let mut sums = UpdateMeans::default();
        let (mut minibatches, mut in_epoch) = (0.0, 0.0);
        'update: for _ in 0..config.epochs {
            reorder(&mut self.order);
            (sums.approx_kl, in_epoch) = (0.0, 0.0);
            for samples in self.order.chunks(config.batch_size) {
                self.batch.gather(rollouts, samples);
                if config.normalize_advantages {
                    self.batch.normalise_advantages();
                }
                let terms = self.loss.compute(policy, &self.batch, config);
                if !terms.total(config).is_finite() {
                    return Err(Quantity::Loss);
                }
                if !terms.approx_kl.is_finite() {
                    return Err(Quantity::Divergence);
                }
                minibatches += 1.0;
                in_epoch += 1.0;
                sums.policy += terms.policy;
                sums.value += terms.value;
                sums.entropy += terms.entropy;
                sums.approx_kl += terms.approx_kl;
                sums.clip_fraction += terms.clip_fraction;
                if terms.approx_kl > limit {
                    break 'update;
                }

                let norm = self.loss.norm();
                if !norm.is_finite() {
                    return Err(Quantity::Gradient);
                }
                let scale = (config.max_gradient_norm / (norm + 1e-6)).min(1.0);
                self.adam.step(policy.parameters_mut(), &self.loss.gradient, learning_rate, scale, self.path);
                policy.hold_spread();
                sums.grad_norm += norm;
                sums.gradient_steps += 1;
            }
        }
        Ok(UpdateMeans {
            policy: sums.policy / minibatches,
            value: sums.value / minibatches,
            entropy: sums.entropy / minibatches,
            approx_kl: sums.approx_kl / in_epoch,
            clip_fraction: sums.clip_fraction / minibatches,
            grad_norm: sums.grad_norm / (sums.gradient_steps as f64).max(1.0),
            gradient_steps: sums.gradient_steps,
        })
    }
}

#[cfg(test)]
mod tests;
