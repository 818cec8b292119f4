//! Proximal policy optimisation.

use std::fmt;
use std::ops::ControlFlow;

use super::actor_critic::ActorCritic;
use super::adam::Adam;
use super::collector::Collector;
use super::config::PpoConfig;
use super::env::Env;
use super::log::UpdateLog;
use super::loss::LossGradient;
use super::minibatch::{Minibatch, shuffle};
use super::rollout::RolloutBuffer;
use crate::seed::{Seed, Stream};

/// What training leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The policy and the critic after the last update.
    pub actor_critic: ActorCritic,
    /// The reports of all updates, in order.
    pub learning_curve: Vec<UpdateLog>,
}

/// Why training ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// A number was infinite or not a number.
    #[error("the {quantity} was not finite in update {update}")]
    NonFinite {
        /// The update, from 1.
        update: u64,
        /// What was not finite.
        quantity: Quantity,
    },
    /// The observer asked to stop.
    #[error("stopped after update {update}")]
    Stopped {
        /// The last update that was completed, from 1.
        update: u64,
    },
}

/// A number that training requires to be finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// An observation of an environment, in `f32`.
    Observation,
    /// A reward of an environment.
    Reward,
    /// An action of the policy.
    Action,
    /// The loss on a minibatch.
    Loss,
    /// The norm of the gradient on a minibatch.
    Gradient,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Observation => "observation",
            Self::Reward => "reward",
            Self::Action => "action",
            Self::Loss => "loss",
            Self::Gradient => "gradient",
        })
    }
}

/// Trains an actor and a critic by PPO.
///
/// Rollouts and updates alternate until `config.total_steps` steps have been taken; the last rollout is completed, so
/// that the number of steps may be a little higher. The environments take turns in every step. `observer` sees the report
/// of every update and may stop training.
///
/// The result depends on the environments, `config` and `seed` only. First weights, action noise and the order of
/// minibatches have streams of their own.
///
/// # Errors
/// [`TrainError::NonFinite`] at the first number that is not finite, [`TrainError::Stopped`] when the observer breaks.
///
/// # Panics
/// When there is no environment, when environments differ in their dimensions, or when `rollout_steps`, `batch_size`,
/// `epochs` or a width in `config` is zero.
///
/// # Source
/// `PPO` of stable-baselines3; Schulman et al. (2017).
pub fn train<E: Env>(
    envs: &mut [E],
    config: &PpoConfig,
    seed: &Seed,
    observer: &mut dyn FnMut(&UpdateLog) -> ControlFlow<()>,
) -> Result<Trained, TrainError> {
    assert!(!envs.is_empty(), "training needs an environment");
    assert!(
        config.rollout_steps > 0 && config.batch_size > 0 && config.epochs > 0,
        "rollouts, minibatches and epochs must not be empty"
    );
    let (obs_dim, action_dim) = (envs[0].obs_dim(), envs[0].action_bounds().len());
    assert!(
        envs.iter().all(|env| (env.obs_dim(), env.action_bounds().len()) == (obs_dim, action_dim)),
        "environments must agree in their dimensions"
    );

    let n_envs = envs.len();
    let policy =
        ActorCritic::new(obs_dim, action_dim, &config.hidden, config.initial_log_std, &mut seed.child("init").stream());
    let mut buffer = RolloutBuffer::new(config.rollout_steps, n_envs, obs_dim, action_dim);
    let mut learner = Learner::new(policy, config, buffer.len(), seed.child("minibatches").stream());
    let noise = seed.child("action noise").stream();
    let non_finite = |update| move |quantity| TrainError::NonFinite { update, quantity };
    let mut collector =
        Collector::new(envs, &learner.policy, config.gamma, config.batch_size, noise).map_err(non_finite(1))?;
    let mut learning_curve: Vec<UpdateLog> = Vec::new();
    let (mut update, mut steps) = (0, 0);
    while steps < config.total_steps {
        update += 1;
        let finished =
            collector.collect(&learner.policy, &mut buffer, config.gae_lambda).map_err(non_finite(update))?;
        steps += buffer.len() as u64;
        let means = learner.learn(&buffer).map_err(non_finite(update))?;
        let recent = collector.recent_means();
        let log = UpdateLog {
            update,
            steps,
            episodes: finished.len(),
            finished,
            mean_reward: recent.map(|(reward, _)| reward),
            mean_length: recent.map(|(_, length)| length),
            approx_kl: means.approx_kl,
            clip_fraction: means.clip_fraction,
            explained_variance: buffer.explained_variance(),
            entropy: means.entropy,
            policy_loss: means.policy,
            value_loss: means.value,
            grad_norm: means.grad_norm,
            std: learner.mean_std(),
        };
        let flow = observer(&log);
        learning_curve.push(log);
        if flow.is_break() {
            return Err(TrainError::Stopped { update });
        }
    }
    Ok(Trained { actor_critic: learner.policy, learning_curve })
}

