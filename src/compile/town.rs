use std::path::Path;

use crate::diagnostic::{Diagnostic, Sources};
use crate::geometry::{OrientedBox, Point};
use crate::lang::codes;
use crate::lang::hir::{Block, Declaration};
use crate::road::design::{BuildingRow, Node, Street, StreetProfile, TownDesign};
use crate::road::{Town, opendrive};
use crate::signature::{Form, Param, Signature, Type, Value};
use crate::units::Dimension;

use crate::lang::Reader;

/// Points of streets closer than this are one node (m).
const SAME_NODE: f64 = 0.01;

/// The form `town`.
pub fn form() -> Form {
    Form {
        name: "town",
        doc: "Roads with lanes and sidewalks, junctions, and what stands beside them: written here, or read from a map.",
        plain: Some(designed()),
        kinds: vec![Signature {
            children: obstacles(),
            ..Signature::new(
                "opendrive",
                "A town from an OpenDRIVE map. Such maps hold no buildings; they can be added here.",
                vec![Param::required("file", Type::Path, "The map, relative to the folder of this file.")],
            )
        }],
    }
}

fn designed() -> Signature {
    let length = || Type::positive(Dimension::LENGTH);
    let street = Signature::new(
        "street",
        "A two-lane street with sidewalks along straight lines. Where streets share a point they meet: two bend, three make a T-junction, four a crossing.",
        vec![
            Param::required("through", Type::List(Box::new(Type::Point)), "The points it leads through, at least two."),
            Param::optional("speed_limit", Type::positive(Dimension::SPEED), "What the signs at its beginnings say."),
        ],
    );
    let row_houses = Signature::new(
        "row_houses",
        "Houses along both sides of all straight streets.",
        vec![
            Param::with_default(
                "setback",
                Type::non_negative(Dimension::LENGTH),
                "1 m",
                "Distance of the fronts from the sidewalk.",
            ),
            Param::with_default("depth", length(), "10 m", "Extent away from the street."),
            Param::with_default("length", length(), "16 m", "Extent along the street."),
            Param::with_default("gap", Type::non_negative(Dimension::LENGTH), "4 m", "Distance between two houses."),
        ],
    );
    let mut children = vec![street, row_houses];
    children.extend(obstacles());
    Signature {
        children,
        ..Signature::new(
            "town",
            "",
            vec![
                Param::with_default(
                    "lane_width",
                    length(),
                    "3.5 m",
                    "Width of a driving lane; one in either direction.",
                ),
                Param::with_default(
                    "shoulder",
                    Type::non_negative(Dimension::LENGTH),
                    "0.3 m",
                    "Width of the strip between lane and sidewalk.",
                ),
                Param::with_default("sidewalk", length(), "3 m", "Width of the sidewalks."),
                Param::with_default(
                    "bend_radius",
                    length(),
                    "12 m",
                    "Radius of the middle of a street where it bends.",
                ),
                Param::with_default(
                    "corner_radius",
                    length(),
                    "2 m",
                    "Radius of the sidewalk's outer edge at the corner of a junction.",
                ),
                Param::with_default(
                    "traffic_lights",
                    Type::Boolean,
                    "false",
                    "Whether all junctions have traffic lights.",
                ),
            ],
        )
    }
}

fn obstacles() -> Vec<Signature> {
    vec![Signature::new(
        "building",
        "A house, a wall, a parked van: it blocks walkers and sight.",
        vec![
            Param::required("corner", Type::Point, "One corner."),
            Param::required("opposite", Type::Point, "The opposite corner."),
        ],
    )]
}

/// Builds a town, saying what is wrong with it.
pub fn lower(declaration: &Declaration, sources: &Sources, read: &Reader, said: &mut Vec<Diagnostic>) -> Option<Town> {
    let block = &declaration.block;
    let parts = match declaration.kind {
        "opendrive" => {
            let path = block.arguments.text("file");
            let unusable = |reason: String| codes::unusable_map(block.place("file"), path, &reason);
            let folder = sources.get(declaration.source).path.parent().unwrap_or(Path::new("")).to_path_buf();
            let text = match read(&folder.join(path)) {
                Ok(text) => text,
                Err(error) => {
                    said.push(unusable(crate::lang::reason(&error)));
                    return None;
                }
            };
            match opendrive::read(&text, &declaration.name) {
                Ok(mut parts) => {
                    parts.obstacles.extend(buildings(block));
                    parts
                }
                Err(error) => {
                    said.push(unusable(error.to_string()));
                    return None;
                }
            }
        }
        _ => match design(declaration).build() {
            Ok(parts) => parts,
            Err(faults) => {
                said.extend(faults.iter().map(|fault| codes::unbuildable_town(block.head, &fault.to_string())));
                return None;
            }
        },
    };
    Some(Town::new(parts))
}

fn design(declaration: &Declaration) -> TownDesign {
    let block = &declaration.block;
    let number = |key: &str| block.arguments.number(key);
    let lights = block.arguments.boolean("traffic_lights");
    let mut nodes: Vec<Node> = Vec::new();
    let mut node_at = |place: Point| {
        let known = nodes.iter().position(|node| (node.position - place).norm() < SAME_NODE);
        known.unwrap_or_else(|| {
            nodes.push(Node { name: format!("({} m, {} m)", place.x, place.y), position: place, lights: false });
            nodes.len() - 1
        })
    };
    let mut streets = Vec::new();
    for (index, street) in block.nested("street").enumerate() {
        let points = street.arguments.list("through").iter().map(|value| match value {
            Value::Point(x, y) => Point::new(*x, *y),
            other => panic!("checked: a point, not {other:?}"),
        });
        streets.push(Street {
            name: street.name.clone().unwrap_or_else(|| format!("number {}", index + 1)),
            nodes: points.map(&mut node_at).collect(),
            speed_limit: street.arguments.has("speed_limit").then(|| street.arguments.number("speed_limit")),
        });
    }
    if lights {
        for (index, node) in nodes.iter_mut().enumerate() {
            node.lights = legs(&streets, index) > 2;
        }
    }
    let row = block.nested("row_houses").next().map(|row| BuildingRow {
        setback: row.arguments.number("setback"),
        depth: row.arguments.number("depth"),
        length: row.arguments.number("length"),
        gap: row.arguments.number("gap"),
    });
    TownDesign {
        name: declaration.name.clone(),
        nodes,
        streets,
        buildings: buildings(block),
        profile: StreetProfile {
            lane_width: number("lane_width"),
            shoulder: number("shoulder"),
            sidewalk: number("sidewalk"),
        },
        bend_radius: number("bend_radius"),
        corner_radius: number("corner_radius"),
        block_buildings: row,
        ..TownDesign::default()
    }
}

/// How many pieces of street meet at a node.
fn legs(streets: &[Street], node: usize) -> usize {
    let pieces = streets.iter().flat_map(|street| street.nodes.windows(2));
    pieces.map(|ends| ends.iter().filter(|end| **end == node).count()).sum()
}

fn buildings(block: &Block) -> Vec<OrientedBox> {
    let corners = |building: &Block| {
        let (a, b) = (building.arguments.point("corner"), building.arguments.point("opposite"));
        OrientedBox::spanning(Point::new(a.0, a.1), Point::new(b.0, b.1))
    };
    block.nested("building").map(corners).collect()
}
