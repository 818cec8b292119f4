//! Training step by step, with interruptions.

use std::ops::ControlFlow;

use super::actor_critic::ActorCritic;
use super::arithmetic::Path;
use super::collector::{Collector, agents};
use super::config::PpoConfig;
use super::env::{Agent, Env};
use super::learner::{Learner, UpdateMeans};
use super::log::{FinishedEpisode, UpdateLog};
use super::minibatch::shuffle;
use super::moments::RunningMoments;
use super::rollout::{Rollout, explained_variance};
use super::train_error::TrainError;
use super::trained::Trained;
use base::seed::{Seed, Stream};

/// A training between two updates.
///
/// The caller owns the environments and passes the same ones every time.
///
/// # Example
/// ```
/// use std::collections::BTreeMap;
///
/// use learn::{Env, PpoConfig, Trainer};
/// use base::seed::Seed;
///
/// fn in_two_parts<E: Env + Send>(envs: &mut [E], config: &PpoConfig) -> Result<Trainer, Box<dyn std::error::Error>> {
///     let mut trainer = Trainer::new(envs, config, &Seed::root(7))?;
///     trainer.update(envs)?;
///     let bytes = trainer.state(envs, &BTreeMap::new());
///     let mut trainer = Trainer::from_state(&bytes, envs, config)?;
///     trainer.update(envs)?;
///     Ok(trainer)
/// }
/// ```
#[derive(Debug, Clone)]
pub struct Trainer {
    pub(super) config: PpoConfig,
    pub(super) policies: Vec<ActorCritic>,
    /// That of each policy.
    pub(super) learners: Vec<Learner>,
    pub(super) collector: Collector,
    /// Draws the order of the samples of each policy.
    pub(super) minibatches: Vec<Stream>,
    pub(super) steps: u64,
    /// One report for each update up to now.
    pub(super) learning_curve: Vec<UpdateLog>,
    rollouts: Vec<Rollout>,
}

impl Trainer {
    /// Draws the first weights, or takes those of the settings, and starts an episode in every environment.
    ///
    /// First weights and the order of minibatches of every policy, and the action noise of every agent have streams of their own.
    ///
    /// # Errors
    /// [`TrainError::NonFinite`] when a first observation is not finite.
    ///
    /// # Panics
    /// When there is no environment, when environments differ in their dimensions, or when `steps_per_update`,
    /// `batch_size`, `epochs`, `frame_stack` or a width in `config` is zero, or when its first networks are for other dimensions.
    pub fn new<E: Env>(envs: &mut [E], config: &PpoConfig, seed: &Seed) -> Result<Self, TrainError> {
        Self::with_networks(envs, first_networks(&agents(envs), config, seed), config, seed)
    }

    /// As [`Trainer::new`], but with these first networks, which are not part of the settings.
    ///
    /// # Errors
    /// As [`Trainer::new`].
    ///
    /// # Panics
    /// As [`Trainer::new`].
    pub fn with_networks<E: Env>(
        envs: &mut [E],
        policies: Vec<ActorCritic>,
        config: &PpoConfig,
        seed: &Seed,
    ) -> Result<Self, TrainError> {
        let found = policies.iter().map(|policy| (policy.obs_dim(), policy.action_dim()));
        assert!(found.eq(dimensions(envs, config)), "the first networks fit the environments");
        let mut this = Self::assemble(envs, policies, config, seed);
        let begun = this.collector.begin(envs, &mut this.policies);
        begun.map_err(|quantity| TrainError::NonFinite { update: 1, quantity })?;
        Ok(this)
    }

    /// Assembles a trainer that precedes the first episodes.
    pub(super) fn assemble<E: Env>(envs: &[E], policies: Vec<ActorCritic>, config: &PpoConfig, seed: &Seed) -> Self {
        let (path, steps) = (Path::of(config.portable_bits), config.steps_per_update);
        let collector = Collector::new(envs, &policies, config, &seed.child("action noise"), path);
        let rollout = |policy: &ActorCritic| Rollout::new(steps, policy.obs_dim(), policy.action_dim());
        let learner = |(number, policy)| {
            let own = (0..).zip(&collector.lanes).filter(|(_, lane)| lane.policy == number);
            Learner::new(policy, config, own.flat_map(|(lane, _)| lane * steps..(lane + 1) * steps).collect(), path)
        };
        let minibatches = (0..policies.len()).map(|policy| of_policy(&seed.child("minibatches"), policy).stream());
        Self {
            learners: policies.iter().enumerate().map(learner).collect(),
            minibatches: minibatches.collect(),
            config: config.clone(),
            steps: 0,
            learning_curve: Vec::new(),
            rollouts: collector.lanes.iter().map(|lane| rollout(&policies[lane.policy])).collect(),
            collector,
            policies,
        }
    }

