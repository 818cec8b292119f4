//! Trainings of small tasks.

use base::seed::{Seed, Stream};
use learn::{ActorCritic, Env, PpoConfig, Quantity, Schedule, Step, TrainError, Trained, Trainer, UpdateLog, train};
use rand::Rng;
use std::ops::ControlFlow;

/// Rewards the action that equals the observation, a number in [−1, 1]; an episode is one decision.
struct Identity {
    stream: Stream,
    target: f64,
}

impl Identity {
    fn new(number: u64) -> Self {
        Self { stream: Seed::root(40).index(number).stream(), target: 0.0 }
    }
}

impl Env for Identity {
    fn obs_dim(&self) -> usize {
        1
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        vec![(-1.0, 1.0)]
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.target = self.stream.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
        obs[0] = self.target;
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        assert!((-1.0..=1.0).contains(&action[0]));
        obs[0] = self.target;
        Step { reward: -(action[0] - self.target) * (action[0] - self.target), terminated: true, truncated: false }
    }
}

/// The digest of a portable training after one update of the identity task.
const DIGEST: u64 = 0xdd78_c603_3e11_8fe2;

fn keep_going(_: &UpdateLog) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn config(total_steps: u64) -> PpoConfig {
    PpoConfig { steps: total_steps, ..PpoConfig::paper() }
}

/// The mean squared error of the deterministic policy.
fn error(policy: &ActorCritic) -> f64 {
    let (mut action, mut scratch) = ([0.0], policy.scratch(1));
    let mut squares = 0.0;
    for i in 0..=200 {
        let obs = f64::from(i) / 100.0 - 1.0;
        policy.act(&[obs], &mut action, &mut scratch);
        squares += (action[0].clamp(-1.0, 1.0) - obs) * (action[0].clamp(-1.0, 1.0) - obs);
    }
    squares / 201.0
}

#[test]
fn the_identity_is_learnt() {
    let config = config(60_000);
    let trained = train(&mut [Identity::new(0)], &config, &Seed::root(1), &mut keep_going).unwrap();
    let untrained = ActorCritic::new(1, 1, &config.hidden, 0.0, &mut Seed::root(1).child("init").stream());
    // A policy that always acts 0 has an error of 1/3.
    assert!(error(&untrained) > 0.3, "{}", error(&untrained));
    assert!(error(&trained.policies[0]) < 0.01, "{}", error(&trained.policies[0]));
    let (first, last) = (&trained.learning_curve[0], trained.learning_curve.last().unwrap());
    assert!(first.mean_reward.unwrap() < -0.4);
    assert!(last.mean_reward.unwrap() > 0.5 * first.mean_reward.unwrap());
    assert!(last.std < first.std);
}

#[test]
fn the_paper_takes_467_updates() {
    let config = PpoConfig { epochs: 1, hidden: vec![2], ..PpoConfig::paper() };
    let mut seen = 0;
    let mut count = |log: &UpdateLog| {
        seen += 1;
        assert_eq!((log.update, log.steps), (seen, 150 * seen));
        assert_eq!((log.episodes, log.finished.len(), log.mean_length), (150, 150, Some(1.0)));
        ControlFlow::Continue(())
    };
    let trained = train(&mut [Identity::new(0)], &config, &Seed::root(1), &mut count).unwrap();
    assert_eq!(trained.learning_curve.len(), 467);
    assert_eq!(trained.learning_curve[466].steps, 70_050);
    assert_eq!(seen, 467);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_does_not() {
    let run = |seed| {
        let mut envs = [Identity::new(0), Identity::new(1), Identity::new(2)];
        train(&mut envs, &config(2_000), &Seed::root(seed), &mut keep_going).unwrap()
    };
    let bits = |trained: &Trained| -> Vec<u32> {
        trained.policies[0].parameters().iter().map(|parameter| parameter.to_bits()).collect()
    };
    let (a, b, c) = (run(1), run(1), run(2));
    assert_eq!(bits(&a), bits(&b));
    assert_eq!(a.learning_curve, b.learning_curve);
    assert_ne!(bits(&a), bits(&c));
    assert_eq!(a.learning_curve.len(), 5);
    assert_eq!(a.learning_curve[4].steps, 5 * 450);

    let rewards: Vec<f64> =
        a.learning_curve.iter().flat_map(|log| &log.finished).map(|episode| episode.reward).collect();
    let recent = rewards[rewards.len() - 100..].iter().sum::<f64>() / 100.0;
    assert!((a.learning_curve[4].mean_reward.unwrap() - recent).abs() < 1e-12);
}

#[test]
fn the_first_update_starts_from_the_collected_policy() {
    // With one minibatch and one epoch every ratio is 1, up to the rounding of f32.
    let config = PpoConfig { epochs: 1, batch_size: 150, ..config(150) };
    let trained = train(&mut [Identity::new(0)], &config, &Seed::root(1), &mut keep_going).unwrap();
    let log = &trained.learning_curve[0];
    assert!(log.approx_kl.abs() < 1e-9, "{}", log.approx_kl);
    assert_eq!(log.clip_fraction, 0.0);
    assert!(log.policy_loss.abs() < 1e-5, "{}", log.policy_loss);
    assert!((log.entropy - 1.418_938_5).abs() < 1e-6);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let wide = PpoConfig { hidden: vec![128, 64], batch_size: 250, epochs: 2, ..config(1_500) };
    for (normalize, config) in [(false, config(1_500)), (true, config(1_500)), (true, wide)] {
        let config = PpoConfig { normalize_observations: normalize, normalize_rewards: normalize, ..config };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut envs = [0, 1, 2, 3, 4].map(Identity::new);
            pool.install(|| train(&mut envs, &config, &Seed::root(1), &mut keep_going).unwrap())
        };
        let one = run(1);
        assert_eq!(one, run(2));
        assert_eq!(one, run(7));
    }
}

