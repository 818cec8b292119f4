//! Objects and signals on their roads, and the lanes that each applies to.

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, ROUNDED, child, children, metres};
use super::roads::Roads;
use crate::lane_network::{LaneNetwork, LaneSlot};
use crate::{LaneId, LaneKind, Road, RoadIndex};

/// An object or signal: its road, and its lanes there.
pub(super) struct Placed<'a, 'x> {
    pub node: Node<'a, 'x>,
    pub road: RoadIndex,
    pub s: f64,
    pub lanes: Vec<LaneSlot>,
}

/// Finds all elements of a name within a container of each road, with the driving lanes they apply to.
pub(super) fn placed<'a, 'x: 'a>(
    context: &mut Context,
    roads: &Roads<'a, 'x>,
    network: &LaneNetwork,
    [container, name]: [&'static str; 2],
    wanted: impl Fn(Node) -> bool,
) -> Vec<Placed<'a, 'x>> {
    let mut found = Vec::new();
    for ((road, node), index) in roads.roads.iter().zip(&roads.nodes).zip(0..) {
        context.road = node.attribute("id").map(str::to_owned);
        let elements = child(*node, container).into_iter().flat_map(|container| children(container, name));
        for node in elements.filter(|node| wanted(*node)) {
            let Some(s) = context.number(node, "s") else { continue };
            if s < -ROUNDED || s > road.length + ROUNDED {
                let (s, length) = (metres(s), metres(road.length));
                context.warn(node, OpenDriveProblem::BeyondRoad { element: name, s, length });
            }
            let s = s.clamp(0.0, road.length);
            let lanes = lanes(context, node, network, road, RoadIndex(index), s);
            found.push(Placed { node, road: RoadIndex(index), s, lanes });
        }
    }
    context.road = None;
    found
}

/// The driving lanes that a sign or signal applies to: those of its validities, or without any those of its direction, or else all.
///
/// # Source
/// ASAM OpenDRIVE 1.4 to 1.8: orientation `+` is for traffic along the reference line, `-` for traffic against it. In CARLA's maps `+` is for
/// left lanes, and `-` for right ones (CARLA `road/MapBuilder.cpp`).
fn lanes(
    context: &mut Context,
    node: Node,
    network: &LaneNetwork,
    road: &Road,
    index: RoadIndex,
    s: f64,
) -> Vec<LaneSlot> {
    let ranges = validities(context, node);
    let orientation = node.attribute("orientation").unwrap_or_default().trim();
    if !matches!(orientation, "" | "+" | "-" | "none") {
        context.unknown(node, "orientation", orientation, "it counts in both directions");
    }
    let along = |id: LaneId| if context.of_carla { id > 0 } else { road.is_forward(id) };
    let holds = |id: LaneId| match orientation {
        _ if !ranges.is_empty() => ranges.iter().any(|(a, b)| (*a.min(b)..=*a.max(b)).contains(&id)),
        "+" => along(id),
        "-" => !along(id),
        _ => true,
    };
    driving_lanes(network, road, index, s, holds)
}

/// The ranges of lanes of an element.
fn validities(context: &mut Context, node: Node) -> Vec<(LaneId, LaneId)> {
    children(node, "validity")
        .filter_map(|node| Some((context.whole(node, "fromLane")?, context.whole(node, "toLane")?)))
        .collect()
}

/// The driving lanes at a place on a road (m) whose numbers are wanted.
pub(super) fn driving_lanes(
    network: &LaneNetwork,
    road: &Road,
    index: RoadIndex,
    s: f64,
    wanted: impl Fn(LaneId) -> bool,
) -> Vec<LaneSlot> {
    let section = road.section_at(s);
    let lanes = road.sections.get(section).map_or(&[][..], |section| &section.lanes);
    let admitted = lanes.iter().filter(|lane| lane.kind == LaneKind::Driving && wanted(lane.id));
    admitted.filter_map(|lane| network.slot_of(index, section as u32, lane.id)).collect()
}