    /// Collects a rollout and learns from it.
    ///
    /// The environments run in parallel on the threads of the current rayon pool, with the same bits on any number of
    /// them.
    ///
    /// # Errors
    /// [`TrainError::NonFinite`] at the first number that is not finite; the trainer is of no use after that.
    pub fn update<E: Env + Send>(&mut self, envs: &mut [E]) -> Result<&UpdateLog, TrainError> {
        self.update_unless(envs, &|| false)
    }

    /// As [`Trainer::update`], but gives up in the middle of the rollout when `stop` is true, which is asked at every decision.
    ///
    /// # Errors
    /// As [`Trainer::update`]; [`TrainError::Stopped`] when it gave up. The trainer is of no use after that.
    pub fn update_unless<E: Env + Send>(
        &mut self,
        envs: &mut [E],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<&UpdateLog, TrainError> {
        self.collect(envs, stop)?.learn()
    }

    /// Does the first half of [`Trainer::update_unless`]: collects a rollout with the present policies.
    ///
    /// # Errors
    /// As [`Trainer::update_unless`].
    pub fn collect<E: Env + Send>(
        &mut self,
        envs: &mut [E],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Experience<'_>, TrainError> {
        assert!(envs.len() * self.collector.agents == self.rollouts.len(), "a training keeps its environments");
        let update = self.updates() + 1;
        let finished = self.collector.collect(envs, &mut self.policies, &mut self.rollouts, stop);
        match finished {
            Ok(Some(finished)) => Ok(Experience { trainer: self, finished }),
            Ok(None) => Err(TrainError::Stopped { update: update - 1 }),
            Err(quantity) => Err(TrainError::NonFinite { update, quantity }),
        }
    }

    /// Returns whether the number of steps in the settings has been reached.
    pub fn is_done(&self) -> bool {
        self.steps >= self.config.steps
    }

    /// Returns the number of updates up to now.
    pub fn updates(&self) -> u64 {
        self.learning_curve.len() as u64
    }

    /// Returns the number of environment steps up to now, over all environments.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the present policies and their critics, in the order of their numbers.
    pub fn policies(&self) -> &[ActorCritic] {
        &self.policies
    }

    /// Returns the reports of all updates up to now, in order, including those before an interruption.
    pub fn learning_curve(&self) -> &[UpdateLog] {
        &self.learning_curve
    }

    /// Ends the training.
    pub fn finish(self) -> Trained {
        Trained { policies: self.policies, learning_curve: self.learning_curve }
    }
}

/// The experience of a rollout from which the trainer has yet to learn. Dropping it discards the experience.
#[derive(Debug)]
pub struct Experience<'a> {
    trainer: &'a mut Trainer,
    finished: Vec<FinishedEpisode>,
}

impl<'a> Experience<'a> {
    /// Does the second half of [`Trainer::update`]: takes the gradient steps.
    ///
    /// # Errors
    /// As [`Trainer::update`].
    pub fn learn(self) -> Result<&'a UpdateLog, TrainError> {
        let Self { trainer, finished } = self;
        let update = trainer.updates() + 1;
        let environments = trainer.rollouts.len() / trainer.collector.agents;
        trainer.steps += (trainer.config.steps_per_update * environments) as u64;
        let config = &trainer.config;
        let learning_rate = config.learning_rate_schedule.at(config.learning_rate, trainer.steps, config.steps);
        let all = trainer.policies.iter_mut().zip(&mut trainer.learners).zip(&mut trainer.minibatches);
        let learn = |((policy, learner), minibatches): ((_, &mut Learner), &mut Stream)| {
            let reorder = &mut |order: &mut [usize]| shuffle(order, minibatches);
            learner.learn(policy, &trainer.rollouts, config, learning_rate, reorder)
        };
        let updates = all.map(learn).collect::<Result<Vec<_>, _>>();
        let updates = updates.map_err(|quantity| TrainError::NonFinite { update, quantity })?;
        let mean = |of: fn(&UpdateMeans) -> f64| updates.iter().map(of).sum::<f64>() / updates.len() as f64;
        let recent = trainer.collector.recent_means();
        let log = UpdateLog {
            update,
            steps: trainer.steps,
            episodes: finished.len(),
            finished,
            mean_reward: recent.map(|(reward, ..)| reward),
            mean_length: recent.map(|(_, length, ..)| length),
            success_rate: recent.map(|(_, _, rate, _)| rate),
            fault_rate: recent.and_then(|(.., rate)| rate),
            approx_kl: mean(|one| one.approx_kl),
            clip_fraction: mean(|one| one.clip_fraction),
            explained_variance: explained_variance(&trainer.rollouts),
            entropy: mean(|one| one.entropy),
            policy_loss: mean(|one| one.policy),
            value_loss: mean(|one| one.value),
            grad_norm: mean(|one| one.grad_norm),
            gradient_steps: updates.iter().map(|one| one.gradient_steps).sum(),
            learning_rate,
            std: trainer.policies.iter().map(ActorCritic::mean_std).sum::<f64>() / updates.len() as f64,
        };
        Ok(trainer.learning_curve.push_mut(log))
    }
}

