//! The settings of a training run.

use serde::Serialize;

/// The hyperparameters of PPO.
///
/// The number of environments is not part of it: it is the number of environments handed to [`train`](super::train).
///
/// # Source
/// Table I of "Suicidal Pedestrian" (ITSC 2023); what the table leaves out has the default of stable-baselines3's
/// `PPO`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PpoConfig {
    /// Environment steps after which no further update begins, summed over all environments.
    pub total_steps: u64,
    /// Steps per environment between two updates.
    pub rollout_steps: usize,
    /// Passes over the rollout in every update.
    pub epochs: usize,
    /// Samples per minibatch; the last one of an epoch may be shorter.
    pub batch_size: usize,
    /// Adam's step size, for actor and critic alike.
    pub learning_rate: f64,
    /// The discount factor per step, γ.
    pub gamma: f64,
    /// The decay λ of generalised advantage estimation.
    pub gae_lambda: f64,
    /// The half width ε of the interval around 1 in which the probability ratio counts.
    pub clip_coef: f64,
    /// The weight of the critic's mean squared error in the loss.
    pub vf_coef: f64,
    /// The weight of the entropy bonus in the loss.
    pub ent_coef: f64,
    /// The upper bound of the gradient's Euclidean norm, taken over all parameters together.
    pub max_grad_norm: f64,
    /// The ε in Adam's denominator.
    pub adam_eps: f64,
    /// Whether advantages are standardised within every minibatch.
    pub norm_adv: bool,
    /// The first value of every component of the logarithm of the policy's standard deviation.
    pub initial_log_std: f64,
    /// The widths of the hidden layers, the same for actor and critic.
    pub hidden: Vec<usize>,
}

impl PpoConfig {
    /// The settings of the paper.
    pub fn paper() -> Self {
        Self {
            total_steps: 70_000,
            rollout_steps: 150,
            epochs: 10,
            batch_size: 64,
            learning_rate: 3e-4,
            gamma: 0.98,
            gae_lambda: 0.95,
            clip_coef: 0.2,
            vf_coef: 0.5,
            ent_coef: 0.01,
            max_grad_norm: 0.5,
            adam_eps: 1e-5,
            norm_adv: true,
            initial_log_std: 0.0,
            hidden: vec![64, 64],
        }
    }
}

impl Default for PpoConfig {
    fn default() -> Self {
        Self::paper()
    }
}
