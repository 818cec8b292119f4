//! Speed signs, and the lanes that a sign or a signal applies to.

use roxmltree::Node;

use super::attributes::{Context, child, children};
use super::roads::Roads;
use crate::geometry::OrientedBox;
use crate::road::lane_network::{LaneNetwork, LaneSlot};
use crate::road::{LaneId, LaneKind, Road, RoadIndex, SpeedSign};

/// The half size of a speed sign's trigger box, as a share of the lane's width.
const HALF_SIZE: f64 = 0.35;

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
            let s = s.clamp(0.0, road.length);
            let lanes = lanes(context, node, network, road, RoadIndex(index), s);
            found.push(Placed { node, road: RoadIndex(index), s, lanes });
        }
    }
    context.road = None;
    found
}

/// The driving lanes that a sign or signal applies to: those of its validities, or without any those of its side.
///
/// # Source
/// CARLA `road/MapBuilder.cpp`: orientation `+` selects left lanes, `-` right ones, anything else both.
fn lanes(
    context: &mut Context,
    node: Node,
    network: &LaneNetwork,
    road: &Road,
    index: RoadIndex,
    s: f64,
) -> Vec<LaneSlot> {
    let ranges: Vec<(LaneId, LaneId)> = children(node, "validity")
        .filter_map(|node| Some((context.whole(node, "fromLane")?, context.whole(node, "toLane")?)))
        .collect();
    let orientation = node.attribute("orientation").unwrap_or_default();
    let holds = |id: LaneId| match orientation {
        _ if !ranges.is_empty() => ranges.iter().any(|(a, b)| (*a.min(b)..=*a.max(b)).contains(&id)),
        "+" => id > 0,
        "-" => id < 0,
        _ => true,
    };
    let section = road.section_at(s);
    let lanes = road.sections.get(section).map_or(&[][..], |section| &section.lanes);
    let admitted = lanes.iter().filter(|lane| lane.kind == LaneKind::Driving && holds(lane.id));
    admitted.filter_map(|lane| network.slot_of(index, section as u32, lane.id)).collect()
}

/// Reads speed signs: objects named `Speed_NN` and signals of type 274, in km/h whatever their unit.
pub(super) fn speed_signs(context: &mut Context, roads: &Roads, network: &LaneNetwork) -> Vec<SpeedSign> {
    let mut signs = placed(context, roads, network, ["objects", "object"], |node| limit(node).is_some());
    signs.extend(placed(context, roads, network, ["signals", "signal"], |node| limit(node).is_some()));
    let mut found = Vec::new();
    for sign in signs {
        let Some(limit) = limit(sign.node) else { continue };
        for slot in sign.lanes {
            let lane = network.lane(slot);
            let half = HALF_SIZE * network.width(lane, sign.s).max(0.0);
            let upstream = if lane.forward() { sign.s - half } else { sign.s + half };
            let pose = network.pose(&roads.roads, lane, upstream.max(lane.start).min(lane.end));
            found.push(SpeedSign { limit: limit / 3.6, trigger: OrientedBox::new(pose, half, half) });
        }
    }
    found
}

/// The limit of a sign (km/h).
fn limit(node: Node) -> Option<f64> {
    let text = match node.attribute("type") {
        Some("274") => node
            .attribute("subtype")
            .filter(|text| text.parse::<f64>().is_ok_and(|n| n > 0.0))
            .or(node.attribute("value"))?,
        _ => node.attribute("name")?.strip_prefix("Speed_")?,
    };
    text.trim().parse().ok().filter(|limit: &f64| *limit > 0.0 && *limit < 1000.0)
}
