use super::messages::{
    Base, Classification, ExternalReference, GroundTruth, Identifier, InterfaceVersion, MovingObject, StationaryObject,
    Timestamp, Triple, VehicleAttributes,
};
use crate::Episode;
use crate::episode::{Actor, CAR_HEIGHT, OBSTACLE_HEIGHT, Shape};
use road::geometry::OrientedBox;
use world::sim::ActorId;

/// The version of OSI.
const VERSION: InterfaceVersion = InterfaceVersion { major: Some(3), minor: Some(8), patch: Some(0) };
/// Numbers of enumerations: a vehicle and a pedestrian, a medium car, another stationary object.
const VEHICLE: i32 = 2;
const PEDESTRIAN: i32 = 3;
const MEDIUM_CAR: i32 = 4;
const OTHER: i32 = 1;

fn triple([x, y, z]: [f64; 3]) -> Option<Triple> {
    Some(Triple { x: Some(x), y: Some(y), z: Some(z) })
}

fn identifier(value: usize) -> Option<Identifier> {
    Some(Identifier { value: Some(value as u64) })
}

/// The message of a tick. Obstacles are in the first one only, since they do not move.
pub fn ground_truth(episode: &Episode, actors: &[Actor], tick: usize, map: &str) -> GroundTruth {
    let nanos = episode.nanos(tick);
    let obstacles = if tick == 0 { &episode.scenario.town.obstacles[..] } else { &[] };
    let moving = actors.iter().enumerate();
    let still = obstacles.iter().enumerate();
    GroundTruth {
        version: Some(VERSION),
        timestamp: Some(Timestamp {
            seconds: Some((nanos / 1_000_000_000) as i64),
            nanos: Some((nanos % 1_000_000_000) as u32),
        }),
        host_vehicle: identifier(0),
        stationary_objects: still.map(|(number, own)| obstacle(actors.len() + number, own)).collect(),
        moving_objects: moving.map(|(number, actor)| moving_object(number, actor, tick, actors.len() > 2)).collect(),
        map_reference: Some(map.to_owned()),
    }
}

/// An actor after a tick, with the name of its role if it is to be named.
fn moving_object(number: usize, actor: &Actor, tick: usize, is_named: bool) -> MovingObject {
    let motion = &actor.track[tick];
    let size = actor.size();
    let is_vehicle = matches!(actor.id, ActorId::Vehicle(_));
    // As OSI names an entity of OpenSCENARIO.
    let source = || ExternalReference {
        kind: Some("net.asam.openscenario".into()),
        identifiers: vec![if is_vehicle { "Vehicle" } else { "Pedestrian" }.into(), actor.name.clone()],
    };
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
            orientation: triple([0.0, motion.pitch, motion.pose.yaw]),
            velocity: triple([motion.velocity.x, motion.velocity.y, 0.0]),
        }),
        kind: Some(if is_vehicle { VEHICLE } else { PEDESTRIAN }),
        classification: attributes.as_ref().map(|_| Classification { kind: Some(MEDIUM_CAR) }),
        attributes,
        sources: is_named.then(source).into_iter().collect(),
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
