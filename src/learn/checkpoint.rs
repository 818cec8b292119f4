//! Saving and loading a learned policy.

use std::collections::BTreeMap;

use safetensors::SafeTensors;

use super::actor_critic::ActorCritic;
use super::archive::{Writer, read, read_vector};
use super::checkpoint_error::CheckpointError;
use super::mlp::Mlp;
use super::moments::RunningMoments;

/// The names of a network's layers: `trunk.0`, `trunk.2`, … with the activations counted in between, then `head`.
fn layer_names(trunk: &str, head: &str, layers: usize) -> Vec<String> {
    let hidden = (0..layers - 1).map(|l| format!("mlp_extractor.{trunk}.{}", 2 * l));
    hidden.chain([head.to_owned()]).collect()
}

impl ActorCritic {
    /// Encodes the policy in the safetensors format, with the tensor names of stable-baselines3's state dictionary.
    ///
    /// Weights are outputs × inputs, row by row, in `F32`. The moments that observations are normalised with, if any, are
    /// `obs_rms.mean`, `obs_rms.var` and `obs_rms.count` in `F64`. `metadata` goes into the header. The same policy and
    /// metadata give the same bytes.
    pub fn to_safetensors(&self, metadata: &BTreeMap<String, String>) -> Vec<u8> {
        let mut writer = Writer::default();
        self.write(&mut writer);
        writer.finish(metadata)
    }

    /// Adds the policy's arrays to a file.
    pub(super) fn write(&self, writer: &mut Writer) {
        writer.vector("log_std", self.log_std());
        for (mlp, trunk, head, range) in [
            (self.actor(), "policy_net", "action_net", self.actor_range()),
            (self.critic(), "value_net", "value_net", self.critic_range()),
        ] {
            let parameters = &self.parameters()[range];
            for (layer, name) in mlp.layers().iter().zip(layer_names(trunk, head, mlp.layers().len())) {
                let weight = &parameters[layer.weight.clone()];
                let rows = (0..layer.outputs).flat_map(|row| weight.iter().skip(row).step_by(layer.outputs));
                writer.add(&format!("{name}.weight"), &[layer.outputs, layer.inputs], rows.copied());
                writer.vector(&format!("{name}.bias"), &parameters[layer.bias.clone()]);
            }
        }
        if let Some(moments) = self.observation_moments() {
            write_moments(writer, "obs_rms", moments);
        }
    }

    /// Decodes a policy and the metadata of its header.
    ///
    /// The sizes of the networks follow from the shapes of the tensors. Tensors of other names are ignored.
    ///
    /// # Errors
    /// The bytes are not a policy with finite parameters; the error names the reason.
    pub fn from_safetensors(bytes: &[u8]) -> Result<(Self, BTreeMap<String, String>), CheckpointError> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(CheckpointError::Format)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(CheckpointError::Format)?;
        let metadata = header.metadata().iter().flatten().map(|(key, value)| (key.clone(), value.clone())).collect();
        Ok((Self::read(&tensors)?, metadata))
    }

    /// Reads the policy's arrays.
    pub(super) fn read(tensors: &SafeTensors<'_>) -> Result<Self, CheckpointError> {
        let actor = read_network(tensors, "policy_net", "action_net")?;
        let critic = read_network(tensors, "value_net", "value_net")?;
        let log_std = read_vector(tensors, "log_std", actor.mlp.outputs())?;
        if critic.mlp.inputs() != actor.mlp.inputs() || critic.mlp.outputs() != 1 {
            let name = if critic.mlp.outputs() == 1 { &critic.names[0] } else { "value_net" };
            return Err(read::<f32>(tensors, &format!("{name}.weight"))?.misshapen());
        }
        let moments = read_moments(tensors, "obs_rms", actor.mlp.inputs())?;
        let mut this = Self::zeros(actor.mlp, critic.mlp);
        let parameters = [actor.parameters, critic.parameters, log_std].concat();
        this.parameters_mut().copy_from_slice(&parameters);
        *this.observation_moments_mut() = moments;
        Ok(this)
    }
}

/// Adds what there is of each policy to a file: that of the first one, and of each other one as a file within it.
pub(super) fn write_each<T>(writer: &mut Writer, each: &[T], write: impl Fn(&T, &mut Writer)) {
    for (number, one) in each.iter().enumerate() {
        match number {
            0 => write(one, writer),
            _ => {
                let mut own = Writer::default();
                write(one, &mut own);
                writer.vector(&format!("policy.{number}"), &own.finish(&BTreeMap::new()));
            }
        }
    }
}

/// Reads what [`write_each`] wrote.
pub(super) fn read_each<T>(
    tensors: &SafeTensors<'_>,
    read_one: impl Fn(&SafeTensors<'_>) -> Result<T, CheckpointError>,
) -> Result<Vec<T>, CheckpointError> {
    let mut each = vec![read_one(tensors)?];
    while let Ok(file) = tensors.tensor(&format!("policy.{}", each.len())) {
        each.push(read_one(&SafeTensors::deserialize(file.data()).map_err(CheckpointError::Format)?)?);
    }
    Ok(each)
}

/// Adds running moments to a file.
pub(super) fn write_moments(writer: &mut Writer, name: &str, moments: &RunningMoments) {
    writer.vector(&format!("{name}.mean"), &moments.mean);
    writer.vector(&format!("{name}.var"), &moments.variance);
    writer.vector(&format!("{name}.count"), &[moments.count]);
}

/// Reads running moments, if the file has them.
pub(super) fn read_moments(
    tensors: &SafeTensors<'_>,
    name: &str,
    components: usize,
) -> Result<Option<RunningMoments>, CheckpointError> {
    if tensors.tensor(&format!("{name}.mean")).is_err() {
        return Ok(None);
    }
    let mean = read_vector(tensors, &format!("{name}.mean"), components)?;
    let variance = read_vector(tensors, &format!("{name}.var"), components)?;
    let count = read_vector(tensors, &format!("{name}.count"), 1)?[0];
    Ok(Some(RunningMoments { mean, variance, count }))
}

/// A network with its parameters in the order of [`Mlp`], and the names of its layers.
struct Network {
    mlp: Mlp,
    parameters: Vec<f32>,
    names: Vec<String>,
}

fn read_network(tensors: &SafeTensors<'_>, trunk: &str, head: &str) -> Result<Network, CheckpointError> {
    let hidden = (0..).take_while(|l| tensors.tensor(&format!("mlp_extractor.{trunk}.{}.weight", 2 * l)).is_ok());
    let names = layer_names(trunk, head, hidden.count() + 1);
    let mut widths = Vec::new();
    let mut parameters = Vec::new();
    for name in &names {
        let weight = read::<f32>(tensors, &format!("{name}.weight"))?;
        let &[outputs, inputs] = weight.shape.as_slice() else { return Err(weight.misshapen()) };
        if outputs == 0 || inputs == 0 || widths.last().is_some_and(|&width| width != inputs) {
            return Err(weight.misshapen());
        }
        let bias = read::<f32>(tensors, &format!("{name}.bias"))?;
        if bias.shape != [outputs] {
            return Err(bias.misshapen());
        }
        if widths.is_empty() {
            widths.push(inputs);
        }
        widths.push(outputs);
        parameters.extend((0..inputs).flat_map(|column| weight.values.iter().skip(column).step_by(inputs)));
        parameters.extend(bias.values);
    }
    Ok(Network { mlp: Mlp::new(&widths), parameters, names })
}
