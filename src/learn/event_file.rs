//! The learning curve in TensorBoard's event files.
//!
//! A file is a sequence of records: length, checksum of the length, an `Event`, checksum of the event. The crates that write such files
//! were not taken: `tensorboard-rs` 0.5.9 needs `protobuf` 2 and `image`, `tboard` 0.1.1 a second `prost` and protoc, `tfrecord` 0.15.0
//! `image`. The messages need four fields.
//!
//! # Source
//! `event.proto` and `summary.proto` of TensorBoard; TensorFlow's `RecordWriter` and `crc32c::Mask` for the framing.

use prost::Message;

use super::log::UpdateLog;

/// The version of the format, the first event of a file.
const VERSION: &str = "brain.Event:2";
/// What TensorFlow adds to a rotated checksum, so that checksums of checksums differ.
const MASK: u32 = 0xa282_ead8;

#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, tag = "1")]
    wall_time: f64,
    #[prost(int64, tag = "2")]
    step: i64,
    #[prost(string, optional, tag = "3")]
    file_version: Option<String>,
    #[prost(message, optional, tag = "5")]
    summary: Option<Summary>,
}

#[derive(Clone, PartialEq, Message)]
struct Summary {
    #[prost(message, repeated, tag = "1")]
    values: Vec<Value>,
}

#[derive(Clone, PartialEq, Message)]
struct Value {
    #[prost(string, tag = "1")]
    tag: String,
    #[prost(float, optional, tag = "2")]
    simple_value: Option<f32>,
}

/// The start of an event file, written at this time (seconds since 1970).
pub fn event_file_start(wall_time: f64) -> Vec<u8> {
    record(&Event { wall_time, step: 0, file_version: Some(VERSION.into()), summary: None })
}

/// The scalars of an update as a record of an event file, written at this time (seconds since 1970). The step is the number of decisions.
///
/// Tags are those of stable-baselines3; `rollout/fault_rate` and `train/gradient_norm` are ours. Values that are absent are left out.
pub fn event_of_update(log: &UpdateLog, wall_time: f64) -> Vec<u8> {
    let scalars = [
        ("rollout/ep_rew_mean", log.mean_reward),
        ("rollout/ep_len_mean", log.mean_length),
        ("rollout/success_rate", log.success_rate),
        ("rollout/fault_rate", log.fault_rate),
        ("train/approx_kl", Some(log.approx_kl)),
        ("train/clip_fraction", Some(log.clip_fraction)),
        ("train/entropy_loss", Some(-log.entropy)),
        ("train/explained_variance", log.explained_variance),
        ("train/gradient_norm", Some(log.grad_norm)),
        ("train/learning_rate", Some(log.learning_rate)),
        ("train/policy_gradient_loss", Some(log.policy_loss)),
        ("train/std", Some(log.std)),
        ("train/value_loss", Some(log.value_loss)),
    ];
    let value = |(tag, value): (&str, Option<f64>)| Some(Value { tag: tag.into(), simple_value: Some(value? as f32) });
    let summary = Summary { values: scalars.into_iter().filter_map(value).collect() };
    record(&Event { wall_time, step: log.steps as i64, file_version: None, summary: Some(summary) })
}

fn record(event: &Event) -> Vec<u8> {
    let bytes = event.encode_to_vec();
    let length = (bytes.len() as u64).to_le_bytes();
    [&length[..], &checksum(&length), &bytes, &checksum(&bytes)].concat()
}

fn checksum(bytes: &[u8]) -> [u8; 4] {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(MASK).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The events of a file, whose checksums are examined.
    fn events(mut file: &[u8]) -> Vec<Event> {
        let mut all = Vec::new();
        while !file.is_empty() {
            let (length, rest) = file.split_first_chunk::<8>().unwrap();
            let (sum, rest) = rest.split_first_chunk::<4>().unwrap();
            assert_eq!(*sum, checksum(length));
            let (event, rest) = rest.split_at(u64::from_le_bytes(*length) as usize);
            let (sum, rest) = rest.split_first_chunk::<4>().unwrap();
            assert_eq!(*sum, checksum(event));
            all.push(Event::decode(event).unwrap());
            file = rest;
        }
        all
    }

    #[test]
    fn the_start_has_the_bytes_of_tensorflow() {
        let start = event_file_start(0.0);
        // Without a time the event has 15 bytes; with one it has the 24 bytes whose head every file of TensorFlow has.
        assert_eq!(start[12..27], *b"\x1a\x0dbrain.Event:2");
        let timed = event_file_start(1.7e9);
        assert_eq!(timed[..12], [0x18, 0, 0, 0, 0, 0, 0, 0, 0xa3, 0x7f, 0x4b, 0x22]);
        assert_eq!(timed.len(), 12 + 24 + 4);
    }

    #[test]
    fn records_return_with_steps_times_and_the_values_that_exist() {
        let log = UpdateLog { steps: 300, mean_reward: Some(0.5), entropy: 2.0, ..UpdateLog::default() };
        let early = UpdateLog { steps: 150, ..UpdateLog::default() };
        let file = [event_file_start(7.0), event_of_update(&early, 8.0), event_of_update(&log, 9.5)].concat();
        let events = events(&file);
        assert_eq!(events[0].file_version.as_deref(), Some(VERSION));
        assert_eq!((events[1].step, events[2].step, events[2].wall_time), (150, 300, 9.5));
        let value = |event: &Event, tag: &str| {
            event.summary.as_ref().unwrap().values.iter().find(|value| value.tag == tag)?.simple_value
        };
        assert_eq!(value(&events[1], "rollout/ep_rew_mean"), None);
        assert_eq!(value(&events[2], "rollout/ep_rew_mean"), Some(0.5));
        assert_eq!(value(&events[2], "train/entropy_loss"), Some(-2.0));
    }
}
