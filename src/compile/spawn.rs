use std::f64::consts::PI;

use crate::env::{EgoStart, Measure, SpawnRule};
use crate::geometry::Pose;
use crate::signature::{Arguments, Form, Param, Signature, Type, Value};
use crate::units::Dimension;

/// The form `spawn`.
pub fn form() -> Form {
    let params = vec![
        Param::with_default(
            "bearing",
            Type::Range { dimension: Dimension::ANGLE, min: -PI, max: PI },
            "-60 deg .. 60 deg",
            "Bearing of the pedestrian from the ego's heading, positive to the left.",
        ),
        Param::with_default(
            "distance",
            Type::Range { dimension: Dimension::LENGTH, min: 4.0, max: 1000.0 },
            "7 m .. 30 m",
            "Distance between the middles of ego and pedestrian.",
        ),
        Param::with_default(
            "measure",
            Type::Choice(&["range", "area"]),
            "range",
            "What is uniform: the distance, or the ground.",
        ),
        Param::with_default(
            "clearance",
            Type::non_negative(Dimension::LENGTH),
            "0.5 m",
            "Least distance from the pedestrian's middle to an obstacle.",
        ),
        Param::optional(
            "ego_poses",
            Type::List(Box::new(Type::Pose)),
            "Poses of which the ego takes one; without them it begins anywhere on the driving lanes outside junctions.",
        ),
        Param::with_default(
            "ego_speed",
            Type::Range { dimension: Dimension::SPEED, min: 0.0, max: 60.0 },
            "0 m/s .. 0 m/s",
            "How fast the ego begins.",
        ),
    ];
    Form {
        name: "spawn",
        doc: "Where an episode begins.",
        plain: Some(Signature::new("spawn", "", params)),
        multiplies: false,
        kinds: Vec::new(),
    }
}

/// The rule.
pub fn lower(arguments: &Arguments) -> SpawnRule {
    let pose = |value: &Value| match value {
        Value::Pose(x, y, yaw) => Pose::new(*x, *y, *yaw),
        other => panic!("checked: a pose, not {other:?}"),
    };
    SpawnRule {
        bearing: arguments.range("bearing"),
        distance: arguments.range("distance"),
        measure: if arguments.choice("measure") == "area" { Measure::Area } else { Measure::Range },
        clearance: arguments.number("clearance"),
        ego_start: match arguments.has("ego_poses") {
            true => EgoStart::Poses(arguments.list("ego_poses").iter().map(pose).collect()),
            false => EgoStart::Anywhere,
        },
        ego_speed: arguments.range("ego_speed"),
    }
}
