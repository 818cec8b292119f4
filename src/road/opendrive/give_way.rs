//! Stop and yield signs, and the places at which cars heed them.

use std::collections::{BTreeMap, BTreeSet};

use super::attributes::{Context, child};
use super::placed::driving_lanes;
use super::roads::Roads;
use super::signals::Signal;
use super::traffic_lights::before_junction;
use crate::geometry::wrap_angle;
use crate::lane_network::{LaneNetwork, LaneSlot};
use crate::{GiveWay, GiveWaySign, TrafficLight};

/// A light is one of the sign's lane if it stops cars this near to the sign's line (m).
const SAME_STOP: f64 = 15.0;

/// Reads stop and yield signs: for each lane to which one applies the line at which a car stops or slows down. Of several on a lane the last one
/// counts.
///
/// The line is beside the sign. For a sign inside a junction it is the end of each lane that leads there. A sign applies to the lanes of its
/// validities, otherwise to those of its orientation, and in CARLA's maps or without one to those on its side of the road.
///
/// # Source
/// The catalogue of OpenDRIVE 1.4, appendix "Signal types": 206 and 205, as in the German road traffic regulations.
pub(super) fn read(
    context: &mut Context,
    roads: &Roads,
    network: &LaneNetwork,
    signals: &[Signal],
    lights: &[TrafficLight],
) -> Vec<GiveWaySign> {
    let mut lines: BTreeMap<LaneSlot, (GiveWay, f64)> = BTreeMap::new();
    let (mut placed, mut read) = (BTreeSet::new(), Vec::new());
    for Signal { definition, at } in signals {
        let Some(kind) = definition.attribute("type").and_then(GiveWay::of_signal) else { continue };
        read.push((*definition, kind));
        let road = &roads.roads[at.road.0 as usize];
        let t = context.number_or_zero(at.node, "t");
        let directed = !context.of_carla && matches!(at.node.attribute("orientation"), Some("+" | "-"));
        let lanes = if directed || child(at.node, "validity").is_some() {
            at.lanes.clone()
        } else {
            driving_lanes(network, road, at.road, at.s, |id| t == 0.0 || (id > 0) == (t > 0.0))
        };
        for slot in lanes {
            placed.insert(definition.range().start);
            let inside = network.lane(slot).in_junction;
            let approaches = if inside { before_junction(network, slot) } else { vec![slot] };
            for slot in approaches {
                let lane = network.lane(slot);
                let s = if inside { lane.driving_ends().1 } else { at.s.max(lane.start).min(lane.end) };
                let line = lines.entry(slot).or_insert((kind, s));
                line.0 = line.0.min(kind);
                line.1 = if lane.forward() { line.1.max(s) } else { line.1.min(s) };
            }
        }
    }
    for (sign, kind) in read.iter().filter(|(sign, _)| !placed.contains(&sign.range().start)) {
        context.not_used(*sign, format!("{} sign beside no driving lane", kind.name()));
    }
    let sign = |(slot, (kind, s)): (LaneSlot, (GiveWay, f64))| {
        let lane = network.lane(slot);
        let pose = network.pose(&roads.roads, lane, s);
        let has_light = lights.iter().any(|light| {
            let near = (light.stop.position() - pose.position()).norm() <= SAME_STOP;
            near && light.road == lane.road && wrap_angle(light.stop.yaw - pose.yaw).abs() < 1.0
        });
        GiveWaySign { kind, line: lane.waypoint(s), has_light }
    };
    lines.into_iter().map(sign).collect()
}
