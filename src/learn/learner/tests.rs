use rand::Rng;

use super::*;
use crate::collector::Collector;
use crate::env::{Env, Step};
use crate::minibatch::shuffle;
use base::seed::{Seed, Stream};

/// Rewards actions near the observation; an episode is one decision.
struct Echo(Stream, f64);

impl Env for Echo {
    fn obs_dim(&self) -> usize {
        1
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        vec![(-1.0, 1.0)]
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.1 = self.0.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
        obs[0] = self.1;
    }

    fn step(&mut self, action: &[f64], _: &mut [f64]) -> Step {
        Step { reward: -(action[0] - self.1) * (action[0] - self.1), terminated: true, truncated: false }
    }
}

/// A rollout of the identity task and a learner that has not learned from it yet.
fn learner_and_rollout(config: &PpoConfig) -> (ActorCritic, Learner, Vec<Rollout>) {
    let mut policy = ActorCritic::new(1, 1, &config.hidden, 0.0, &mut Seed::root(1).stream());
    let mut rollouts = vec![Rollout::new(150, 1, 1)];
    let mut envs = [Echo(Seed::root(40).stream(), 0.0)];
    let policies = std::slice::from_mut(&mut policy);
    let mut collector = Collector::new(&envs, policies, config, &Seed::root(2), Path::widest());
    collector.begin(&mut envs, policies).unwrap();
    collector.collect(&mut envs, policies, &mut rollouts, &|| false).unwrap().unwrap();
    let learner = Learner::new(&policy, config, (0..150).collect(), Path::widest());
    (policy, learner, rollouts)
}

/// A different order for every epoch.
fn shuffled() -> impl FnMut(&mut [usize]) {
    let mut stream = Seed::root(3).stream();
    move |order| shuffle(order, &mut stream)
}

const LEARNING_RATE: f64 = 3e-4;

#[test]
fn every_epoch_has_an_order_of_its_own() {
    let after = |epochs| {
        let config = PpoConfig { epochs, ..PpoConfig::paper() };
        let (mut policy, mut learner, rollouts) = learner_and_rollout(&config);
        learner.learn(&mut policy, &rollouts, &config, LEARNING_RATE, &mut shuffled()).unwrap();
        learner.order
    };
    let (first, second) = (after(1), after(2));
    let identity: Vec<usize> = (0..150).collect();
    assert!(first != identity && second != identity && first != second);
    let mut sorted = second;
    sorted.sort_unstable();
    assert_eq!(sorted, identity);
}

#[test]
fn the_reported_divergence_is_that_of_the_last_epoch() {
    let run = |epochs| {
        let config = PpoConfig { epochs, batch_size: 150, ..PpoConfig::paper() };
        let learning_rate = 3e-3;
        let (mut policy, mut learner, rollouts) = learner_and_rollout(&config);
        let means = learner.learn(&mut policy, &rollouts, &config, learning_rate, &mut shuffled()).unwrap();
        (means.approx_kl, learner.loss.compute(&policy, &learner.batch, &config).approx_kl)
    };
    let (_, after_two) = run(2);
    let (reported, _) = run(3);
    assert!(after_two > 1e-5, "{after_two}");
    assert!((reported - after_two).abs() < 1e-3 * after_two, "{reported} against {after_two}");
}

#[test]
fn an_update_ends_before_the_step_whose_divergence_is_too_high() {
    let learning_rate = 1e-2;
    let run = |target_kl| {
        let config = PpoConfig { target_kl, ..PpoConfig::paper() };
        let (mut policy, mut learner, rollouts) = learner_and_rollout(&config);
        let means = learner.learn(&mut policy, &rollouts, &config, learning_rate, &mut shuffled()).unwrap();
        // The divergence of the updated policy on the current minibatch.
        let kl = learner.loss.compute(&policy, &learner.batch, &config).approx_kl;
        (means, policy, kl)
    };
    let (free, unstopped, _) = run(None);
    assert_eq!(free.gradient_steps, 30);
    let (generous, same, _) = run(Some(1e3));
    assert_eq!((generous, same), (free, unstopped));
    let (stopped, _, kl) = run(Some(0.01));
    assert!((1..30).contains(&stopped.gradient_steps), "{}", stopped.gradient_steps);
    // The step on the last minibatch was not taken: its divergence is still beyond the limit.
    assert!(kl > 1.5 * 0.01, "{kl}");
    // If every step exceeds the target, the first one still passes, since old and new policy are then the same.
    let (strict, ..) = run(Some(1e-9));
    assert_eq!(strict.gradient_steps, 1);
}