/// The networks of each policy of these agents with which a training begins: the given ones, or drawn ones.
pub fn first_networks(agents: &[Agent], config: &PpoConfig, seed: &Seed) -> Vec<ActorCritic> {
    let drawn = |(number, (obs_dim, action_dim))| {
        let stream = &mut of_policy(&seed.child("init"), number).stream();
        let mut policy = ActorCritic::new(obs_dim, action_dim, &config.hidden, config.initial_log_std, stream);
        *policy.observation_moments_mut() = config.normalize_observations.then(|| RunningMoments::new(obs_dim));
        policy
    };
    let given = config.from.as_ref().and_then(|from| from.networks.as_deref());
    let all = sizes(agents, config.frame_stack).into_iter().enumerate();
    all.map(|each| given.cloned().unwrap_or_else(|| drawn(each))).collect()
}

/// The seed of a policy: that of the first is the seed of a training of one.
fn of_policy(seed: &Seed, policy: usize) -> Seed {
    if policy == 0 { *seed } else { seed.index(policy as u64) }
}

/// The components of stacked observations and of actions of each policy.
fn sizes(agents: &[Agent], frames: usize) -> Vec<(usize, usize)> {
    let first = (0..).map_while(|policy| agents.iter().find(|agent| agent.policy == policy));
    first.map(|agent| (agent.obs_dim * frames, agent.action_bounds.len())).collect()
}

/// Returns the sizes of the inputs and outputs of each policy's networks: the components of stacked observations and of actions.
pub(super) fn dimensions<E: Env>(envs: &[E], config: &PpoConfig) -> Vec<(usize, usize)> {
    assert!(!envs.is_empty(), "training needs an environment");
    assert!(
        config.steps_per_update > 0 && config.batch_size > 0 && config.epochs > 0 && config.frame_stack > 0,
        "rollouts, minibatches, epochs and stacks must not be empty"
    );
    let numbers = |agent: Agent| (agent.policy, agent.obs_dim, agent.action_bounds.len());
    let first = || envs[0].agents().into_iter().map(numbers);
    assert!(
        envs.iter().all(|env| env.agents().into_iter().map(numbers).eq(first())),
        "environments must agree in their dimensions"
    );
    sizes(&envs[0].agents(), config.frame_stack)
}

/// Trains each policy and its critic by PPO.
///
/// Rollouts and updates alternate until `config.steps` steps have been taken. The last rollout is completed, so the
/// number of steps may be a little higher. `observer` gets the report of every update and may stop training.
///
/// The result depends only on the environments, `config` and `seed`; without `config.portable_bits` also on whether the
/// processor has AVX2 and FMA. [`Trainer`] takes the updates one by one.
///
/// # Errors
/// [`TrainError::NonFinite`] at the first number that is not finite, [`TrainError::Stopped`] when the observer stops it.
///
/// # Panics
/// When there is no environment, when environments differ in their dimensions, or when `steps_per_update`, `batch_size`,
/// `epochs`, `frame_stack` or a width in `config` is zero.
///
/// # Source
/// `PPO` of stable-baselines3; Schulman et al. (2017).
pub fn train<E: Env + Send>(
    envs: &mut [E],
    config: &PpoConfig,
    seed: &Seed,
    observer: &mut dyn FnMut(&UpdateLog) -> ControlFlow<()>,
) -> Result<Trained, TrainError> {
    let mut trainer = Trainer::new(envs, config, seed)?;
    while !trainer.is_done() {
        if observer(trainer.update(envs)?).is_break() {
            return Err(TrainError::Stopped { update: trainer.updates() });
        }
    }
    Ok(trainer.finish())
}
