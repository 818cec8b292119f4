//! Signals and signs.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, child, children, metres};
use super::limits::{in_unit, note_odd};
use super::obstacles::trigger;
use super::placed::{Placed, placed};
use super::roads::Roads;
use crate::geometry::{OrientedBox, Point, Vector};
use crate::lane_index::{LaneIndex, Lanes};
use crate::lane_network::{LaneNetwork, LaneSlot};
use crate::{LaneFilter, SpeedSign};

/// The half size of a speed sign's trigger box, as a share of the lane's width.
const HALF_SIZE: f64 = 0.35;
/// A sign or a crosswalk farther than this from a lane's middle does not stand beside it (m).
pub(super) const BESIDE: f64 = 20.0;
/// The signal type of a speed limit.
const SPEED_LIMIT: &str = "274";
/// The signal type of a bus stop, as in the German road traffic regulations.
pub(super) const BUS_STOP: &str = "224";

/// A signal at one of the places where it applies.
pub(super) struct Signal<'a, 'x> {
    /// The element that says what it is.
    pub definition: Node<'a, 'x>,
    /// The element at this place: a `signal` or a `signalReference`.
    pub at: Placed<'a, 'x>,
}

/// Finds all signals: first those at their own places, then those that references put elsewhere.
pub(super) fn signals<'a, 'x: 'a>(
    context: &mut Context,
    roads: &Roads<'a, 'x>,
    network: &LaneNetwork,
) -> Vec<Signal<'a, 'x>> {
    let of =
        |name| move |road: &Node<'a, 'x>| child(*road, "signals").into_iter().flat_map(move |all| children(all, name));
    let mut definitions: BTreeMap<&str, (Node<'a, 'x>, usize)> = BTreeMap::new();
    for (id, node) in roads.nodes.iter().flat_map(of("signal")).filter_map(|node| Some((node.attribute("id")?, node))) {
        let count = definitions.get(id).map_or(0, |(_, count)| *count);
        definitions.insert(id, (node, count + 1));
    }
    for (id, (last, count)) in definitions.iter().filter(|(_, (_, count))| *count > 1) {
        context.warn(*last, OpenDriveProblem::RepeatedSignal { id: (*id).to_owned(), count: *count });
    }
    let own = placed(context, roads, network, ["signals", "signal"], |_| true);
    let mut found: Vec<Signal> = own.into_iter().map(|at| Signal { definition: at.node, at }).collect();
    for at in placed(context, roads, network, ["signals", "signalReference"], |_| true) {
        let id = at.node.attribute("id").unwrap_or_default();
        match definitions.get(id) {
            Some((definition, _)) => found.push(Signal { definition: *definition, at }),
            None => {
                let (element, id) = ("signalReference".to_owned(), id.to_owned());
                context.warn(at.node, OpenDriveProblem::UnknownReference { element, id });
            }
        }
    }
    found
}

/// Whether a map has speed signs as CARLA's maps have them: objects with names such as `Speed_30`. CARLA drives by them alone and ignores the
/// limits of road types, so here they count alone, too.
pub(super) fn has_carla_signs(root: Node) -> bool {
    let objects = children(root, "road").flat_map(|road| children(road, "objects"));
    objects.flat_map(|objects| children(objects, "object")).any(|object| limit(object).is_some())
}

/// Whether a map is one of CARLA's: it has speed signs as CARLA's have them, or its vendor is `VectorZero`, whose editor wrote CARLA's maps. In
/// all of those that we have, an orientation of `+` goes with the validity of left lanes.
pub(super) fn is_of_carla(root: Node) -> bool {
    let vendor = child(root, "header").and_then(|header| header.attribute("vendor"));
    vendor == Some("VectorZero") || has_carla_signs(root)
}

