//! Acting in environments to fill a rollout.

use std::collections::VecDeque;

use super::actor_critic::{ActorCritic, Scratch};
use super::env::Env;
use super::gaussian::Gaussian;
use super::log::FinishedEpisode;
use super::normal::standard_normal;
use super::ppo::Quantity;
use super::rollout::RolloutBuffer;
use crate::seed::Stream;

/// The number of episodes over which reward and length are averaged.
const RECENT_EPISODES: usize = 100;

/// The environments in mid-episode, and the actions' noise.
#[derive(Debug)]
pub(super) struct Collector<'e, E> {
    envs: &'e mut [E],
    bounds: Vec<Vec<(f64, f64)>>,
    gamma: f64,
    noise: Stream,
    /// obs_dim × environments: what the next decisions are taken from.
    obs: Vec<f64>,
    /// Whether `obs` is the first observation of an episode.
    starts: Vec<bool>,
    running: Vec<FinishedEpisode>,
    recent: VecDeque<FinishedEpisode>,
    log_std: Vec<f64>,
    mean: Vec<f64>,
    clipped: Vec<f64>,
    last_values: Vec<f64>,
    scratch: Scratch,
    chunk: usize,
}

impl<'e, E: Env> Collector<'e, E> {
    /// Resets all environments.
    pub(super) fn new(
        envs: &'e mut [E],
        policy: &ActorCritic,
        gamma: f64,
        chunk: usize,
        noise: Stream,
    ) -> Result<Self, Quantity> {
        let (n_envs, obs_dim, action_dim) = (envs.len(), policy.obs_dim(), policy.action_dim());
        let mut obs = vec![0.0; n_envs * obs_dim];
        for (env, obs) in envs.iter_mut().zip(obs.chunks_exact_mut(obs_dim)) {
            env.reset(obs);
        }
        representable(&obs)?;
        let chunk = chunk.max(n_envs);
        Ok(Self {
            bounds: envs.iter().map(Env::action_bounds).collect(),
            envs,
            gamma,
            noise,
            obs,
            starts: vec![true; n_envs],
            running: vec![FinishedEpisode { reward: 0.0, length: 0 }; n_envs],
            recent: VecDeque::with_capacity(RECENT_EPISODES + 1),
            log_std: vec![0.0; action_dim],
            mean: vec![0.0; action_dim],
            clipped: vec![0.0; action_dim],
            last_values: vec![0.0; n_envs],
            scratch: policy.scratch(chunk),
            chunk,
        })
    }

    /// Fills the buffer with the policy's experience, advantages and returns included, and returns the episodes that
    /// ended.
    pub(super) fn collect(
        &mut self,
        policy: &ActorCritic,
        buffer: &mut RolloutBuffer,
        lambda: f64,
    ) -> Result<Vec<FinishedEpisode>, Quantity> {
        for (slot, log_std) in self.log_std.iter_mut().zip(policy.log_std()) {
            *slot = f64::from(*log_std);
        }
        let mut finished = Vec::new();
        for step in 0..buffer.len() / self.envs.len() {
            self.step(policy, buffer, step, &mut finished)?;
        }
        self.values(policy, buffer);
        for env in 0..self.envs.len() {
            let obs = &self.obs[env * buffer.obs_dim..(env + 1) * buffer.obs_dim];
            self.last_values[env] = policy.value(obs, &mut self.scratch);
        }
        buffer.finish(&self.last_values, &self.starts, self.gamma, lambda);
        Ok(finished)
    }

    /// Returns the mean reward and length of the most recent episodes, if any has ended.
    pub(super) fn recent_means(&self) -> Option<(f64, f64)> {
        let count = self.recent.len() as f64;
        let reward: f64 = self.recent.iter().map(|episode| episode.reward).sum();
        let length: f64 = self.recent.iter().map(|episode| episode.length as f64).sum();
        (count > 0.0).then(|| (reward / count, length / count))
    }

    fn step(
        &mut self,
        policy: &ActorCritic,
        buffer: &mut RolloutBuffer,
        step: usize,
        finished: &mut Vec<FinishedEpisode>,
    ) -> Result<(), Quantity> {
        let (n_envs, obs_dim, action_dim) = (self.envs.len(), buffer.obs_dim, buffer.action_dim);
        let first = step * n_envs;
        let inputs = &mut buffer.obs[first * obs_dim..(first + n_envs) * obs_dim];
        for (slot, obs) in inputs.iter_mut().zip(&self.obs) {
            *slot = *obs as f32;
        }
        let parameters = &policy.parameters()[policy.actor_range()];
        let means = policy.actor().forward(parameters, inputs, &mut self.scratch.actor);
        for (slot, mean) in buffer.actions[first * action_dim..].iter_mut().zip(means) {
            *slot = f64::from(*mean);
        }

        for env in 0..n_envs {
            let sample = first + env;
            let action = &mut buffer.actions[sample * action_dim..(sample + 1) * action_dim];
            self.mean.copy_from_slice(action);
            for (action, log_std) in action.iter_mut().zip(&self.log_std) {
                *action += libm::exp(*log_std) * standard_normal(&mut self.noise);
            }
            finite(action, Quantity::Action)?;
            buffer.log_probs[sample] = Gaussian { mean: &self.mean, log_std: &self.log_std }.log_prob(action);
            buffer.episode_starts[sample] = self.starts[env];
            for ((slot, action), (low, high)) in self.clipped.iter_mut().zip(action.iter()).zip(&self.bounds[env]) {
                *slot = action.max(*low).min(*high);
            }

            let obs = &mut self.obs[env * obs_dim..(env + 1) * obs_dim];
            let outcome = self.envs[env].step(&self.clipped, obs);
            finite(&[outcome.reward], Quantity::Reward)?;
            representable(obs)?;
            let mut reward = outcome.reward;
            if outcome.truncated && !outcome.terminated {
                reward += self.gamma * policy.value(obs, &mut self.scratch);
            }
            buffer.rewards[sample] = reward;
            self.starts[env] = outcome.done();
            let running = &mut self.running[env];
            running.reward += outcome.reward;
            running.length += 1;
            if outcome.done() {
                let episode = std::mem::replace(running, FinishedEpisode { reward: 0.0, length: 0 });
                finished.push(episode);
                self.recent.push_back(episode);
                if self.recent.len() > RECENT_EPISODES {
                    self.recent.pop_front();
                }
                self.envs[env].reset(obs);
                representable(obs)?;
            }
        }
        Ok(())
    }

