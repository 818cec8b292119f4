use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::hard_start::is_hard;
use super::training_ground::TrainingGround;
use super::{HardStarts, StartBank, TrainError};
use crate::driving::{DriveRule, imitate};
use base::seed::Seed;
use episode::{Cast, Scenario};
use learn::{ActorCritic, CheckpointError, Env, PpoConfig, Trained, Trainer, UpdateLog};

/// A training of a pedestrian between two updates, with its environments.
///
/// It can be saved between two updates and continued on any number of threads. The result is the same as without interruption.
///
/// # Example
/// ```
/// use std::collections::BTreeMap;
/// use std::sync::Arc;
///
/// use episode::Scenario;
/// use search::TrainingRun;
/// use learn::{PpoConfig, Trained};
/// use base::seed::Seed;
///
/// fn in_two_parts(scenarios: &[Arc<Scenario>], config: &PpoConfig) -> Result<Trained, Box<dyn std::error::Error>> {
///     let mut run = TrainingRun::begin(scenarios, 8, config, &Seed::root(7))?;
///     run.update()?;
///     let state = run.state(&BTreeMap::new());
///     let mut run = TrainingRun::resume(&state, scenarios, None, 8, config, &Seed::root(7))?;
///     while !run.is_done() {
///         println!("{:?}", run.update()?.mean_reward);
///     }
///     Ok(run.finish())
/// }
/// ```
pub struct TrainingRun {
    envs: Vec<TrainingGround>,
    trainer: Trainer,
}

impl TrainingRun {
    /// Starts a training in a number of environments, each with its own stream of episodes. The episodes of several scenarios alternate.
    ///
    /// # Errors
    /// A first state that is not finite.
    ///
    /// # Panics
    /// When there is no scenario.
    pub fn begin(
        scenarios: &[Arc<Scenario>],
        environments: usize,
        config: &PpoConfig,
        seed: &Seed,
    ) -> Result<Self, TrainError> {
        let mut envs = environments_of(scenarios, None, environments, config, seed);
        Ok(Self { trainer: Trainer::new(&mut envs, config, &seed.child("ppo"))?, envs })
    }

