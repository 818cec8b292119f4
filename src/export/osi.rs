//! ASAM OSI: a trace of `GroundTruth` messages, one a tick, each after its length.
//!
//! # Source
//! ASAM OSI 3.8.0, `osi_groundtruth.proto`, `osi_object.proto`, `osi_common.proto`; `doc/architecture/trace_file_formats.adoc`. Only the messages and
//! fields that an episode needs.

use prost::Message;

use super::episode::{Actor, CAR_HEIGHT, Motion, Shape};
use super::{Episode, ExportError, ExportFile, Exporter, Variant, opendrive};
use crate::geometry::OrientedBox;
use crate::sim::ActorId;

/// The exporter of OSI traces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Osi;

/// The version of OSI.
const VERSION: InterfaceVersion = InterfaceVersion { major: Some(3), minor: Some(8), patch: Some(0) };
/// The version of protobuf in the file's name: that of the package osi-python 3.8.0, by which the messages are tested.
const PROTOBUF: &str = "73602";
/// Numbers of enumerations: a vehicle and a pedestrian, a medium car, another stationary object.
const VEHICLE: i32 = 2;
const PEDESTRIAN: i32 = 3;
const MEDIUM_CAR: i32 = 4;
const OTHER: i32 = 1;
/// The height of obstacles (m).
const OBSTACLE_HEIGHT: f64 = 3.0;

