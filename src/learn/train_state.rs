//! Saving and continuing a training.

use std::collections::BTreeMap;

use safetensors::SafeTensors;

use super::actor_critic::ActorCritic;
use super::archive::{Writer, read, read_vector};
use super::checkpoint::{read_each, read_moments, write_each, write_moments};
use super::checkpoint_error::CheckpointError;
use super::collector::observe;
use super::config::PpoConfig;
use super::curve::{read_curve, read_episodes, write_curve, write_episodes};
use super::env::Env;
use super::lane::Lane;
use super::log::FinishedEpisode;
use super::trainer::{Trainer, dimensions};
use base::seed::{Seed, Stream};

/// The entry of the header that holds the settings.
const SETTINGS: &str = "settings";

impl Trainer {
    /// Encodes everything that the next updates depend on, and the learning curve.
    ///
    /// This is each policy and its critic, Adam's moments, the positions in the random streams, the statistics, the
    /// current episodes, and what [`Env::save`] returns for each environment. The format is safetensors; policies can be
    /// read from it, too. Its header holds in plain text the progress of the training and its settings, in addition to
    /// `metadata`.
    pub fn state<E: Env>(&self, envs: &[E], metadata: &BTreeMap<String, String>) -> Vec<u8> {
        let mut writer = Writer::default();
        let numbers: Vec<usize> = (0..self.policies.len()).collect();
        write_each(&mut writer, &numbers, |number, writer| {
            self.policies[*number].write(writer);
            let adam = &self.learners[*number].adam;
            writer.vector("adam.first", &adam.first);
            writer.vector("adam.second", &adam.second);
            writer.vector("adam.powers", &adam.powers);
            writer.vector("minibatches", &position(&self.minibatches[*number]));
            if let Some(moments) = self.collector.return_moments.get(*number) {
                write_moments(writer, "ret_rms", moments);
            }
        });
        write_episodes(&mut writer, "recent", self.collector.recent.iter());
        for (i, lane) in self.collector.lanes.iter().enumerate() {
            writer.vector(&format!("env.{i}.noise"), &position(&lane.noise));
            writer.vector(&format!("env.{i}.obs"), lane.stack.as_slice());
            writer.vector(&format!("env.{i}.episode"), &[lane.running.reward, lane.discounted]);
            writer.vector(&format!("env.{i}.length"), &[lane.running.length, u64::from(lane.start)]);
        }
        for (i, env) in envs.iter().enumerate() {
            if let Some(state) = env.save() {
                writer.vector(&format!("env.{i}.state"), &state);
            }
        }
        write_curve(&mut writer, &self.learning_curve);
        let mut metadata = metadata.clone();
        metadata.insert("update".to_owned(), self.updates().to_string());
        metadata.insert("steps".to_owned(), self.steps.to_string());
        metadata.insert(SETTINGS.to_owned(), self.config.to_json());
        writer.finish(&metadata)
    }