/// Reads speed signs: objects named `Speed_NN` or `speed_NN` and signals of type 274. Beside them it returns each limit (m/s) with its lane and
/// its place along the road (m).
///
/// A sign that stands far from its own lanes counts on the lane beside which it stands, if there is one. CARLA lets it count on its own road, where
/// no driver can see it.
pub(super) fn speed_signs(
    context: &mut Context,
    roads: &Roads,
    network: &LaneNetwork,
    signals: &[Signal],
) -> (Vec<SpeedSign>, Vec<(f64, LaneSlot, f64)>) {
    let index = LaneIndex::default();
    let objects = placed(context, roads, network, ["objects", "object"], |node| limit(node).is_some());
    let objects = objects.iter().map(|sign| (sign.node, sign));
    let signals = signals.iter().map(|signal| (signal.definition, &signal.at));
    let (mut found, mut on_lanes) = (Vec::new(), Vec::new());
    for (definition, sign) in objects.chain(signals) {
        if definition == sign.node {
            note_value(context, definition);
        }
        let Some(limit) = limit(definition) else {
            let unit = definition.attribute("unit").unwrap_or_default();
            if definition.attribute("type") == Some(SPEED_LIMIT) && in_unit(0.0, unit).is_none() && !unit.is_empty() {
                context.warn(sign.node, OpenDriveProblem::UnknownUnit { unit: unit.chars().take(40).collect() });
            }
            continue;
        };
        note_odd(context, sign.node, limit);
        if sign.lanes.is_empty() {
            context.not_used(sign.node, "speed sign beside no driving lane".to_owned());
        }
        let t = context.number_or_zero(sign.node, "t");
        let stands = roads.roads[sign.road.0 as usize].plan_view.pose(sign.s).to_world(Vector::new(0.0, t));
        for slot in &sign.lanes {
            let (mut slot, mut s) = (*slot, sign.s);
            let apart = |slot, s| (network.pose(&roads.roads, network.lane(slot), s).position() - stands).norm();
            if apart(slot, s) > BESIDE && trigger(definition).is_none() {
                let all = Lanes { roads: &roads.roads, network };
                let near = index.nearest(all, stands, LaneFilter::Driving);
                let near = near.and_then(|near| Some((network.slot(near)?, near.s)));
                if let Some(near) = near.filter(|(slot, s)| apart(*slot, *s) <= BESIDE) {
                    context.warn(sign.node, OpenDriveProblem::SignFarAway { apart: apart(slot, s) as u32 });
                    (slot, s) = near;
                }
            }
            let lane = network.lane(slot);
            on_lanes.push((limit, slot, s));
            let half = HALF_SIZE * network.width(lane, s).max(0.0);
            let upstream = if lane.forward() { s - half } else { s + half };
            let pose = network.pose(&roads.roads, lane, upstream.max(lane.start).min(lane.end));
            let trigger = trigger(definition).unwrap_or_else(|| OrientedBox::new(pose, half, half));
            found.push(SpeedSign { limit, trigger });
        }
    }
    (found, on_lanes)
}

/// Reads bus stops: the places of signals of type 224.
pub(super) fn bus_stops(context: &mut Context, roads: &Roads, signals: &[Signal]) -> Vec<Point> {
    let stops = signals.iter().filter(|signal| signal.definition.attribute("type") == Some(BUS_STOP));
    let place = |Signal { at, .. }: &Signal| {
        let t = context.number_or_zero(at.node, "t");
        roads.roads[at.road.0 as usize].plan_view.pose(at.s).to_world(Vector::new(0.0, t))
    };
    stops.map(place).collect()
}

/// The limit of a speed sign (m/s): of a signal its value in its unit, or without a value the limit of its subtype; `None` for other elements.
///
/// # Source
/// The German catalogue of signs (VzKat): up to 2017, subtype 51 was 10 km/h, 57 was 70 km/h, and 63 was 130 km/h. Those that no sign of today
/// has are read so; other subtypes are km/h.
pub(super) fn limit(node: Node) -> Option<f64> {
    if node.attribute("type") == Some(SPEED_LIMIT) {
        if let Some(value) = node.attribute("value").and_then(number) {
            let unit = node.attribute("unit").map(str::trim).filter(|unit| !unit.is_empty());
            return in_unit(value, unit.unwrap_or("km/h"));
        }
        return limit_of_subtype(node);
    }
    let name = node.attribute("name")?;
    let limit = name.strip_prefix("Speed_").or_else(|| name.strip_prefix("speed_"))?;
    number(limit).map(|limit| limit / 3.6)
}

/// A limit in some unit that can be one.
fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|limit: &f64| *limit > 0.0 && *limit < 1000.0)
}

/// The limit of a sign's subtype (m/s).
fn limit_of_subtype(node: Node) -> Option<f64> {
    let subtype = node.attribute("subtype").and_then(number)?;
    let old = (51.0..=63.0).contains(&subtype) && subtype != 60.0;
    Some(if old { 10.0 * (subtype - 50.0) / 3.6 } else { subtype / 3.6 })
}

/// Names a value of a speed sign that cannot be used. Some writers have -1 where there is none.
fn note_value(context: &mut Context, sign: Node) {
    let value = sign.attribute("value").unwrap_or_default().trim();
    let is_none = matches!(value, "" | "none") || value.parse() == Ok(-1.0);
    if sign.attribute("type") == Some(SPEED_LIMIT) && !is_none && number(value).is_none() {
        let subtype = limit_of_subtype(sign).map(|limit| metres(limit * 3.6));
        context.warn(sign, OpenDriveProblem::BadSignValue { value: value.chars().take(40).collect(), subtype });
    }
}
