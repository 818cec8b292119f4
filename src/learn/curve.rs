//! The learning curve in a file.

use safetensors::SafeTensors;

use super::archive::{Number, Writer, read, read_vector};
use super::checkpoint_error::CheckpointError;
use super::log::{FinishedEpisode, UpdateLog};

/// Adds a learning curve to a file, one vector a quantity.
pub(super) fn write_curve(writer: &mut Writer, curve: &[UpdateLog]) {
    let mut whole = |name: &str, value: fn(&UpdateLog) -> u64| add(writer, name, curve, value);
    whole("update", |log| log.update);
    whole("steps", |log| log.steps);
    whole("episodes", |log| log.finished.len() as u64);
    whole("gradient_steps", |log| log.gradient_steps);
    let mut number = |name: &str, value: fn(&UpdateLog) -> f64| add(writer, name, curve, value);
    number("approx_kl", |log| log.approx_kl);
    number("clip_fraction", |log| log.clip_fraction);
    number("entropy", |log| log.entropy);
    number("policy_loss", |log| log.policy_loss);
    number("value_loss", |log| log.value_loss);
    number("grad_norm", |log| log.grad_norm);
    number("learning_rate", |log| log.learning_rate);
    number("std", |log| log.std);
    let mut maybe = |name: &str, value: fn(&UpdateLog) -> Option<f64>| {
        add(writer, name, curve, |log| value(log).unwrap_or(0.0));
        add(writer, &known(name), curve, |log| u8::from(value(log).is_some()));
    };
    maybe("mean_reward", |log| log.mean_reward);
    maybe("mean_length", |log| log.mean_length);
    maybe("success_rate", |log| log.success_rate);
    maybe("fault_rate", |log| log.fault_rate);
    maybe("explained_variance", |log| log.explained_variance);
    let finished: Vec<FinishedEpisode> = curve.iter().flat_map(|log| &log.finished).copied().collect();
    write_episodes(writer, "curve.finished", finished.iter());
}

/// Adds episodes to a file under names that begin like this, one vector a quantity.
pub(super) fn write_episodes<'a>(
    writer: &mut Writer,
    name: &str,
    episodes: impl ExactSizeIterator<Item = &'a FinishedEpisode> + Clone,
) {
    let (count, numbers) = (episodes.len(), episodes.map(FinishedEpisode::numbers));
    writer.add(&format!("{name}.reward"), &[count], numbers.clone().map(|numbers| numbers.0));
    writer.add(&format!("{name}.length"), &[count], numbers.clone().map(|numbers| numbers.1));
    writer.add(&format!("{name}.success"), &[count], numbers.clone().map(|numbers| numbers.2));
    writer.add(&format!("{name}.fault"), &[count], numbers.map(|numbers| numbers.3));
}

/// Reads what [`write_episodes`] wrote.
pub(super) fn read_episodes(tensors: &SafeTensors<'_>, name: &str) -> Result<Vec<FinishedEpisode>, CheckpointError> {
    let rewards = read::<f64>(tensors, &format!("{name}.reward"))?.values;
    let count = rewards.len();
    let lengths: Vec<u64> = read_vector(tensors, &format!("{name}.length"), count)?;
    let successes: Vec<u8> = read_vector(tensors, &format!("{name}.success"), count)?;
    let faults: Vec<u8> = read_vector(tensors, &format!("{name}.fault"), count)?;
    let numbers = rewards.into_iter().zip(lengths).zip(successes).zip(faults);
    Ok(numbers
        .map(|(((reward, length), success), fault)| FinishedEpisode::of((reward, length, success, fault)))
        .collect())
}

fn add<N: Number>(writer: &mut Writer, name: &str, curve: &[UpdateLog], value: impl Fn(&UpdateLog) -> N) {
    writer.add(&format!("curve.{name}"), &[curve.len()], curve.iter().map(value));
}

/// The name of the vector that marks which numbers of another vector exist.
fn known(name: &str) -> String {
    format!("{name}.known")
}

/// Reads a learning curve.
pub(super) fn read_curve(tensors: &SafeTensors<'_>) -> Result<Vec<UpdateLog>, CheckpointError> {
    let update: Vec<u64> = read(tensors, "curve.update")?.values;
    let updates = update.len();
    let whole = |name: &str| read_vector::<u64>(tensors, &format!("curve.{name}"), updates);
    let number = |name: &str| read_vector::<f64>(tensors, &format!("curve.{name}"), updates);
    let maybe = |name: &str| -> Result<Vec<Option<f64>>, CheckpointError> {
        let known: Vec<u8> = read_vector(tensors, &format!("curve.{}", known(name)), updates)?;
        Ok(number(name)?.into_iter().zip(known).map(|(value, known)| (known != 0).then_some(value)).collect())
    };
    let (steps, episodes, gradient_steps) = (whole("steps")?, whole("episodes")?, whole("gradient_steps")?);
    let (approx_kl, clip_fraction, entropy) = (number("approx_kl")?, number("clip_fraction")?, number("entropy")?);
    let (policy_loss, value_loss, grad_norm) = (number("policy_loss")?, number("value_loss")?, number("grad_norm")?);
    let (learning_rate, std) = (number("learning_rate")?, number("std")?);
    let (mean_reward, mean_length) = (maybe("mean_reward")?, maybe("mean_length")?);
    let (success_rate, fault_rate) = (maybe("success_rate")?, maybe("fault_rate")?);
    let explained_variance = maybe("explained_variance")?;
    let mut ended = read_episodes(tensors, "curve.finished")?.into_iter();

    let curve: Vec<UpdateLog> = (0..updates)
        .map(|i| {
            let finished: Vec<FinishedEpisode> =
                ended.by_ref().take(usize::try_from(episodes[i]).unwrap_or(usize::MAX)).collect();
            UpdateLog {
                update: update[i],
                steps: steps[i],
                episodes: finished.len(),
                finished,
                mean_reward: mean_reward[i],
                mean_length: mean_length[i],
                success_rate: success_rate[i],
                fault_rate: fault_rate[i],
                approx_kl: approx_kl[i],
                clip_fraction: clip_fraction[i],
                explained_variance: explained_variance[i],
                entropy: entropy[i],
                policy_loss: policy_loss[i],
                value_loss: value_loss[i],
                grad_norm: grad_norm[i],
                gradient_steps: gradient_steps[i],
                learning_rate: learning_rate[i],
                std: std[i],
            }
        })
        .collect();
    let all_there = curve.iter().zip(&episodes).all(|(log, episodes)| log.finished.len() as u64 == *episodes);
    if ended.next().is_some() || !all_there {
        return Err(CheckpointError::Shape { name: "curve.episodes".to_owned(), found: vec![updates] });
    }
    if curve.iter().zip(1..).any(|(log, number)| log.update != number) {
        return Err(CheckpointError::Shape { name: "curve.update".to_owned(), found: vec![updates] });
    }
    Ok(curve)
}
