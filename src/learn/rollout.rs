//! The experience of one rollout.

use super::gae::{Trajectory, advantages_and_returns};

/// The experience of one environment over a fixed number of steps.
///
/// # Source
/// `RolloutBuffer` of stable-baselines3.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rollout {
    pub(super) obs_dim: usize,
    pub(super) action_dim: usize,
    /// obs_dim × steps, column-major, as inputs of the networks.
    pub(super) obs: Vec<f32>,
    /// action_dim × steps, column-major, before clipping to the bounds.
    pub(super) actions: Vec<f64>,
    pub(super) log_probs: Vec<f64>,
    /// With the value of the final observation added where an episode was cut off.
    pub(super) rewards: Vec<f64>,
    pub(super) episode_starts: Vec<bool>,
    pub(super) values: Vec<f64>,
    pub(super) advantages: Vec<f64>,
    pub(super) returns: Vec<f64>,
}

impl Rollout {
    /// Makes room for this number of steps.
    pub(super) fn new(steps: usize, obs_dim: usize, action_dim: usize) -> Self {
        let zeros = || vec![0.0; steps];
        Self {
            obs_dim,
            action_dim,
            obs: vec![0.0; steps * obs_dim],
            actions: vec![0.0; steps * action_dim],
            log_probs: zeros(),
            rewards: zeros(),
            episode_starts: vec![false; steps],
            values: zeros(),
            advantages: zeros(),
            returns: zeros(),
        }
    }

    /// Returns the number of steps.
    pub(super) fn len(&self) -> usize {
        self.rewards.len()
    }

    /// Computes advantages and returns from rewards and values.
    ///
    /// `last_value` is the critic's value of the observation after the last step, `last_done` whether that step ended an
    /// episode.
    pub(super) fn finish(&mut self, last_value: f64, last_done: bool, gamma: f64, lambda: f64) {
        let Self { rewards, values, episode_starts, advantages, returns, .. } = self;
        let trajectory = Trajectory { rewards, values, episode_starts, last_value, last_done };
        advantages_and_returns(trajectory, gamma, lambda, advantages, returns);
    }
}

/// Returns the share of the returns' variance that the values explain; absent when the returns do not vary.
pub(super) fn explained_variance(rollouts: &[Rollout]) -> Option<f64> {
    let variance_of_returns = variance(rollouts.iter().flat_map(|rollout| rollout.returns.iter().copied()));
    let residuals = rollouts.iter().flat_map(|rollout| rollout.returns.iter().zip(&rollout.values));
    let residuals = residuals.map(|(expected, value)| expected - value);
    (variance_of_returns > 0.0).then(|| 1.0 - variance(residuals) / variance_of_returns)
}

fn variance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explained_variance_is_one_for_a_perfect_critic_and_absent_without_variance() {
        let mut rollouts = vec![Rollout::new(2, 1, 1); 2];
        assert_eq!(explained_variance(&rollouts), None);
        (rollouts[0].returns, rollouts[1].returns) = (vec![1.0, 2.0], vec![3.0, 4.0]);
        assert_eq!(explained_variance(&rollouts), Some(0.0));
        // A constant error is not variance.
        (rollouts[0].values, rollouts[1].values) = (vec![0.0, 1.0], vec![2.0, 3.0]);
        assert_eq!(explained_variance(&rollouts), Some(1.0));
        (rollouts[0].values, rollouts[1].values) = (vec![4.0, 3.0], vec![2.0, 1.0]);
        assert_eq!(explained_variance(&rollouts), Some(-3.0));
    }

    #[test]
    fn the_last_value_counts_unless_an_episode_has_ended() {
        let mut rollout = Rollout::new(2, 1, 1);
        rollout.rewards = vec![1.0, 1.0];
        rollout.finish(4.0, true, 0.5, 1.0);
        assert_eq!(rollout.advantages, [1.5, 1.0]);
        rollout.rewards = vec![10.0, 10.0];
        rollout.finish(40.0, false, 0.5, 1.0);
        assert_eq!(rollout.advantages, [25.0, 30.0]);
    }
}