    /// Continues from [`Trainer::state`] with the same number of environments, made as they were for [`Trainer::new`].
    ///
    /// With environments that save their state, the updates that follow are those of an uninterrupted training, bit for
    /// bit. An environment without a saved state starts a new episode. The settings must be those of the state, except for
    /// `steps`, so that a training can be prolonged, and `threads`, on which nothing depends.
    ///
    /// # Errors
    /// The bytes are not the state of a training with these settings and environments, or the first observation of a new
    /// episode is not finite.
    ///
    /// # Panics
    /// As [`Trainer::new`] does.
    pub fn from_state<E: Env>(bytes: &[u8], envs: &mut [E], config: &PpoConfig) -> Result<Self, CheckpointError> {
        let dimensions = dimensions(envs, config);
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(CheckpointError::Format)?;
        let settings = header.metadata().as_ref().and_then(|metadata| metadata.get(SETTINGS));
        let settings = settings.ok_or_else(|| CheckpointError::Missing { name: SETTINGS.to_owned() })?;
        if let Some(name) = config.difference(settings) {
            return Err(CheckpointError::Settings { name });
        }
        let tensors = &SafeTensors::deserialize(bytes).map_err(CheckpointError::Format)?;
        let policies = read_each(tensors, ActorCritic::read)?;
        if policies.len() != dimensions.len() {
            return Err(CheckpointError::Policies { found: policies.len(), expected: dimensions.len() });
        }
        for (policy, (states, actions)) in policies.iter().zip(dimensions) {
            let misshapen = |_| {
                let widths = policy.actor().layers().iter().map(|layer| layer.outputs);
                let found = [policy.obs_dim()].into_iter().chain(widths).collect();
                CheckpointError::Shape { name: "mlp_extractor".to_owned(), found }
            };
            config.accepts(policy, states, actions).map_err(misshapen)?;
        }

        // No stream of this seed is used: every stream continues from its saved position.
        let mut this = Self::assemble(envs, policies, config, &Seed::root(0));
        let own = read_each(tensors, |tensors| {
            let first: Vec<f32> = read::<f32>(tensors, "adam.first")?.values;
            let second: Vec<f32> = read_vector(tensors, "adam.second", first.len())?;
            let powers: Vec<f64> = read_vector(tensors, "adam.powers", 2)?;
            Ok((first, second, powers, read_stream(tensors, "minibatches")?, read_moments(tensors, "ret_rms", 1)?))
        })?;
        this.learning_curve = read_curve(tensors)?;
        this.steps = this.updates() * (config.steps_per_update * envs.len()) as u64;
        if this.learning_curve.last().is_some_and(|log| log.steps != this.steps) {
            return Err(CheckpointError::Env { env: envs.len() });
        }
        this.collector.recent.extend(read_episodes(tensors, "recent")?);
        this.collector.return_moments.clear();
        for (number, (first, second, powers, minibatches, moments)) in own.into_iter().enumerate() {
            let adam = &mut this.learners[number].adam;
            if first.len() != adam.first.len() {
                return Err(CheckpointError::Shape { name: "adam.first".to_owned(), found: vec![first.len()] });
            }
            (adam.first, adam.second) = (first, second);
            adam.powers.copy_from_slice(&powers);
            this.minibatches[number] = minibatches;
            if config.normalize_rewards {
                let missing = || CheckpointError::Missing { name: "ret_rms.mean".to_owned() };
                this.collector.return_moments.push(moments.ok_or_else(missing)?);
            }
        }
        let others = tensors.tensor(&format!("env.{}.noise", this.collector.lanes.len()));
        if others.is_ok() {
            return Err(CheckpointError::Env { env: envs.len() });
        }
        if this.restore_lanes(tensors, envs)? {
            observe(&mut this.policies, &this.collector.lanes);
        }
        Ok(this)
    }

    /// Restores the environments and their lanes; returns whether one began a new episode.
    fn restore_lanes<E: Env>(&mut self, tensors: &SafeTensors<'_>, envs: &mut [E]) -> Result<bool, CheckpointError> {
        let mut anew = false;
        let agents = self.collector.agents;
        for (place, (env, lanes)) in envs.iter_mut().zip(self.collector.lanes.chunks_mut(agents)).enumerate() {
            for (i, lane) in (place * agents..).zip(&mut *lanes) {
                lane.noise = read_stream(tensors, &format!("env.{i}.noise"))?;
            }
            let name = format!("env.{place}.state");
            if tensors.tensor(&name).is_err() {
                let name = format!("env.{}.obs", place * agents);
                Lane::begin(lanes, env).map_err(|_| CheckpointError::NonFinite { name })?;
                anew = true;
                continue;
            }
            if !env.load(&read::<u8>(tensors, &name)?.values) {
                return Err(CheckpointError::Env { env: place });
            }
            for (i, lane) in (place * agents..).zip(lanes) {
                lane.potential = env.potential();
                let seen = lane.stack.as_slice().len();
                lane.stack.restore(&read_vector(tensors, &format!("env.{i}.obs"), seen)?);
                let episode: Vec<f64> = read_vector(tensors, &format!("env.{i}.episode"), 2)?;
                let length: Vec<u64> = read_vector(tensors, &format!("env.{i}.length"), 2)?;
                lane.running = FinishedEpisode { reward: episode[0], length: length[0], ..FinishedEpisode::default() };
                lane.discounted = episode[1];
                lane.start = length[1] != 0;
            }
        }
        Ok(anew)
    }
}

/// Returns a stream's seed and its position in 32-bit words, as four words and two.
fn position(stream: &Stream) -> [u64; 6] {
    let seed = stream.seed();
    let (words, _) = seed.as_chunks::<8>();
    let at = stream.word();
    let mut position = [0, 0, 0, 0, at as u64, (at >> 64) as u64];
    for (slot, word) in position.iter_mut().zip(words) {
        *slot = u64::from_le_bytes(*word);
    }
    position
}

fn read_stream(tensors: &SafeTensors<'_>, name: &str) -> Result<Stream, CheckpointError> {
    let position: Vec<u64> = read_vector(tensors, name, 6)?;
    let mut seed = [0; 32];
    for (bytes, word) in seed.chunks_exact_mut(8).zip(&position) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    Ok(Stream::at(seed, u128::from(position[4]) | u128::from(position[5]) << 64))
}
