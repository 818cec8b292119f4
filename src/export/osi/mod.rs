//! ASAM OSI: a trace of `GroundTruth` messages, one a tick, in an MCAP recording.
//!
//! The descriptor in a recording has the messages and fields that a trace holds, under their names in the standard, and no others.
//!
//! # Source
//! ASAM OSI 3.8.0, `osi_groundtruth.proto`, `osi_object.proto`, `osi_common.proto`; `doc/architecture/trace_file_formats.adoc`. Only the messages and
//! fields that an episode needs.

mod messages;
mod ground_truth;
mod descriptor;
mod read;

pub use read::{TraceError, read};

use prost::Message;

use super::format::{ExportFile, Exporter, Variant};
use super::recording::{Channel, Recording};
use super::{Episode, ExportError, opendrive};

/// The versions of OSI and of protobuf: those of the package osi-python 3.8.0, by which the messages are tested.
const VERSION: &str = "3.8.0";
const PROTOBUF: &str = "7.36.2";

pub(super) const OSI: Exporter = Exporter {
    name: "osi",
    about: "ASAM OSI 3.8 ground truth in MCAP, a message a tick, with the OpenDRIVE map",
    approximates: APPROXIMATES,
    files,
    ..Exporter::RECORDED
};

const APPROXIMATES: &str =
    "a pedestrian's disc is the square around it; lanes are in the map only; phases of traffic lights are left out";

fn files(episode: &Episode<'_>, _: Variant) -> Result<Vec<ExportFile>, ExportError> {
    let map = opendrive::map_file(&episode.scenario.town)?;
    let mut recording = Recording::new();
    let description = format!("{}; approximated: {}", episode.summary(), APPROXIMATES);
    recording.metadata(
        "net.asam.osi.trace",
        &[
            ("version", VERSION),
            ("min_osi_version", VERSION),
            ("max_osi_version", VERSION),
            ("min_protobuf_version", PROTOBUF),
            ("max_protobuf_version", PROTOBUF),
            ("description", &description),
        ],
    );
    let channel = recording.channel(&Channel {
        topic: "ground_truth",
        schema: "osi3.GroundTruth",
        schema_encoding: "protobuf",
        schema_data: &descriptor::descriptor().encode_to_vec(),
        message_encoding: "protobuf",
        metadata: &[
            ("net.asam.osi.trace.channel.osi_version", VERSION),
            ("net.asam.osi.trace.channel.protobuf_version", PROTOBUF),
        ],
    });
    for (tick, message) in messages(episode, &map.name).enumerate() {
        recording.message(channel, episode.nanos(tick), &message);
    }
    Ok(vec![ExportFile { name: file_name(episode), bytes: recording.finish() }, map])
}

/// The messages of all ticks.
fn messages(episode: &Episode, map: &str) -> impl Iterator<Item = Vec<u8>> {
    let actors = episode.actors();
    (0..=episode.ticks()).map(move |tick| ground_truth::ground_truth(episode, &actors, tick, map).encode_to_vec())
}

/// A file's name as the standard recommends it: time, type, versions of OSI and protobuf, frames, name.
fn file_name(episode: &Episode) -> String {
    let [osi, protobuf] = [VERSION, PROTOBUF].map(|version| version.replace('.', ""));
    let frames = episode.ticks() + 1;
    format!("20261122T000000Z_gt_{osi}_{protobuf}_{frames}_{}.mcap", episode.stem())
}
