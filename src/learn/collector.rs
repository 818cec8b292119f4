//! Acting in environments to fill rollouts.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::actor_critic::ActorCritic;
use super::arithmetic::Path;
use super::config::PpoConfig;
use super::env::{Agent, Env};
use super::lane::Lane;
use super::log::FinishedEpisode;
use super::moments::RunningMoments;
use super::rollout::Rollout;
use super::train_error::Quantity;
use base::seed::Seed;

/// The number of ended episodes over which reward and length are averaged.
const STATISTICS_WINDOW: usize = 100;

/// The environments in the middle of their episodes.
///
/// Every environment has its own noise. Between two exchanges of statistics it runs on its own, so the numbers are the same
/// on one thread and on many.
#[derive(Debug, Clone)]
pub(super) struct Collector {
    pub(super) lanes: Vec<Lane>,
    pub(super) recent: VecDeque<FinishedEpisode>,
    /// The moments of the discounted sums of rewards of each policy, when rewards are normalised.
    pub(super) return_moments: Vec<RunningMoments>,
    gamma: f64,
    /// The discount of the state in which the time limit cuts an episode: `gamma`, or 0 without a bootstrap.
    cut_gamma: f64,
    lambda: f64,
    path: Path,
    /// The maximum number of threads.
    threads: usize,
    /// The number of agents of an environment.
    pub(super) agents: usize,
}

impl Collector {
    /// Makes a collector that precedes the first episode of every environment; `noise` is that of the actions.
    pub(super) fn new<E: Env>(
        envs: &[E],
        policies: &[ActorCritic],
        config: &PpoConfig,
        noise: &Seed,
        path: Path,
    ) -> Self {
        let sizes = (config.frame_stack, config.batch_size.min(config.steps_per_update));
        let agents = agents(envs);
        let each = envs.iter().flat_map(|env| agents.iter().map(move |agent| (env, agent)));
        let lane = |(i, (env, agent)): (u64, (&E, &Agent))| {
            Lane::new(env, agent, &policies[agent.policy], sizes, noise.index(i).stream())
        };
        Self {
            lanes: (0..).zip(each).map(lane).collect(),
            recent: VecDeque::with_capacity(STATISTICS_WINDOW + 1),
            return_moments: policies
                .iter()
                .filter(|_| config.normalize_rewards)
                .map(|_| RunningMoments::new(1))
                .collect(),
            gamma: config.gamma,
            cut_gamma: if config.time_limit_bootstrap { config.gamma } else { 0.0 },
            lambda: config.gae_lambda,
            path,
            threads: config.threads.unwrap_or(usize::MAX),
            agents: agents.len(),
        }
    }

    /// Starts an episode in every environment.
    pub(super) fn begin<E: Env>(&mut self, envs: &mut [E], policies: &mut [ActorCritic]) -> Result<(), Quantity> {
        for (env, lanes) in envs.iter_mut().zip(self.lanes.chunks_mut(self.agents)) {
            Lane::begin(lanes, env)?;
        }
        observe(policies, &self.lanes);
        Ok(())
    }