#[derive(Clone, PartialEq, Message)]
struct GroundTruth {
    #[prost(message, optional, tag = "1")]
    version: Option<InterfaceVersion>,
    #[prost(message, optional, tag = "2")]
    timestamp: Option<Timestamp>,
    #[prost(message, optional, tag = "3")]
    host_vehicle: Option<Identifier>,
    #[prost(message, repeated, tag = "4")]
    stationary_objects: Vec<StationaryObject>,
    #[prost(message, repeated, tag = "5")]
    moving_objects: Vec<MovingObject>,
    #[prost(string, optional, tag = "15")]
    map_reference: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct InterfaceVersion {
    #[prost(uint32, optional, tag = "1")]
    major: Option<u32>,
    #[prost(uint32, optional, tag = "2")]
    minor: Option<u32>,
    #[prost(uint32, optional, tag = "3")]
    patch: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Timestamp {
    #[prost(int64, optional, tag = "1")]
    seconds: Option<i64>,
    #[prost(uint32, optional, tag = "2")]
    nanos: Option<u32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Identifier {
    #[prost(uint64, optional, tag = "1")]
    value: Option<u64>,
}

/// A vector; also length, width and height, and roll, pitch and yaw, which have the same numbers.
#[derive(Clone, Copy, PartialEq, Message)]
struct Triple {
    #[prost(double, optional, tag = "1")]
    x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    z: Option<f64>,
}

/// `BaseMoving`, and `BaseStationary` without a velocity.
#[derive(Clone, PartialEq, Message)]
struct Base {
    #[prost(message, optional, tag = "1")]
    dimension: Option<Triple>,
    #[prost(message, optional, tag = "2")]
    position: Option<Triple>,
    #[prost(message, optional, tag = "3")]
    orientation: Option<Triple>,
    #[prost(message, optional, tag = "4")]
    velocity: Option<Triple>,
}

#[derive(Clone, PartialEq, Message)]
struct MovingObject {
    #[prost(message, optional, tag = "1")]
    id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    base: Option<Base>,
    #[prost(int32, optional, tag = "3")]
    kind: Option<i32>,
    #[prost(message, optional, tag = "5")]
    attributes: Option<VehicleAttributes>,
    #[prost(message, optional, tag = "6")]
    classification: Option<Classification>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct VehicleAttributes {
    #[prost(message, optional, tag = "4")]
    centre_to_rear: Option<Triple>,
    #[prost(message, optional, tag = "5")]
    centre_to_front: Option<Triple>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct Classification {
    #[prost(int32, optional, tag = "1")]
    kind: Option<i32>,
}

#[derive(Clone, PartialEq, Message)]
struct StationaryObject {
    #[prost(message, optional, tag = "1")]
    id: Option<Identifier>,
    #[prost(message, optional, tag = "2")]
    base: Option<Base>,
    #[prost(message, optional, tag = "3")]
    classification: Option<Classification>,
}

impl Exporter for Osi {
    fn name(&self) -> &'static str {
        "osi"
    }

    fn about(&self) -> &'static str {
        "ASAM OSI 3.8 ground truth, a message a tick, with the OpenDRIVE map"
    }

    fn approximates(&self) -> &'static str {
        "a pedestrian's disc is the square around it; lanes are in the map only"
    }

    fn export(&self, episode: &Episode, _: Variant) -> Result<Vec<ExportFile>, ExportError> {
        let map = opendrive::map_file(&episode.scenario.town)?;
        let actors = episode.actors();
        let mut bytes = Vec::new();
        for tick in 0..=episode.ticks() {
            let message = ground_truth(episode, &actors, tick, &map.name).encode_to_vec();
            // The messages of a tick are some kilobytes, so their length fits.
            bytes.extend_from_slice(&(message.len() as u32).to_le_bytes());
            bytes.extend_from_slice(&message);
        }
        let frames = episode.ticks() + 1;
        let name = format!("20261122T000000Z_gt_380_{PROTOBUF}_{frames}_{}.osi", episode.stem());
        Ok(vec![ExportFile { name, bytes }, map])
    }
}

fn triple([x, y, z]: [f64; 3]) -> Option<Triple> {
    Some(Triple { x: Some(x), y: Some(y), z: Some(z) })
}

fn identifier(value: usize) -> Option<Identifier> {
    Some(Identifier { value: Some(value as u64) })
}

/// The message of a tick. Obstacles are in the first one only, since they do not move.
fn ground_truth(episode: &Episode, actors: &[Actor], tick: usize, map: &str) -> GroundTruth {
    let nanos = (tick as f64 * episode.dt() * 1e9).round() as i64;
    let obstacles = if tick == 0 { &episode.scenario.town.obstacles[..] } else { &[] };
    let moving = actors.iter().enumerate();
    let still = obstacles.iter().enumerate();
    GroundTruth {
        version: Some(VERSION),
        timestamp: Some(Timestamp {
            seconds: Some(nanos.div_euclid(1_000_000_000)),
            nanos: Some(nanos.rem_euclid(1_000_000_000) as u32),
        }),
        host_vehicle: identifier(0),
        stationary_objects: still.map(|(number, own)| obstacle(actors.len() + number, own)).collect(),
        moving_objects: moving.map(|(number, actor)| moving_object(number, actor, &actor.track[tick])).collect(),
        map_reference: Some(map.to_owned()),
    }
}

fn moving_object(number: usize, actor: &Actor, motion: &Motion) -> MovingObject {
    let size = actor.size();
    let axle = |ahead: f64| triple([ahead, 0.0, -CAR_HEIGHT / 2.0]);
    let attributes = match actor.shape {
        Shape::Vehicle(blueprint) => Some(VehicleAttributes {
            centre_to_rear: axle(-blueprint.wheelbase / 2.0),
            centre_to_front: axle(blueprint.wheelbase / 2.0),
        }),
        Shape::Pedestrian(_) => None,
    };
    MovingObject {
        id: identifier(number),
        base: Some(Base {
            dimension: triple(size),
            position: triple([motion.pose.x, motion.pose.y, motion.ground + size[2] / 2.0]),
            orientation: triple([0.0, 0.0, motion.pose.yaw]),
            velocity: triple([motion.velocity.x, motion.velocity.y, 0.0]),
        }),
        kind: Some(if matches!(actor.id, ActorId::Vehicle(_)) { VEHICLE } else { PEDESTRIAN }),
        classification: attributes.map(|_| Classification { kind: Some(MEDIUM_CAR) }),
        attributes,
    }
}

fn obstacle(number: usize, own: &OrientedBox) -> StationaryObject {
    StationaryObject {
        id: identifier(number),
        base: Some(Base {
            dimension: triple([2.0 * own.half.x, 2.0 * own.half.y, OBSTACLE_HEIGHT]),
            position: triple([own.pose.x, own.pose.y, OBSTACLE_HEIGHT / 2.0]),
            orientation: triple([0.0, 0.0, own.pose.yaw]),
            velocity: None,
        }),
        classification: Some(Classification { kind: Some(OTHER) }),
    }
}
