//! Proximal policy optimisation, from the first update to the last.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use safetensors::SafeTensors;

use super::actor_critic::ActorCritic;
use super::archive::Writer;
use super::checkpoint::{CheckpointError, read_each, write_each};
use super::config::PpoConfig;
use super::curve::{read_curve, write_curve};
use super::env::Env;
use super::log::UpdateLog;
use super::train_error::TrainError;
use super::trainer::Trainer;
use base::seed::Seed;

/// The result of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The policies and their critics after the last update: one, or one for each role.
    pub policies: Vec<ActorCritic>,
    /// The reports of all updates, in order.
    pub learning_curve: Vec<UpdateLog>,
}

impl Trained {
    /// Encodes all of it in the safetensors format: the first policy as [`ActorCritic::to_safetensors`] does, the others as files within it, and the
    /// learning curve.
    pub fn to_safetensors(&self) -> Vec<u8> {
        let mut writer = Writer::default();
        write_each(&mut writer, &self.policies, ActorCritic::write);
        write_curve(&mut writer, &self.learning_curve);
        writer.finish(&BTreeMap::new())
    }

    /// Decodes what [`Trained::to_safetensors`] gave, bit for bit.
    ///
    /// # Errors
    /// The bytes are not such an encoding; the error names the reason.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, CheckpointError> {
        let tensors = SafeTensors::deserialize(bytes).map_err(CheckpointError::Format)?;
        Ok(Self { policies: read_each(&tensors, ActorCritic::read)?, learning_curve: read_curve(&tensors)? })
    }
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