    /// Fills one rollout for every lane with the experience of its policy, including advantages and returns. Returns the
    /// episodes that ended; `None` if `stop` was true, which is asked before every step.
    ///
    /// # Source
    /// `collect_rollouts` and `VecNormalize.step_wait` of stable-baselines3: statistics include the observations and
    /// rewards of a step in all environments before one of them is normalised.
    pub(super) fn collect<E: Env + Send>(
        &mut self,
        envs: &mut [E],
        policies: &mut [ActorCritic],
        rollouts: &mut [Rollout],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Vec<FinishedEpisode>>, Quantity> {
        let stopped = AtomicBool::new(false);
        let is_stopped = || {
            stopped.fetch_or(stop(), Ordering::Relaxed);
            stopped.load(Ordering::Relaxed)
        };
        let (steps, gamma, lambda, path) = (rollouts[0].len(), self.gamma, self.lambda, self.path);
        let cut_gamma = self.cut_gamma;
        self.lanes.iter_mut().for_each(|lane| lane.prepare(&policies[lane.policy]));
        if self.return_moments.is_empty() && policies[0].observation_moments().is_none() {
            let policies = &*policies;
            side_by_side((self.threads, self.agents), envs, &mut self.lanes, rollouts, |env, lanes, rollouts| {
                for t in 0..steps {
                    if is_stopped() {
                        return;
                    }
                    if let Err(quantity) = Lane::step(lanes, env, policies, rollouts, t, gamma) {
                        lanes[0].failure = Some((t, quantity));
                        return;
                    }
                    for (lane, rollout) in lanes.iter_mut().zip(&mut *rollouts) {
                        lane.settle(&policies[lane.policy], rollout, t, lane.earned, cut_gamma);
                    }
                }
                for (lane, rollout) in lanes.iter_mut().zip(rollouts) {
                    lane.finish(&policies[lane.policy], rollout, gamma, lambda, path);
                }
            });
            self.failure()?;
        } else {
            for t in 0..steps {
                if is_stopped() {
                    return Ok(None);
                }
                let now = &*policies;
                side_by_side((self.threads, self.agents), envs, &mut self.lanes, rollouts, |env, lanes, rollouts| {
                    let step = Lane::step(lanes, env, now, rollouts, t, gamma);
                    lanes[0].failure = step.err().map(|quantity| (t, quantity));
                });
                self.failure()?;
                observe(policies, &self.lanes);
                self.settle(policies, rollouts, t);
            }
            let policies = &*policies;
            side_by_side((self.threads, self.agents), envs, &mut self.lanes, rollouts, |_, lanes, rollouts| {
                for (lane, rollout) in lanes.iter_mut().zip(rollouts) {
                    lane.finish(&policies[lane.policy], rollout, gamma, lambda, path);
                }
            });
        }
        Ok((!stopped.into_inner()).then(|| self.finished()))
    }

    /// Records the rewards of a step, normalised if the settings ask for it.
    fn settle(&mut self, policies: &[ActorCritic], rollouts: &mut [Rollout], t: usize) {
        if !self.return_moments.is_empty() {
            self.lanes.iter_mut().for_each(|lane| lane.discounted = lane.discounted * self.gamma + lane.earned);
        }
        for (policy, moments) in self.return_moments.iter_mut().enumerate() {
            let own = self.lanes.iter().filter(|lane| lane.policy == policy);
            moments.update(own.map(|lane| std::slice::from_ref(&lane.discounted)));
        }
        for (lane, rollout) in self.lanes.iter_mut().zip(rollouts) {
            let moments = self.return_moments.get(lane.policy);
            let reward = moments.map_or(lane.earned, |moments| moments.scaled(0, lane.earned));
            lane.settle(&policies[lane.policy], rollout, t, reward, self.cut_gamma);
        }
    }

    /// Returns the first failure in the order of steps, then environments.
    fn failure(&self) -> Result<(), Quantity> {
        let first = self.lanes.iter().filter_map(|lane| lane.failure).min_by_key(|(t, _)| *t);
        first.map_or(Ok(()), |(_, quantity)| Err(quantity))
    }

    /// Returns the episodes of the rollout in the order in which they ended.
    fn finished(&mut self) -> Vec<FinishedEpisode> {
        let count = self.lanes.iter().map(|lane| lane.finished.len()).sum();
        let mut ends = Vec::with_capacity(count);
        for (env, lane) in self.lanes.iter().enumerate() {
            ends.extend(lane.finished.iter().map(|(t, episode)| (*t, env, *episode)));
        }
        ends.sort_unstable_by_key(|(t, env, _)| (*t, *env));
        let finished: Vec<FinishedEpisode> = ends.into_iter().map(|(_, _, episode)| episode).collect();
        for episode in &finished {
            self.recent.push_back(*episode);
            if self.recent.len() > STATISTICS_WINDOW {
                self.recent.pop_front();
            }
        }
        finished
    }

    /// Returns the mean reward and length of the most recent episodes and the shares of successes and faults among them, if any has ended; the last
    /// one only where all were judged.
    pub(super) fn recent_means(&self) -> Option<(f64, f64, f64, Option<f64>)> {
        let count = self.recent.len() as f64;
        let successes = self.recent.iter().filter(|episode| episode.success).count() as f64;
        let reward: f64 = self.recent.iter().map(|episode| episode.reward).sum();
        let length: f64 = self.recent.iter().map(|episode| episode.length as f64).sum();
        let faults: Option<Vec<bool>> = self.recent.iter().map(|episode| episode.fault).collect();
        let faults = faults.map(|faults| faults.into_iter().filter(|fault| *fault).count() as f64 / count);
        (count > 0.0).then(|| (reward / count, length / count, successes / count, faults))
    }
}

/// Adds the observations of the next decisions to the statistics of their policies.
pub(super) fn observe(policies: &mut [ActorCritic], lanes: &[Lane]) {
    for (number, policy) in policies.iter_mut().enumerate() {
        if let Some(moments) = policy.observation_moments_mut() {
            let own = lanes.iter().filter(|lane| lane.policy == number);
            moments.update(own.map(|lane| lane.stack.as_slice()));
        }
    }
}

/// The agents of an environment, which are the same for all.
pub(super) fn agents<E: Env>(envs: &[E]) -> Vec<Agent> {
    envs.first().map(Env::agents).unwrap_or_default()
}

/// Works on all environments, on at most this number of the available threads; each has this number of agents.
fn side_by_side<E: Env + Send>(
    (threads, agents): (usize, usize),
    envs: &mut [E],
    lanes: &mut [Lane],
    rollouts: &mut [Rollout],
    work: impl Fn(&mut E, &mut [Lane], &mut [Rollout]) + Sync,
) {
    if threads == 1 || envs.len() == 1 {
        let each = envs.iter_mut().zip(lanes.chunks_mut(agents)).zip(rollouts.chunks_mut(agents));
        each.for_each(|((env, lanes), rollouts)| work(env, lanes, rollouts));
    } else {
        let share = envs.len().div_ceil(threads);
        let all = envs.par_iter_mut().zip(lanes.par_chunks_mut(agents)).zip(rollouts.par_chunks_mut(agents));
        all.with_min_len(share).for_each(|((env, lanes), rollouts)| work(env, lanes, rollouts));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Step;
    use crate::gaussian::{Gaussian, Spread};

    /// Ends after `length` steps, terminated or truncated; the observation counts from 1.
    struct Ending {
        terminated: bool,
        truncated: bool,
        length: f64,
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
            let end = self.steps == self.length + 1.0;
            Step { reward: 1.0, terminated: end && self.terminated, truncated: end && self.truncated }
        }
    }

    fn config(steps: usize) -> PpoConfig {
        PpoConfig { steps_per_update: steps, batch_size: 4, gamma: 0.9, ..PpoConfig::paper() }
    }

    fn collect(
        config: &PpoConfig,
        mut envs: Vec<Ending>,
    ) -> (Vec<Rollout>, Vec<FinishedEpisode>, ActorCritic, Vec<Ending>, Collector) {
        let mut policy = ActorCritic::new(config.frame_stack, 1, &[8], 0.0, &mut Seed::root(2).stream());
        *policy.observation_moments_mut() =
            config.normalize_observations.then(|| RunningMoments::new(config.frame_stack));
        let mut rollouts = vec![Rollout::new(config.steps_per_update, config.frame_stack, 1); envs.len()];
        let policies = std::slice::from_mut(&mut policy);
        let mut collector = Collector::new(&envs, policies, config, &Seed::root(3), Path::widest());
        collector.begin(&mut envs, policies).unwrap();
        let finished = collector.collect(&mut envs, policies, &mut rollouts, &|| false).unwrap().unwrap();
        (rollouts, finished, policy, envs, collector)
    }

    fn ending(terminated: bool, truncated: bool) -> Ending {
        Ending { terminated, truncated, length: 3.0, steps: 0.0, actions: Vec::new() }
    }

    fn rollout(
        terminated: bool,
        truncated: bool,
        steps: usize,
    ) -> (Rollout, Vec<FinishedEpisode>, ActorCritic, Vec<f64>) {
        let (mut rollouts, finished, policy, mut envs, _) =
            collect(&config(steps), vec![ending(terminated, truncated)]);
        (rollouts.remove(0), finished, policy, envs.remove(0).actions)
    }

    #[test]
    fn truncation_bootstraps_and_termination_does_not() {
        let (buffer, finished, policy, _) = rollout(false, true, 7);
        let bootstrap = 0.9 * policy.value(&[4.0], &mut policy.scratch(1));
        assert!(bootstrap.abs() > 1e-3);
        let cut = 1.0 + bootstrap;
        assert_eq!(buffer.rewards, [1.0, 1.0, cut, 1.0, 1.0, cut, 1.0]);
        assert_eq!(buffer.episode_starts, [true, false, false, true, false, false, true]);
        // The log has the environment's own rewards.
        assert_eq!(finished, [FinishedEpisode { reward: 3.0, length: 3, success: false, fault: None }; 2]);
        for both in [false, true] {
            assert_eq!(rollout(true, both, 7).0.rewards, [1.0; 7]);
        }
        // The advantage of a last step includes nothing from the next episode.
        assert_eq!(buffer.advantages[2], cut - buffer.values[2]);
        // This is true even if the next episode starts after the rollout.
        let (whole, ..) = rollout(false, true, 6);
        assert_eq!(whole.advantages[5], cut - whole.values[5]);
        // Without a bootstrap a time limit is an end like others.
        let done = PpoConfig { time_limit_bootstrap: false, ..config(7) };
        assert_eq!(collect(&done, vec![ending(false, true)]).0[0].rewards, [1.0; 7]);
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
            let log_prob = Gaussian { mean: &mean, spread: &Spread::new(1) }.log_prob(&[*sampled]);
            assert!((buffer.log_probs[i] - log_prob).abs() < 1e-6);
        }
    }