#[test]
fn portable_bits_change_no_more_than_rounding() {
    let run = |portable_bits| {
        let config = PpoConfig { portable_bits, ..config(150) };
        train(&mut [Identity::new(0)], &config, &Seed::root(1), &mut keep_going).unwrap()
    };
    let (plain, widest) = (run(true), run(false));
    // The experience is the same bit for bit: only learning uses wide instructions.
    assert_eq!(plain.learning_curve[0].finished, widest.learning_curve[0].finished);
    for (a, b) in plain.policies[0].parameters().iter().zip(widest.policies[0].parameters()) {
        assert!((a - b).abs() < 1e-3, "{a} against {b}");
    }
    // The recorded bits of the plain path, for every processor.
    let digest = plain.policies[0]
        .parameters()
        .iter()
        .fold(0u64, |sum, x| sum.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(u64::from(x.to_bits())));
    assert_eq!(digest, DIGEST, "{digest:#x}");
}

#[test]
fn a_schedule_reaches_the_optimiser() {
    let linear = PpoConfig { learning_rate_schedule: Schedule::Linear, ..config(450) };
    let trained = train(&mut [Identity::new(0)], &linear, &Seed::root(1), &mut keep_going).unwrap();
    let rates: Vec<f64> = trained.learning_curve.iter().map(|log| log.learning_rate).collect();
    for (rate, expected) in rates.iter().zip([2e-4, 1e-4, 0.0]) {
        assert!((rate - expected).abs() < 1e-12);
    }
    // The last update has the rate zero and changes nothing.
    let shorter = PpoConfig { steps: 450, ..linear.clone() };
    let mut envs = [Identity::new(0)];
    let mut trainer = Trainer::new(&mut envs, &shorter, &Seed::root(1)).unwrap();
    trainer.update(&mut envs).unwrap();
    trainer.update(&mut envs).unwrap();
    let before = trainer.policies()[0].clone();
    trainer.update(&mut envs).unwrap();
    assert!(trainer.policies()[0] == before);
    let constant = train(&mut [Identity::new(0)], &config(450), &Seed::root(1), &mut keep_going).unwrap();
    assert!(constant.learning_curve.iter().all(|log| log.learning_rate == 3e-4));
}

