//! The experience of one rollout.

use super::gae::{Trajectory, advantages_and_returns};

/// The experience of several environments over a fixed number of steps.
///
/// All columns are ordered by step, then environment: the sample of step `t` in environment `e` is `t · n_envs + e`.
///
/// # Source
/// `RolloutBuffer` of stable-baselines3.
#[derive(Debug, Clone)]
pub(super) struct RolloutBuffer {
    pub(super) n_envs: usize,
    pub(super) obs_dim: usize,
    pub(super) action_dim: usize,
    /// obs_dim × samples, column-major.
    pub(super) obs: Vec<f32>,
    /// action_dim × samples, column-major, before clipping to the bounds.
    pub(super) actions: Vec<f64>,
    pub(super) log_probs: Vec<f64>,
    /// With the value of the final observation added where an episode was cut off.
    pub(super) rewards: Vec<f64>,
    pub(super) episode_starts: Vec<bool>,
    pub(super) values: Vec<f64>,
    pub(super) advantages: Vec<f64>,
    pub(super) returns: Vec<f64>,
}

impl RolloutBuffer {
    /// Makes room for `steps` steps of each environment.
    pub(super) fn new(steps: usize, n_envs: usize, obs_dim: usize, action_dim: usize) -> Self {
        let samples = steps * n_envs;
        let zeros = || vec![0.0; samples];
        Self {
            n_envs,
            obs_dim,
            action_dim,
            obs: vec![0.0; samples * obs_dim],
            actions: vec![0.0; samples * action_dim],
            log_probs: zeros(),
            rewards: zeros(),
            episode_starts: vec![false; samples],
            values: zeros(),
            advantages: zeros(),
            returns: zeros(),
        }
    }

    /// Returns the number of samples.
    pub(super) fn len(&self) -> usize {
        self.rewards.len()
    }

    /// Computes advantages and returns from rewards and values.
    ///
    /// `last_values` are the critic's values of the observations after the last step, `last_dones` whether that step ended
    /// an episode; one element per environment.
    pub(super) fn finish(&mut self, last_values: &[f64], last_dones: &[bool], gamma: f64, lambda: f64) {
        for env in 0..self.n_envs {
            let trajectory = Trajectory {
                rewards: &self.rewards[env..],
                values: &self.values[env..],
                episode_starts: &self.episode_starts[env..],
                last_value: last_values[env],
                last_done: last_dones[env],
            };
            let (advantages, returns) = (&mut self.advantages[env..], &mut self.returns[env..]);
            advantages_and_returns(trajectory, self.n_envs, gamma, lambda, advantages, returns);
        }
    }

    /// Returns the share of the returns' variance that the values explain; absent when the returns do not vary.
    pub(super) fn explained_variance(&self) -> Option<f64> {
        let variance_of_returns = variance(self.returns.iter().copied());
        let residuals = self.returns.iter().zip(&self.values).map(|(expected, value)| expected - value);
        (variance_of_returns > 0.0).then(|| 1.0 - variance(residuals) / variance_of_returns)
    }
}

fn variance(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len() as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explained_variance_is_one_for_a_perfect_critic_and_absent_without_variance() {
        let mut buffer = RolloutBuffer::new(2, 2, 1, 1);
        assert_eq!(buffer.explained_variance(), None);
        buffer.returns = vec![1.0, 2.0, 3.0, 4.0];
        assert_eq!(buffer.explained_variance(), Some(0.0));
        // A constant error is not variance.
        buffer.values = vec![0.0, 1.0, 2.0, 3.0];
        assert_eq!(buffer.explained_variance(), Some(1.0));
        buffer.values = vec![4.0, 3.0, 2.0, 1.0];
        assert_eq!(buffer.explained_variance(), Some(-3.0));
    }

    #[test]
    fn environments_are_finished_independently() {
        let mut buffer = RolloutBuffer::new(2, 2, 1, 1);
        buffer.rewards = vec![1.0, 10.0, 1.0, 10.0];
        buffer.finish(&[4.0, 40.0], &[true, false], 0.5, 1.0);
        assert_eq!(buffer.advantages, [1.5, 25.0, 1.0, 30.0]);
    }
}