    /// Values the observations of the whole rollout, which is cheaper than one by one while acting: the critic does not
    /// change in between.
    fn values(&mut self, policy: &ActorCritic, buffer: &mut RolloutBuffer) {
        let obs = buffer.obs.chunks(self.chunk * buffer.obs_dim);
        for (obs, values) in obs.zip(buffer.values.chunks_mut(self.chunk)) {
            policy.values(obs, values, &mut self.scratch);
        }
    }
}

fn finite(values: &[f64], quantity: Quantity) -> Result<(), Quantity> {
    if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(quantity) }
}

/// Refuses observations that the networks would see as infinite.
fn representable(obs: &[f64]) -> Result<(), Quantity> {
    if obs.iter().all(|&value| (value as f32).is_finite()) { Ok(()) } else { Err(Quantity::Observation) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rl::env::Step;
    use crate::seed::Seed;

    /// Ends every third step, either way; the observation counts from 1.
    struct Ending {
        terminated: bool,
        truncated: bool,
        steps: f64,
        actions: Vec<f64>,
    }

    impl Env for Ending {
        fn obs_dim(&self) -> usize {
            1
        }

        fn action_bounds(&self) -> Vec<(f64, f64)> {
            vec![(-0.25, 0.5)]
        }

        fn reset(&mut self, obs: &mut [f64]) {
            self.steps = 1.0;
            obs[0] = 1.0;
        }

        fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
            self.actions.push(action[0]);
            self.steps += 1.0;
            obs[0] = self.steps;
            let end = self.steps == 4.0;
            Step { reward: 1.0, terminated: end && self.terminated, truncated: end && self.truncated }
        }
    }

    fn rollout(
        terminated: bool,
        truncated: bool,
        steps: usize,
    ) -> (RolloutBuffer, Vec<FinishedEpisode>, ActorCritic, Vec<f64>) {
        let policy = ActorCritic::new(1, 1, &[8], 0.0, &mut Seed::root(2).stream());
        let mut envs = [Ending { terminated, truncated, steps: 0.0, actions: Vec::new() }];
        let mut buffer = RolloutBuffer::new(steps, 1, 1, 1);
        let mut collector = Collector::new(&mut envs, &policy, 0.9, 4, Seed::root(3).stream()).unwrap();
        let finished = collector.collect(&policy, &mut buffer, 0.95).unwrap();
        let [env] = envs;
        (buffer, finished, policy, env.actions)
    }

    #[test]
    fn truncation_bootstraps_and_termination_does_not() {
        let (buffer, finished, policy, _) = rollout(false, true, 7);
        let bootstrap = 0.9 * policy.value(&[4.0], &mut policy.scratch(1));
        assert!(bootstrap.abs() > 1e-3);
        let cut = 1.0 + bootstrap;
        assert_eq!(buffer.rewards, [1.0, 1.0, cut, 1.0, 1.0, cut, 1.0]);
        assert_eq!(buffer.episode_starts, [true, false, false, true, false, false, true]);
        // The report has the environment's own rewards.
        assert_eq!(finished, [FinishedEpisode { reward: 3.0, length: 3 }; 2]);
        for both in [false, true] {
            assert_eq!(rollout(true, both, 7).0.rewards, [1.0; 7]);
        }
        // The advantage of a last step takes nothing from the next episode.
        assert_eq!(buffer.advantages[2], cut - buffer.values[2]);
        // Not even when the next episode begins after the rollout.
        let (whole, ..) = rollout(false, true, 6);
        assert_eq!(whole.advantages[5], cut - whole.values[5]);
        let (open, ..) = rollout(false, true, 5);
        assert_ne!(open.advantages[4], 1.0 - open.values[4]);
    }

    #[test]
    fn values_are_those_of_the_recorded_observations() {
        let (buffer, _, policy, _) = rollout(true, false, 7);
        assert_eq!(buffer.obs, [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0]);
        for (obs, value) in buffer.obs.iter().zip(&buffer.values) {
            let expected = policy.value(&[f64::from(*obs)], &mut policy.scratch(1));
            assert!((value - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn the_environment_gets_clipped_actions_and_the_learner_keeps_the_sampled_ones() {
        let (buffer, _, policy, taken) = rollout(true, false, 7);
        assert!(buffer.actions.iter().any(|action| !(-0.25..=0.5).contains(action)));
        for (i, (sampled, taken)) in buffer.actions.iter().zip(taken).enumerate() {
            assert_eq!(sampled.clamp(-0.25, 0.5), taken);
            let mut mean = [0.0];
            policy.act(&[f64::from(buffer.obs[i])], &mut mean, &mut policy.scratch(1));
            let log_prob = Gaussian { mean: &mean, log_std: &[0.0] }.log_prob(&[*sampled]);
            assert!((buffer.log_probs[i] - log_prob).abs() < 1e-6);
        }
    }
}
