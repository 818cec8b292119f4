use std::collections::BTreeMap;

use safetensors::SafeTensors;

use super::actor_critic::ActorCritic;
use super::archive::Writer;
use super::checkpoint::{read_each, write_each};
use super::checkpoint_error::CheckpointError;
use super::curve::{read_curve, write_curve};
use super::log::UpdateLog;

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
