//! Foxglove: an MCAP recording of `foxglove.SceneUpdate` messages in JSON, for Foxglove and Lichtblick.
//!
//! The channel `/town` has one message, at the start: lanes, crosswalks and obstacles. `/actors` has one a tick, and so has `/measures`,
//! whose numbers a plot can show. Each entity remains until the next message with its name replaces it.
//!
//! # Source
//! Foxglove's schemas, `foxglove.SceneUpdate` as JSON Schema (`@foxglove/schemas` 2.1.0).

use serde::Serialize;
use serde_json::{Value, json};

use super::episode::{Actor, Motion, OBSTACLE_HEIGHT, Shape};
use super::format::{ExportFile, Exporter, Variant};
use super::lane_bounds::lane_bounds;
use super::recording::{Channel, ChannelId, Recording};
use super::{Episode, ExportError};
use road::geometry::{OrientedBox, Point};
use road::{LaneKind, Town};
use world::sim::ActorId;

/// The frame of all coordinates.
const FRAME: &str = "town";
/// The maximum distance between two points of a lane's edge (m).
const STEP: f64 = 2.0;
/// Width of a line (m).
const LINE: f64 = 0.12;
/// Types of lines.
const STRIP: u8 = 0;
const LOOP: u8 = 1;

/// Colours: red, green, blue, opacity.
const LANE: [f64; 4] = [0.75, 0.77, 0.8, 1.0];
const SIDEWALK: [f64; 4] = [0.45, 0.47, 0.5, 1.0];
const CROSSWALK: [f64; 4] = [1.0, 1.0, 1.0, 1.0];
const OBSTACLE: [f64; 4] = [0.5, 0.44, 0.38, 0.85];
const EGO: [f64; 4] = [0.13, 0.34, 0.77, 1.0];
const TRAFFIC: [f64; 4] = [0.27, 0.63, 0.7, 1.0];
const PEDESTRIAN: [f64; 4] = [0.84, 0.19, 0.19, 1.0];

/// The quantities of a tick.
#[derive(Debug, Serialize)]
struct Measures {
    gap_m: f64,
    ego_speed_mps: f64,
    pedestrian_speed_mps: f64,
    in_sight: bool,
}

pub(super) const FOXGLOVE: Exporter = Exporter {
    name: "foxglove",
    about: "MCAP with foxglove.SceneUpdate messages, for Foxglove and Lichtblick",
    approximates: APPROXIMATES,
    files,
    ..Exporter::RECORDED
};

const APPROXIMATES: &str = "edges of lanes are polylines with a point every 2 m; signs and lights are left out";

fn files(episode: &Episode<'_>, _: Variant) -> Result<Vec<ExportFile>, ExportError> {
    let mut recording = Recording::new();
    let about = [("episode", episode.name), ("summary", &*episode.summary()), ("approximated", APPROXIMATES)];
    recording.metadata("falsify", &about);
    let scene = scene_schema();
    let town = open(&mut recording, "/town", "foxglove.SceneUpdate", &scene);
    let moving = open(&mut recording, "/actors", "foxglove.SceneUpdate", &scene);
    let measures = open(&mut recording, "/measures", "falsify.Measures", &measures_schema());
    let mut write = |channel: ChannelId, time: u64, message: &Value| {
        recording.message(channel, time, message.to_string().as_bytes());
    };
    let actors = episode.actors();
    write(town, 0, &update(town_entities(&episode.scenario.town)));
    let pedestrian = episode.main_pedestrian() - episode.scenario.cast.vehicles.len();
    let pair = episode.trace.pair(episode.scenario, 0, pedestrian);
    for (tick, frame) in pair.frames().enumerate() {
        let time = episode.nanos(tick);
        let entities = actors.iter().map(|actor| actor_entity(actor, &actor.track[tick], time)).collect();
        write(moving, time, &update(entities));
        let now = Measures {
            gap_m: short(pair.gap(&frame)),
            ego_speed_mps: short(frame.ego.speed),
            pedestrian_speed_mps: short(frame.pedestrian.velocity.norm()),
            in_sight: pair.in_sight(&frame),
        };
        write(measures, time, &json!(now));
    }
    Ok(vec![ExportFile { name: format!("{}.foxglove.mcap", episode.stem()), bytes: recording.finish() }])
}

fn open(recording: &mut Recording, topic: &str, schema: &str, data: &Value) -> ChannelId {
    recording.channel(&Channel {
        topic,
        schema,
        schema_encoding: "jsonschema",
        schema_data: data.to_string().as_bytes(),
        message_encoding: "json",
        metadata: &[],
    })
}