    #[test]
    fn observations_are_normalised_by_all_that_was_seen_up_to_then() {
        let config = PpoConfig { normalize_observations: true, ..config(7) };
        let (rollouts, _, policy, ..) = collect(&config, vec![ending(true, false), ending(false, true)]);
        let mut moments = RunningMoments::new(1);
        let mut raw = [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0].into_iter();
        for t in 0..7 {
            let sample = [raw.next().unwrap()];
            moments.update([&sample[..]; 2].into_iter());
            for rollout in &rollouts {
                assert_eq!(rollout.obs[t], moments.normalised(0, sample[0]) as f32, "{t}");
            }
        }
        // The first observation of the next rollout has been included, too.
        moments.update([&[2.0][..]; 2].into_iter());
        assert_eq!(policy.observation_moments(), Some(&moments));
        // Where the episode was cut off, the final observation is normalised with the statistics of that step. These include the
        // first observation of the next episode instead of it.
        let moments_then = {
            let mut moments = RunningMoments::new(1);
            [1.0, 2.0, 3.0, 1.0].iter().for_each(|x| moments.update([std::slice::from_ref(x); 2].into_iter()));
            moments
        };
        let mut policy_then = policy.clone();
        *policy_then.observation_moments_mut() = Some(moments_then);
        let bootstrap = 0.9 * policy_then.value(&[4.0], &mut policy.scratch(1));
        assert_eq!(rollouts[1].rewards[2], 1.0 + bootstrap);
        assert_eq!(rollouts[0].rewards[2], 1.0);
    }