    /// Starts a training of the car as a driver, as [`TrainingRun::begin`] does; it imitates its teacher first. `watch` gets the share of
    /// that work that is done, and answers whether to stop.
    ///
    /// # Errors
    /// As [`TrainingRun::begin`]; [`learn::TrainError::Stopped`] when it stopped.
    ///
    /// # Panics
    /// When there is no scenario.
    pub fn begin_driving(
        scenarios: &[Arc<Scenario>],
        rule: &Arc<DriveRule>,
        environments: usize,
        config: &PpoConfig,
        seed: &Seed,
        watch: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Self, TrainError> {
        let mut envs = environments_of(scenarios, Some(rule), environments, config, seed);
        let mut networks = learn::first_networks(&envs[0].agents(), config, &seed.child("ppo"));
        if !imitate(&mut envs, rule, &mut networks[0], config, &seed.child("imitation"), watch) {
            return Err(learn::TrainError::Stopped { update: 0 }.into());
        }
        let trainer = Trainer::with_networks(&mut envs, networks, config, &seed.child("ppo"))?;
        Ok(Self { trainer, envs })
    }

    /// Continues a training that was started with the same scenarios, rule of a driver (none: of a pedestrian), environments, settings and seed.
    ///
    /// `steps` and `threads` may differ.
    ///
    /// # Errors
    /// The bytes are not the state of such a training: they are damaged, a setting differs, or the running episodes lead to other states
    /// in these scenarios.
    ///
    /// # Panics
    /// When there is no scenario.
    pub fn resume(
        state: &[u8],
        scenarios: &[Arc<Scenario>],
        rule: Option<&Arc<DriveRule>>,
        environments: usize,
        config: &PpoConfig,
        seed: &Seed,
    ) -> Result<Self, CheckpointError> {
        let mut envs = environments_of(scenarios, rule, environments, config, seed);
        Ok(Self { trainer: Trainer::from_state(state, &mut envs, config)?, envs })
    }

    /// Collects a rollout and learns from it.
    ///
    /// # Errors
    /// The first number that is not finite, or a driver that failed in ten episodes in a row. The training cannot be used after that.
    pub fn update(&mut self) -> Result<&UpdateLog, TrainError> {
        self.update_unless(&|| false)
    }

    /// As [`TrainingRun::update`], but gives up in the middle of the rollout when `stop` is true, which is asked at every decision.
    ///
    /// # Errors
    /// As [`TrainingRun::update`]; [`learn::TrainError::Stopped`] when it gave up, with the number of the last whole update.
    pub fn update_unless(&mut self, stop: &(dyn Fn() -> bool + Sync)) -> Result<&UpdateLog, TrainError> {
        let update = self.trainer.updates();
        let log = self.trainer.update_unless(&mut self.envs, stop)?;
        if self.envs.iter().any(TrainingGround::is_stopped) {
            return Err(learn::TrainError::Stopped { update }.into());
        }
        match self.envs.iter().find_map(TrainingGround::hopeless) {
            Some(fault) => Err(TrainError::Driver { update: log.update, fault }),
            None => Ok(log),
        }
    }

    /// Returns whether the number of decisions that the settings ask for has been taken.
    pub fn is_done(&self) -> bool {
        self.trainer.is_done()
    }

    /// Returns the reports of all updates up to now, in order, including those before an interruption.
    pub fn learning_curve(&self) -> &[UpdateLog] {
        self.trainer.learning_curve()
    }

    /// The present networks of each policy.
    pub fn policies(&self) -> &[ActorCritic] {
        self.trainer.policies()
    }

    /// Encodes the training so that [`TrainingRun::resume`] can continue it; `metadata` goes into the header.
    ///
    /// The format is safetensors. The present networks can be read from it, too.
    pub fn state(&self, metadata: &BTreeMap<String, String>) -> Vec<u8> {
        self.trainer.state(&self.envs, metadata)
    }

    /// Ends the training.
    pub fn finish(self) -> Trained {
        self.trainer.finish()
    }

    /// Trains to the end, and shows the training to the observer after every update.
    ///
    /// # Errors
    /// As [`TrainingRun::update`]; or the break of the observer.
    pub fn carry_on(
        mut self,
        observer: &mut dyn FnMut(&TrainingRun) -> ControlFlow<()>,
    ) -> Result<Trained, TrainError> {
        while !self.is_done() {
            self.update()?;
            if observer(&self).is_break() {
                return Err(learn::TrainError::Stopped { update: self.trainer.updates() }.into());
            }
        }
        Ok(self.finish())
    }
}

/// The networks of each policy with which a training of such actors begins, before its first decision; `seed` is that of [`TrainingRun::begin`].
pub fn first_networks(cast: &Cast, config: &PpoConfig, seed: &Seed) -> Vec<ActorCritic> {
    learn::first_networks(&cast.agents(config.policies), config, &seed.child("ppo"))
}

impl std::fmt::Debug for TrainingRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TrainingRun").field("updates", &self.trainer.updates()).finish_non_exhaustive()
    }
}

fn environments_of(
    scenarios: &[Arc<Scenario>],
    rule: Option<&Arc<DriveRule>>,
    environments: usize,
    config: &PpoConfig,
    seed: &Seed,
) -> Vec<TrainingGround> {
    let (episodes, starts) = (seed.child("episodes"), seed.child("starts"));
    let hard = config.hard_starts.map(|share| HardStarts { share, is_hard });
    let bank = |(place, scenario)| StartBank::new(scenario, config.starts?, hard, starts.index(place)).map(Arc::new);
    let banks: Vec<_> = (0..).zip(scenarios).map(bank).collect();
    (0..environments)
        .map(|env| TrainingGround::new(scenarios, rule, &banks, config, env, &episodes.index(env as u64)))
        .collect()
}
