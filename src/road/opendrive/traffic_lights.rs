use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::attributes::{Context, children};
use super::junctions::Junctions;
use super::roads::Roads;
use super::signals::Signal;
use crate::geometry::OrientedBox;
use crate::lane_network::{LaneNetwork, LaneSlot};
use crate::{JunctionIndex, TrafficLight};

/// The signal types of traffic lights for vehicles: with three lamps, red and yellow, yellow and green, three lamps with an arrow.
///
/// # Source
/// The catalogue of OpenDRIVE 1.4, appendix "Signal types", and CARLA `road/SignalType.cpp`, `IsTrafficLight`.
const LIGHTS: [&str; 4] = ["1000001", "1000009", "1000010", "1000011"];
/// How far before the end of the approach lane the trigger box's centre is (m).
const BEFORE_END: f64 = 3.0;
/// A signal at least this far before the end of its lane stops cars where it stands, as at a crosswalk (m). CARLA puts each at the end.
const MIDWAY: f64 = 20.0;
/// Half the length of the trigger box (m).
const HALF_LENGTH: f64 = 1.5;
/// Half the width of the trigger box, as a share of the lane's width.
const HALF_WIDTH: f64 = 0.25;
/// Maximum number of lanes of a junction between a signal and the approach lane.
const MAX_LANES: usize = 64;

/// A signal that applies to an approach lane.
struct Approach<'a> {
    signal: &'a str,
    slot: LaneSlot,
    /// The place of the signal along the road of its lane (m); `None` in a junction and in CARLA's maps.
    s: Option<f64>,
    junction: Option<JunctionIndex>,
}

/// Reads traffic lights: for each signal one on each lane that leads to the lanes it applies to.
pub(super) fn read<'a, 'x: 'a>(
    context: &mut Context,
    root: Node<'a, 'x>,
    roads: &Roads<'a, 'x>,
    junctions: &Junctions<'a>,
    network: &LaneNetwork,
    signals: &[Signal<'a, 'x>],
) -> Vec<TrafficLight> {
    let mut approaches: Vec<Approach> = Vec::new();
    let (mut known, mut used, mut lost) = (BTreeSet::new(), BTreeSet::new(), BTreeMap::new());
    for Signal { at, .. } in signals.iter().filter(|signal| is_light(signal.definition)) {
        let signal = at.node.attribute("id").unwrap_or_default();
        let junction = roads.roads[at.road.0 as usize].junction;
        let s = (junction.is_none() && !context.of_carla).then_some(at.s);
        lost.entry(signal).or_insert(at.node);
        for slot in at.lanes.iter().flat_map(|slot| before_junction(network, *slot)) {
            used.insert(signal);
            if known.insert((signal, slot)) {
                approaches.push(Approach { signal, slot, s, junction });
            }
        }
    }
    for (signal, node) in lost.into_iter().filter(|(signal, _)| !used.contains(signal)) {
        context.not_used(node, format!("traffic light {signal} beside no driving lane"));
    }
    group(root, &approaches, junctions)
        .into_iter()
        .zip(&approaches)
        .map(|(place, approach)| light(roads, network, place, approach))
        .collect()
}

/// Whether a signal is a traffic light for vehicles that works.
pub(super) fn is_light(node: Node) -> bool {
    node.attribute("type").is_some_and(|kind| LIGHTS.contains(&kind)) && node.attribute("dynamic") != Some("no")
}

/// Group, turn and turns of a light.
type Place = (u32, u32, u32);

/// The controllers of a junction take turns; signals without a controller, or without a junction, have their turns after them. Such
/// signals of one approach lane have the same turn: a car meets all of them at once.
fn group(root: Node, approaches: &[Approach], junctions: &Junctions) -> Vec<Place> {
    let mut controller_of: BTreeMap<&str, &str> = BTreeMap::new();
    for controller in children(root, "controller") {
        for control in children(controller, "control") {
            if let (Some(signal), Some(id)) = (control.attribute("signalId"), controller.attribute("id")) {
                controller_of.entry(signal).or_insert(id);
            }
        }
    }
    let home = |controller: &str| junctions.controllers.iter().position(|listed| listed.contains(&controller));
    let mut turns: Vec<Vec<&str>> = junctions.controllers.clone();
    let loose = turns.len();
    turns.push(Vec::new());
    let mut places = Vec::new();
    let mut first: BTreeMap<LaneSlot, &str> = BTreeMap::new();
    for approach in approaches {
        let controller = controller_of.get(approach.signal).copied();
        let name = controller.unwrap_or_else(|| first.entry(approach.slot).or_insert(approach.signal));
        let junction = home(name).or(approach.junction.map(|index| index.0 as usize));
        let group = junction.unwrap_or(loose);
        let turn = turns[group].iter().position(|known| *known == name).unwrap_or_else(|| {
            turns[group].push(name);
            turns[group].len() - 1
        });
        places.push((group, turn));
    }
    places.into_iter().map(|(group, turn)| (group as u32, turn as u32, turns[group].len() as u32)).collect()
}

fn light(roads: &Roads, network: &LaneNetwork, (group, turn, turns): Place, approach: &Approach) -> TrafficLight {
    let lane = network.lane(approach.slot);
    let (_, end) = lane.driving_ends();
    let s = if lane.forward() { end - BEFORE_END } else { end + BEFORE_END };
    let s = approach.s.filter(|own| (own - end).abs() >= MIDWAY).unwrap_or(s).max(lane.start).min(lane.end);
    let stop = network.pose(&roads.roads, lane, s);
    let trigger = OrientedBox::new(stop, HALF_LENGTH, HALF_WIDTH * network.width(lane, s).max(0.0));
    TrafficLight { signal: approach.signal.to_owned(), group, turn, turns, road: lane.road, stop, trigger }
}

/// The lanes outside junctions that lead to a lane; the lane itself if it is outside.
pub(super) fn before_junction(network: &LaneNetwork, slot: LaneSlot) -> Vec<LaneSlot> {
    let mut seen = vec![slot];
    let mut outside = Vec::new();
    let mut place = 0;
    while place < seen.len() && seen.len() < MAX_LANES {
        let lane = network.lane(seen[place]);
        if lane.in_junction {
            for before in network.previous(lane) {
                if !seen.contains(before) {
                    seen.push(*before);
                }
            }
        } else {
            outside.push(seen[place]);
        }
        place += 1;
    }
    outside
}