    #[test]
    fn rewards_are_divided_by_the_deviation_of_the_discounted_return() {
        let config = PpoConfig { normalize_rewards: true, ..config(5) };
        let (rollouts, finished, _, _, collector) = collect(&config, vec![ending(true, false), ending(true, false)]);
        let mut moments = RunningMoments::new(1);
        // Reward 1 in every step, γ = 0.9, an episode of three steps.
        for (t, discounted) in [1.0, 1.9, 2.71, 1.0, 1.9].into_iter().enumerate() {
            moments.update([&[discounted][..]; 2].into_iter());
            let expected = (1.0 / (moments.variance[0] + 1e-8).sqrt()).min(10.0);
            assert!((rollouts[1].rewards[t] - expected).abs() < 1e-9, "{t}");
        }
        assert!((collector.return_moments[0].variance[0] - moments.variance[0]).abs() < 1e-12);
        // The log has the environment's own rewards.
        assert_eq!(finished, [FinishedEpisode { reward: 3.0, length: 3, success: false, fault: None }; 2]);
    }

    #[test]
    fn stacked_observations_begin_with_zeros_and_end_with_the_newest() {
        let config = PpoConfig { frame_stack: 2, ..config(5) };
        let (rollouts, _, policy, ..) = collect(&config, vec![ending(false, true)]);
        assert_eq!(rollouts[0].obs, [0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 0.0, 1.0, 1.0, 2.0]);
        let bootstrap = 0.9 * policy.value(&[3.0, 4.0], &mut policy.scratch(1));
        assert_eq!(rollouts[0].rewards[2], 1.0 + bootstrap);
    }

    #[test]
    fn finished_episodes_come_in_the_order_of_steps_then_environments() {
        let shorter = Ending { length: 2.0, ..ending(true, false) };
        let (_, finished, _, _, collector) = collect(&config(7), vec![ending(true, false), shorter]);
        let lengths: Vec<u64> = finished.iter().map(|episode| episode.length).collect();
        // After steps 2, 3 and 4, and twice after step 6.
        assert_eq!(lengths, [2, 3, 2, 3, 2]);
        assert_eq!(collector.recent_means(), Some((2.4, 2.4, 0.0, None)));
    }
}
