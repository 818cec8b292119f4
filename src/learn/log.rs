//! The reports of training.

use serde::Serialize;

/// An episode that ended during training.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FinishedEpisode {
    /// The undiscounted sum of the environment's own rewards.
    pub reward: f64,
    /// The number of decisions.
    pub length: u64,
    /// Whether it reached the goal of the environment.
    pub success: bool,
    /// Whether it did so in the way that counts; `None` where that is not judged.
    pub fault: Option<bool>,
}

impl FinishedEpisode {
    /// Its numbers in a file: reward, length, and two numbers of 0 for no and 1 for yes, the second one 2 where it is not judged.
    pub(super) fn numbers(&self) -> (f64, u64, u8, u8) {
        (self.reward, self.length, u8::from(self.success), self.fault.map_or(2, u8::from))
    }

    /// The episode with these numbers.
    pub(super) fn of((reward, length, success, fault): (f64, u64, u8, u8)) -> Self {
        Self { reward, length, success: success != 0, fault: (fault < 2).then_some(fault == 1) }
    }
}

/// The report of one update: a rollout and the gradient steps on it.
///
/// # Source
/// The quantities that stable-baselines3's `PPO` logs under `rollout/` and `train/`.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct UpdateLog {
    /// The number of this update, from 1.
    pub update: u64,
    /// Environment steps up to now, over all environments.
    pub steps: u64,
    /// The number of episodes that ended in this rollout.
    pub episodes: usize,
    /// These episodes, in the order in which they ended.
    pub finished: Vec<FinishedEpisode>,
    /// The mean reward of the last episodes that have ended, up to 100 of them.
    pub mean_reward: Option<f64>,
    /// The mean length of the same episodes, in decisions.
    pub mean_length: Option<f64>,
    /// The share of the same episodes that reached the goal of the environment, 0 to 1.
    pub success_rate: Option<f64>,
    /// The share of the same episodes that did so in the way that counts, 0 to 1; `None` where that is not judged.
    pub fault_rate: Option<f64>,
    /// The estimate of the divergence between old and new policy in nats, over the minibatches of the last epoch.
    pub approx_kl: f64,
    /// The share of samples whose probability ratio lay outside the clip interval, over all minibatches.
    pub clip_fraction: f64,
    /// The share of the returns' variance that the critic's values explained before the update; at most 1.
    ///
    /// Absent when the returns do not vary.
    pub explained_variance: Option<f64>,
    /// The entropy of the policy in nats, over all minibatches.
    pub entropy: f64,
    /// The clipped surrogate loss, over all minibatches.
    pub policy_loss: f64,
    /// The critic's mean squared error without its weight, over all minibatches.
    pub value_loss: f64,
    /// The Euclidean norm of the gradient before clipping, over all minibatches.
    pub grad_norm: f64,
    /// The number of gradient steps; it is below the planned number when the divergence ended the update early.
    pub gradient_steps: u64,
    /// Adam's step size in this update.
    pub learning_rate: f64,
    /// The mean over the action's components of the standard deviation after the update, in the units of the action.
    pub std: f64,
}
