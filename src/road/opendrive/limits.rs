//! Speed limits of lanes and of road types.

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, Counted, child, children};
use crate::lane_index::{LaneIndex, Lanes};
use crate::lane_network::{LaneNetwork, LaneSlot};
use crate::{LaneFilter, LaneSection, Road, SpeedSign, TownParts};

/// What stands for "no limit" (m/s): 130 km/h, the speed that is recommended on German motorways without a limit.
const NO_LIMIT: f64 = 130.0 / 3.6;
/// Greater limits are mistakes (m/s).
const MAX_LIMIT: f64 = 150.0;
/// Limits below this, and above the speed of a road without one, are named: most come from a wrong unit (m/s).
pub(super) const LOW_LIMIT: f64 = 10.0 / 3.6;

/// Where each limit begins along the road (m), in order, and what it is (m/s); `None` if it is undefined.
pub(super) type Limits = Vec<(f64, Option<f64>)>;

/// Reads the limits of the types of a road; empty where signs alone count.
pub(super) fn of_types(context: &mut Context, road: Node) -> Limits {
    if context.only_signs_limit {
        return Limits::new();
    }
    let mut limits: Limits = children(road, "type")
        .map(|node| {
            let limit = child(node, "speed").and_then(|speed| limit(context, speed));
            (context.number_or_zero(node, "s"), limit)
        })
        .collect();
    limits.sort_by(|a, b| a.0.total_cmp(&b.0));
    limits
}

/// Reads the limits of a lane from the start of its section to its end (m): its own ones, and those of the road's types where it has none.
///
/// # Source
/// ASAM OpenDRIVE, "Speed limits of lanes": the limit of a lane overrules that of the road's type.
pub(super) fn of_lane(context: &mut Context, lane: Node, (start, end): (f64, f64), types: &Limits) -> Limits {
    if context.only_signs_limit {
        return Limits::new();
    }
    let mut own: Limits = children(lane, "speed")
        .map(|node| (start + context.number_or_zero(node, "sOffset"), limit(context, node)))
        .collect();
    own.sort_by(|a, b| a.0.total_cmp(&b.0));
    let changes = own.iter().chain(types).map(|(s, _)| *s).filter(|s| *s > start && *s < end);
    let mut places: Vec<f64> = std::iter::once(start).chain(changes).collect();
    places.sort_by(f64::total_cmp);
    let mut limits: Limits = places.into_iter().map(|s| (s, at(&own, s).or_else(|| at(types, s)))).collect();
    limits.dedup_by(|next, last| next.1 == last.1);
    if limits.iter().all(|(_, limit)| limit.is_none()) { Limits::new() } else { limits }
}

/// The limit at a place (m).
fn at(limits: &[(f64, Option<f64>)], s: f64) -> Option<f64> {
    limits.iter().rev().find(|(begin, _)| *begin <= s).and_then(|(_, limit)| *limit)
}

/// The limit of a `speed` element (m/s); `None` if it is undefined, and none with a warning if it cannot be used.
fn limit(context: &mut Context, speed: Node) -> Option<f64> {
    let text = speed.attribute("max")?;
    match text.trim() {
        "no limit" => return Some(NO_LIMIT),
        "undefined" => return None,
        _ => {}
    }
    let number = context.optional(speed, "max")?;
    let unit = speed.attribute("unit").map(str::trim).filter(|unit| !unit.is_empty()).unwrap_or("m/s");
    let Some(limit) = in_unit(number, unit) else {
        context.warn(speed, OpenDriveProblem::UnknownUnit { unit: unit.chars().take(40).collect() });
        return None;
    };
    let usable = limit > 0.0 && limit <= MAX_LIMIT;
    if !usable {
        context.bad(speed, "max", text);
    }
    note_odd(context, speed, limit);
    usable.then_some(limit)
}

/// A speed in a unit of OpenDRIVE (m/s); `None` for other units.
pub(super) fn in_unit(number: f64, unit: &str) -> Option<f64> {
    match unit {
        "m/s" => Some(number),
        "km/h" => Some(number / 3.6),
        "mph" => Some(number * 0.44704),
        _ => None,
    }
}

/// Names a limit (m/s) that is lower or higher than those of roads.
pub(super) fn note_odd(context: &mut Context, node: Node, limit: f64) {
    if limit > 0.0 && limit <= MAX_LIMIT && !(LOW_LIMIT - 1e-9..=NO_LIMIT + 1e-9).contains(&limit) {
        context.count(node, Counted::OddLimit, format!("{:.1}", limit * 3.6));
    }
}

/// Adds a speed sign to a town. Where its map has limits of lanes or road types, it overrules those of the lane beside it, as the signs of the map do.
pub fn add_speed_sign(parts: &mut TownParts, sign: SpeedSign) {
    let network = LaneNetwork::new(&parts.roads, &parts.junctions);
    let lanes = Lanes { roads: &parts.roads, network: &network };
    let beside = LaneIndex::default().nearest(lanes, sign.trigger.pose.position(), LaneFilter::Driving);
    let place = beside.and_then(|lane| Some((sign.limit, network.slot(lane)?, lane.s)));
    follow_signs(&mut parts.roads, &network, place.into_iter().collect());
    parts.speed_signs.push(sign);
}

/// Lets speed signs overrule the limits of their lanes: from the sign to the end of its road, or to the next sign. A sign is a limit (m/s), a lane
/// and a place along the road (m). Maps without limits of lanes and types stay as they are: there a car keeps the limit of the last sign.
///
/// # Source
/// ASAM OpenDRIVE, "Speed limits": limits of signals take precedence. That a sign ends with its road is our own, for want of a rule.
pub(super) fn follow_signs(roads: &mut [Road], network: &LaneNetwork, mut signs: Vec<(f64, LaneSlot, f64)>) {
    if !roads.iter().flat_map(|road| &road.sections).any(LaneSection::has_limits) {
        return;
    }
    // In driving order, so that a later sign overrules an earlier one.
    let along = |(_, slot, s): &(f64, LaneSlot, f64)| if network.lane(*slot).forward() { *s } else { -*s };
    signs.sort_by(|a, b| along(a).total_cmp(&along(b)));
    for (limit, slot, s) in signs {
        let (mut slot, mut from, road) = (slot, Some(s), network.lane(slot).road);
        loop {
            let lane = network.lane(slot);
            let (start, end) = match (from.take(), lane.forward()) {
                (Some(s), true) => (s, lane.end),
                (Some(s), false) => (lane.start, s),
                (None, _) => (lane.start, lane.end),
            };
            let section = &mut roads[road.0 as usize].sections[lane.section as usize];
            if let Some(own) = section.lanes.iter_mut().find(|own| own.id == lane.id) {
                let after = at(&own.limits, end);
                own.limits.retain(|(begin, _)| *begin < start || *begin >= end);
                own.limits.push((start, Some(limit)));
                if end < lane.end && !own.limits.iter().any(|(begin, _)| *begin == end) {
                    own.limits.push((end, after));
                }
                own.limits.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            let next = network.next(lane).iter().find(|next| {
                let next = network.lane(**next);
                next.road == road && next.section != lane.section && next.forward() == lane.forward()
            });
            let Some(next) = next else { break };
            slot = *next;
        }
    }
}