/// The means of an update's minibatches.
#[derive(Debug, Clone, Copy, Default)]
struct UpdateMeans {
    policy: f64,
    value: f64,
    entropy: f64,
    approx_kl: f64,
    clip_fraction: f64,
    grad_norm: f64,
}

/// The half of PPO that learns from a rollout.
struct Learner<'c> {
    config: &'c PpoConfig,
    policy: ActorCritic,
    adam: Adam<f32>,
    loss: LossGradient<f32>,
    batch: Minibatch<f32>,
    order: Vec<usize>,
    stream: Stream,
}

impl<'c> Learner<'c> {
    fn new(policy: ActorCritic, config: &'c PpoConfig, samples: usize, stream: Stream) -> Self {
        let capacity = config.batch_size.min(samples);
        Self {
            config,
            adam: Adam::new(policy.parameters().len(), config.learning_rate, config.adam_eps),
            loss: LossGradient::new(&policy, capacity),
            batch: Minibatch::with_capacity(capacity, policy.obs_dim(), policy.action_dim()),
            order: (0..samples).collect(),
            policy,
            stream,
        }
    }

    /// Takes the gradient steps of one update.
    fn learn(&mut self, buffer: &RolloutBuffer) -> Result<UpdateMeans, Quantity> {
        let per_epoch = self.order.len().div_ceil(self.config.batch_size);
        let share = 1.0 / (per_epoch * self.config.epochs) as f64;
        let mut means = UpdateMeans::default();
        for _ in 0..self.config.epochs {
            shuffle(&mut self.order, &mut self.stream);
            means.approx_kl = 0.0;
            for samples in self.order.chunks(self.config.batch_size) {
                self.batch.gather(buffer, samples);
                if self.config.norm_adv {
                    self.batch.normalise_advantages();
                }
                let terms = self.loss.compute(&self.policy, &self.batch, self.config);
                let norm = self.loss.norm();
                if !terms.total(self.config).is_finite() {
                    return Err(Quantity::Loss);
                }
                if !norm.is_finite() {
                    return Err(Quantity::Gradient);
                }
                let scale = (self.config.max_grad_norm / (norm + 1e-6)).min(1.0);
                self.adam.step(self.policy.parameters_mut(), &self.loss.gradient, scale);

                means.policy += share * terms.policy;
                means.value += share * terms.value;
                means.entropy += share * terms.entropy;
                means.approx_kl += terms.approx_kl / per_epoch as f64;
                means.clip_fraction += share * terms.clip_fraction;
                means.grad_norm += share * norm;
            }
        }
        Ok(means)
    }

    fn mean_std(&self) -> f64 {
        let log_std = self.policy.log_std();
        log_std.iter().map(|log_std| libm::exp(f64::from(*log_std))).sum::<f64>() / log_std.len() as f64
    }
}

#[cfg(test)]
mod tests;
