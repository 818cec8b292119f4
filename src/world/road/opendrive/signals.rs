//! Signals and signs: where they are, and the lanes that each applies to.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::attributes::{Context, child, children};
use super::obstacles::trigger;
use super::roads::Roads;
use crate::geometry::OrientedBox;
use crate::road::lane_network::{LaneNetwork, LaneSlot};
use crate::road::{LaneId, LaneKind, Road, RoadIndex, SpeedSign};

/// The half size of a speed sign's trigger box, as a share of the lane's width.
const HALF_SIZE: f64 = 0.35;
/// The signal type of a speed limit.
const SPEED_LIMIT: &str = "274";

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

/// A signal at one of the places where it applies.
pub(super) struct Signal<'a, 'x> {
    /// The element that says what it is.
    pub definition: Node<'a, 'x>,
    /// The element at this place: a `signal` or a `signalReference`.
    pub at: Placed<'a, 'x>,
}

/// Finds all signals: first those at their own places, then those that references put elsewhere.
///
/// # Source
/// CARLA `road/MapBuilder.cpp`, `AddSignal`: an `id` names one signal of the whole file. If several have the same `id`, the last one
/// counts for all of them.
pub(super) fn signals<'a, 'x: 'a>(
    context: &mut Context,
    roads: &Roads<'a, 'x>,
    network: &LaneNetwork,
) -> Vec<Signal<'a, 'x>> {
    let of =
        |name| move |road: &Node<'a, 'x>| child(*road, "signals").into_iter().flat_map(move |all| children(all, name));
    let definitions: BTreeMap<&str, Node<'a, 'x>> =
        roads.nodes.iter().flat_map(of("signal")).filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let definition = |node: Node<'a, 'x>| node.attribute("id").and_then(|id| definitions.get(id).copied());
    let own = placed(context, roads, network, ["signals", "signal"], |_| true);
    let others = placed(context, roads, network, ["signals", "signalReference"], |_| true);
    let own = own.into_iter().map(|at| Signal { definition: definition(at.node).unwrap_or(at.node), at });
    let others = others.into_iter().filter_map(|at| Some(Signal { definition: definition(at.node)?, at }));
    own.chain(others).collect()
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

/// Reads speed signs: objects named `Speed_NN` or `speed_NN` and signals of type 274, in km/h whatever their unit.
pub(super) fn speed_signs(
    context: &mut Context,
    roads: &Roads,
    network: &LaneNetwork,
    signals: &[Signal],
) -> Vec<SpeedSign> {
    let objects = placed(context, roads, network, ["objects", "object"], |node| limit(node).is_some());
    let objects = objects.iter().map(|sign| (sign.node, sign));
    let signals = signals.iter().map(|signal| (signal.definition, &signal.at));
    let mut found = Vec::new();
    for (definition, sign) in objects.chain(signals) {
        let Some(limit) = limit(definition) else { continue };
        if sign.lanes.is_empty() {
            context.not_used(sign.node, "speed sign beside no driving lane".to_owned());
        }
        for slot in &sign.lanes {
            let lane = network.lane(*slot);
            let half = HALF_SIZE * network.width(lane, sign.s).max(0.0);
            let upstream = if lane.forward() { sign.s - half } else { sign.s + half };
            let pose = network.pose(&roads.roads, lane, upstream.max(lane.start).min(lane.end));
            let trigger = trigger(definition).unwrap_or_else(|| OrientedBox::new(pose, half, half));
            found.push(SpeedSign { limit: limit / 3.6, trigger });
        }
    }
    found
}

/// The limit of a speed sign (km/h); none for other elements.
pub(super) fn limit(node: Node) -> Option<f64> {
    let text = match node.attribute("type") {
        Some(SPEED_LIMIT) => node
            .attribute("subtype")
            .filter(|text| text.parse::<f64>().is_ok_and(|n| n > 0.0))
            .or(node.attribute("value"))?,
        _ => {
            let name = node.attribute("name")?;
            name.strip_prefix("Speed_").or_else(|| name.strip_prefix("speed_"))?
        }
    };
    text.trim().parse().ok().filter(|limit: &f64| *limit > 0.0 && *limit < 1000.0)
}
