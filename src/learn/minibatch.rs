//! The samples of one gradient step.

use rand::Rng;

use super::arithmetic::Real;
use super::rollout::Rollout;
use base::seed::Stream;

/// Samples drawn from a rollout, copied into contiguous memory.
#[derive(Debug, Clone)]
pub(super) struct Minibatch<T> {
    /// obs_dim × samples, column-major.
    pub(super) obs: Vec<T>,
    /// action_dim × samples, column-major.
    pub(super) actions: Vec<f64>,
    pub(super) old_log_probs: Vec<f64>,
    pub(super) advantages: Vec<f64>,
    pub(super) returns: Vec<f64>,
}

impl<T: Real> Minibatch<T> {
    /// Makes room for `capacity` samples.
    pub(super) fn with_capacity(capacity: usize, obs_dim: usize, action_dim: usize) -> Self {
        Self {
            obs: Vec::with_capacity(capacity * obs_dim),
            actions: Vec::with_capacity(capacity * action_dim),
            old_log_probs: Vec::with_capacity(capacity),
            advantages: Vec::with_capacity(capacity),
            returns: Vec::with_capacity(capacity),
        }
    }

    /// Returns the number of samples.
    pub(super) fn len(&self) -> usize {
        self.returns.len()
    }

    /// Replaces the content by the samples with these numbers.
    ///
    /// Samples are counted by environment, then step; all rollouts are of equal length.
    pub(super) fn gather(&mut self, rollouts: &[Rollout], samples: &[usize]) {
        self.obs.clear();
        self.actions.clear();
        self.old_log_probs.clear();
        self.advantages.clear();
        self.returns.clear();
        let steps = rollouts[0].len();
        for &sample in samples {
            let (rollout, i) = (&rollouts[sample / steps], sample % steps);
            let obs = &rollout.obs[i * rollout.obs_dim..(i + 1) * rollout.obs_dim];
            self.obs.extend(obs.iter().map(|&x| T::rounded(f64::from(x))));
            self.actions.extend_from_slice(&rollout.actions[i * rollout.action_dim..(i + 1) * rollout.action_dim]);
            self.old_log_probs.push(rollout.log_probs[i]);
            self.advantages.push(rollout.advantages[i]);
            self.returns.push(rollout.returns[i]);
        }
    }

    /// Scales the advantages to mean 0 and variance 1; a single one is not changed.
    ///
    /// # Source
    /// stable-baselines3: the unbiased standard deviation, plus 10⁻⁸.
    pub(super) fn normalise_advantages(&mut self) {
        let count = self.advantages.len() as f64;
        if count < 2.0 {
            return;
        }
        let mean = self.advantages.iter().sum::<f64>() / count;
        let squares: f64 = self.advantages.iter().map(|x| (x - mean) * (x - mean)).sum();
        let std = (squares / (count - 1.0)).sqrt();
        for advantage in &mut self.advantages {
            *advantage = (*advantage - mean) / (std + 1e-8);
        }
    }
}

/// Shuffles the elements; all orders are equally likely.
///
/// # Source
/// Fisher and Yates, in Durstenfeld's form.
pub(super) fn shuffle(order: &mut [usize], stream: &mut Stream) {
    for end in (1..order.len()).rev() {
        // The high word of a 64 × 64-bit product: the bias is below 2⁻⁵⁰ for any rollout.
        let pick = (u128::from(stream.next_u64()) * (end as u128 + 1)) >> 64;
        order.swap(end, pick as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    #[test]
    fn a_shuffle_is_a_permutation_and_reaches_all_orders_alike() {
        let mut stream = Seed::root(9).stream();
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..6000 {
            let mut order = [0, 1, 2];
            shuffle(&mut order, &mut stream);
            *counts.entry(order).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|count| (850..1150).contains(count)), "{counts:?}");
    }

    #[test]
    fn advantages_are_normalised_by_the_unbiased_deviation() {
        let mut batch = Minibatch::<f64>::with_capacity(3, 1, 1);
        batch.advantages = vec![1.0, 2.0, 6.0];
        batch.normalise_advantages();
        // Mean 3, squares 4 + 1 + 9 over 2.
        let std = 7f64.sqrt();
        for (x, expected) in batch.advantages.iter().zip([-2.0 / std, -1.0 / std, 3.0 / std]) {
            assert!((x - expected).abs() < 1e-7);
        }
        batch.advantages = vec![5.0];
        batch.normalise_advantages();
        assert_eq!(batch.advantages, [5.0]);
    }

    #[test]
    fn gathering_follows_the_given_order() {
        let mut rollouts = vec![Rollout::new(3, 2, 1); 2];
        rollouts[0].obs = vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
        rollouts[0].actions = vec![10.0, 11.0, 12.0];
        rollouts[0].returns = vec![20.0, 21.0, 22.0];
        rollouts[1].obs = vec![3.0, 3.5, 4.0, 4.5, 5.0, 5.5];
        rollouts[1].values = vec![30.0, 31.0, 32.0];
        let mut batch = Minibatch::<f64>::with_capacity(3, 2, 1);
        batch.gather(&rollouts, &[2, 4, 0]);
        assert_eq!(batch.obs, [2.0, 2.5, 4.0, 4.5, 0.0, 0.5]);
        assert_eq!(batch.actions, [12.0, 0.0, 10.0]);
        assert_eq!(batch.returns, [22.0, 0.0, 20.0]);
        assert_eq!(batch.len(), 3);
    }
}