/// A number with at most six decimals: micrometres.
fn short(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

fn update(entities: Vec<Value>) -> Value {
    json!({ "deletions": [], "entities": entities })
}

fn entity(name: &str, time: u64, primitives: &str, list: Vec<Value>) -> Value {
    let mut entity = json!({
        "timestamp": { "sec": time / 1_000_000_000, "nsec": time % 1_000_000_000 },
        "frame_id": FRAME,
        "id": name,
        "lifetime": { "sec": 0, "nsec": 0 },
        "frame_locked": false,
        "metadata": [],
    });
    for kind in ["arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"] {
        entity[kind] = json!([]);
    }
    entity[primitives] = Value::Array(list);
    entity
}

fn point(point: &Point, height: f64) -> Value {
    json!({ "x": short(point.x), "y": short(point.y), "z": short(height) })
}

fn pose(place: &Point, height: f64, yaw: f64) -> Value {
    let (sin, cos) = libm::sincos(yaw / 2.0);
    json!({
        "position": point(place, height),
        "orientation": { "x": 0, "y": 0, "z": short(sin), "w": short(cos) },
    })
}

fn size([length, width, height]: [f64; 3]) -> Value {
    json!({ "x": short(length), "y": short(width), "z": short(height) })
}

fn colour([r, g, b, a]: [f64; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}

fn line(kind: u8, points: &[Point], own: [f64; 4]) -> Value {
    let points: Vec<Value> = points.iter().map(|place| point(place, 0.0)).collect();
    json!({
        "type": kind,
        "pose": pose(&Point::origin(), 0.0, 0.0),
        "thickness": LINE,
        "scale_invariant": false,
        "points": points,
        "color": colour(own),
        "colors": [],
        "indices": [],
    })
}

fn cube(outline: &OrientedBox, ground: f64, height: f64, own: [f64; 4]) -> Value {
    json!({
        "pose": pose(&outline.pose.position(), ground + height / 2.0, outline.pose.yaw),
        "size": size([2.0 * outline.half.x, 2.0 * outline.half.y, height]),
        "color": colour(own),
    })
}

fn town_entities(town: &Town) -> Vec<Value> {
    let mut edges = Vec::new();
    for (start, kind) in town.lane_starts().filter(|(_, kind)| *kind != LaneKind::None) {
        let own = if kind == LaneKind::Driving { LANE } else { SIDEWALK };
        edges.extend(lane_bounds(town, start, STEP).iter().map(|edge| line(STRIP, edge, own)));
    }
    let crosswalks = town.crosswalks.iter().map(|corners| line(LOOP, corners, CROSSWALK)).collect();
    let obstacles = town.obstacles.iter().map(|own| cube(own, 0.0, OBSTACLE_HEIGHT, OBSTACLE)).collect();
    vec![
        entity("lanes", 0, "lines", edges),
        entity("crosswalks", 0, "lines", crosswalks),
        entity("obstacles", 0, "cubes", obstacles),
    ]
}

fn actor_entity(actor: &Actor, motion: &Motion, time: u64) -> Value {
    let [length, width, height] = actor.size();
    match actor.shape {
        Shape::Vehicle(_) => {
            let own = if actor.id == ActorId::EGO { EGO } else { TRAFFIC };
            entity(&actor.name, time, "cubes", vec![cube(&actor.outline(motion), motion.ground, height, own)])
        }
        Shape::Pedestrian(body) if body.target_box.is_some() => {
            let target = cube(&actor.outline(motion), motion.ground, height, PEDESTRIAN);
            entity(&actor.name, time, "cubes", vec![target])
        }
        Shape::Pedestrian(_) => {
            let disc = json!({
                "pose": pose(&motion.pose.position(), motion.ground + height / 2.0, motion.pose.yaw),
                "size": size([length, width, height]),
                "bottom_scale": 1,
                "top_scale": 1,
                "color": colour(PEDESTRIAN),
            });
            entity(&actor.name, time, "cylinders", vec![disc])
        }
    }
}

fn object(title: &str, properties: &[(&str, Value)]) -> Value {
    let properties: serde_json::Map<String, Value> =
        properties.iter().map(|(name, kind)| ((*name).to_owned(), kind.clone())).collect();
    json!({ "title": title, "type": "object", "properties": properties })
}

/// The schema of `foxglove.SceneUpdate` without the primitives that do not occur.
fn scene_schema() -> Value {
    let [number, text, truth] = ["number", "string", "boolean"].map(|kind| json!({ "type": kind }));
    let integer = json!({ "type": "integer" });
    let list = |items: &Value| json!({ "type": "array", "items": items });
    let time = |title: &str| object(title, &[("sec", integer.clone()), ("nsec", integer.clone())]);
    let numbers = |title: &str, names: &[&str]| {
        object(title, &names.iter().map(|name| (*name, number.clone())).collect::<Vec<_>>())
    };
    let vector = numbers("foxglove.Vector3", &["x", "y", "z"]);
    let place = numbers("foxglove.Point3", &["x", "y", "z"]);
    let orientation = numbers("foxglove.Quaternion", &["x", "y", "z", "w"]);
    let pose = object("foxglove.Pose", &[("position", vector.clone()), ("orientation", orientation)]);
    let colour = numbers("foxglove.Color", &["r", "g", "b", "a"]);
    let cube = object(
        "foxglove.CubePrimitive",
        &[("pose", pose.clone()), ("size", vector.clone()), ("color", colour.clone())],
    );
    let cylinder = object(
        "foxglove.CylinderPrimitive",
        &[
            ("pose", pose.clone()),
            ("size", vector),
            ("bottom_scale", number.clone()),
            ("top_scale", number.clone()),
            ("color", colour.clone()),
        ],
    );
    let line = object(
        "foxglove.LinePrimitive",
        &[
            ("type", integer.clone()),
            ("pose", pose),
            ("thickness", number),
            ("scale_invariant", truth.clone()),
            ("points", list(&place)),
            ("color", colour.clone()),
            ("colors", list(&colour)),
            ("indices", list(&integer)),
        ],
    );
    let entity = object(
        "foxglove.SceneEntity",
        &[
            ("timestamp", time("time")),
            ("frame_id", text.clone()),
            ("id", text),
            ("lifetime", time("duration")),
            ("frame_locked", truth),
            ("cubes", list(&cube)),
            ("cylinders", list(&cylinder)),
            ("lines", list(&line)),
        ],
    );
    object("foxglove.SceneUpdate", &[("entities", list(&entity))])
}

fn measures_schema() -> Value {
    let number = json!({ "type": "number" });
    object(
        "falsify.Measures",
        &[
            ("gap_m", number.clone()),
            ("ego_speed_mps", number.clone()),
            ("pedestrian_speed_mps", number),
            ("in_sight", json!({ "type": "boolean" })),
        ],
    )
}