#[test]
fn normalising_learns_what_badly_scaled_numbers_keep_from_learning() {
    // Observations a thousand times too large and off zero, rewards a thousand times too small.
    struct Scaled(Identity);
    impl Env for Scaled {
        fn obs_dim(&self) -> usize {
            1
        }
        fn action_bounds(&self) -> Vec<(f64, f64)> {
            self.0.action_bounds()
        }
        fn reset(&mut self, obs: &mut [f64]) {
            self.0.reset(obs);
            obs[0] = 5_000.0 + 1_000.0 * obs[0];
        }
        fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
            let step = self.0.step(action, obs);
            obs[0] = 5_000.0 + 1_000.0 * obs[0];
            Step { reward: step.reward * 1e-3, ..step }
        }
    }
    let error = |normalize| {
        let config = PpoConfig { normalize_observations: normalize, normalize_rewards: normalize, ..config(30_000) };
        let mut envs = [Scaled(Identity::new(0))];
        let policy = train(&mut envs, &config, &Seed::root(1), &mut keep_going).unwrap().policies.remove(0);
        let (mut action, mut scratch, mut squares) = ([0.0], policy.scratch(1), 0.0);
        for i in 0..=200 {
            let target = f64::from(i) / 100.0 - 1.0;
            policy.act(&[5_000.0 + 1_000.0 * target], &mut action, &mut scratch);
            squares += (action[0].clamp(-1.0, 1.0) - target).powi(2) / 201.0;
        }
        squares
    };
    assert!(error(true) < 0.03, "{}", error(true));
    assert!(error(false) > 0.2, "{}", error(false));
}

#[test]
fn stacked_observations_let_a_policy_remember() {
    // Only the first observation shows the target, and only the action of the second counts.
    struct Memory(Identity, bool);
    impl Env for Memory {
        fn obs_dim(&self) -> usize {
            1
        }
        fn action_bounds(&self) -> Vec<(f64, f64)> {
            self.0.action_bounds()
        }
        fn reset(&mut self, obs: &mut [f64]) {
            self.0.reset(obs);
            self.1 = false;
        }
        fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
            let step = self.0.step(action, obs);
            obs[0] = 0.0;
            let second = std::mem::replace(&mut self.1, true);
            Step { reward: if second { step.reward } else { 0.0 }, terminated: second, truncated: false }
        }
    }
    let mean_reward = |frame_stack| {
        let config = PpoConfig { frame_stack, ..config(45_000) };
        let trained = train(&mut [Memory(Identity::new(0), false)], &config, &Seed::root(1), &mut keep_going).unwrap();
        assert_eq!(trained.policies[0].obs_dim(), frame_stack);
        trained.learning_curve.last().unwrap().mean_reward.unwrap()
    };
    let (without, with) = (mean_reward(1), mean_reward(2));
    assert!(with > 0.6 * without, "{with} against {without}");
}

#[test]
fn the_observer_can_stop() {
    let mut stop = |log: &UpdateLog| if log.update == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let result = train(&mut [Identity::new(0)], &config(10_000), &Seed::root(1), &mut stop);
    assert_eq!(result, Err(TrainError::Stopped { update: 3 }));
}

/// Returns one observation or reward that is not finite.
struct Broken {
    steps: u64,
    at: u64,
    reward: f64,
    obs: f64,
}

impl Env for Broken {
    fn obs_dim(&self) -> usize {
        2
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        vec![(-1.0, 1.0)]
    }

    fn reset(&mut self, obs: &mut [f64]) {
        obs.fill(0.0);
    }

    fn step(&mut self, _: &[f64], obs: &mut [f64]) -> Step {
        self.steps += 1;
        let broken = self.steps == self.at;
        obs[1] = if broken { self.obs } else { 0.0 };
        Step { reward: if broken { self.reward } else { 0.0 }, terminated: false, truncated: false }
    }
}

#[test]
fn numbers_that_are_not_finite_are_reported() {
    for (reward, obs, quantity) in [
        (f64::NAN, 0.0, Quantity::Reward),
        (f64::INFINITY, 0.0, Quantity::Reward),
        (0.0, f64::NAN, Quantity::Observation),
        (0.0, 1e300, Quantity::Observation),
        (1e200, 0.0, Quantity::Loss),
        (1e30, 0.0, Quantity::Gradient),
    ] {
        let mut envs = [Broken { steps: 0, at: 301, reward, obs }];
        let result = train(&mut envs, &config(10_000), &Seed::root(1), &mut keep_going);
        assert_eq!(result, Err(TrainError::NonFinite { update: 3, quantity }), "{reward}, {obs}");
    }
    let config = PpoConfig { initial_log_std: 800.0, ..config(10_000) };
    let mut envs = [Broken { steps: 0, at: 0, reward: 0.0, obs: 0.0 }];
    let result = train(&mut envs, &config, &Seed::root(1), &mut keep_going);
    assert_eq!(result, Err(TrainError::NonFinite { update: 1, quantity: Quantity::Action }));
}
