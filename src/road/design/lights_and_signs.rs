use std::f64::consts::{FRAC_PI_4, PI};

use super::TownDesign;
use super::layout::{Layout, Leg};
use super::network::Network;
use crate::geometry::{OrientedBox, Pose, wrap_angle};
use crate::{LaneId, RoadEnd, RoadIndex, SpeedSign, TrafficLight};

/// How far after the start of a driving lane its speed sign takes effect (m).
const SIGN_DISTANCE: f64 = 1.0;
/// Half size of a sign's trigger box, in lane widths.
const SIGN_HALF_SIZE: f64 = 0.35;
/// How far before the end of its lane a traffic light's trigger box lies (m).
const STOP_DISTANCE: f64 = 3.0;
/// Half length of a traffic light's trigger box (m).
const STOP_HALF_LENGTH: f64 = 1.5;
/// Half width of a traffic light's trigger box, in lane widths.
const STOP_HALF_WIDTH: f64 = 0.25;

/// Speed signs at the start of all driving lanes of every street with a limit, repeated after each node.
pub(super) fn speed_signs(design: &TownDesign, layout: &Layout, network: &Network) -> Vec<SpeedSign> {
    let half = SIGN_HALF_SIZE * design.profile.lane_width;
    let mut signs = Vec::new();
    for (road, edge) in network.along.iter().zip(&layout.edges) {
        let (Some(road), Some(limit)) = (*road, design.streets[edge.street].speed_limit) else { continue };
        for begin in [RoadEnd::Start, RoadEnd::End] {
            let approach = design.streets[edge.street].carriageway.at(begin, &design.profile);
            for lane in (1..=approach.outward).map(|place| approach.outward_lane(place)) {
                let pose = lane_pose(network, road, lane, begin, SIGN_DISTANCE);
                signs.push(SpeedSign { limit, trigger: OrientedBox::new(pose, half, half) });
            }
        }
    }
    signs
}

/// A traffic light over each lane that leads to a junction with lights. The legs with such lanes take turns, each alone or with the one opposite to it.
pub(super) fn traffic_lights(design: &TownDesign, layout: &Layout, network: &Network) -> Vec<TrafficLight> {
    let half_width = STOP_HALF_WIDTH * design.profile.lane_width;
    let mut lights = Vec::new();
    for (node, legs) in layout.legs.iter().enumerate().filter(|(node, _)| design.nodes[*node].lights) {
        let Some(junction) = network.at[node] else { continue };
        let approach = |leg: &Leg| layout.approach(design, leg);
        let legs: Vec<&Leg> = legs.iter().filter(|leg| approach(leg).inward > 0).collect();
        let turns = turns(&legs, design.opposite_lights);
        let count = turns.iter().max().map_or(0, |last| last + 1);
        for (turn, leg) in turns.into_iter().zip(legs) {
            let Some((road, end)) = network.mouth(leg) else { continue };
            let approach = approach(leg);
            for lane in (1..=approach.inward).map(|place| approach.inward_lane(place)) {
                let stop = lane_pose(network, road, lane, end, STOP_DISTANCE);
                lights.push(TrafficLight {
                    signal: format!("light_{}", lights.len()),
                    group: network.junctions[junction.0 as usize].id,
                    turn,
                    turns: count,
                    road,
                    stop,
                    trigger: OrientedBox::new(stop, STOP_HALF_LENGTH, half_width),
                });
            }
        }
    }
    lights
}

/// The turn of each leg of a junction. A leg is opposite to another one if the other is the one most nearly in line with it, and the other way
/// round, to within 45 degrees.
fn turns(legs: &[&Leg], opposite: bool) -> Vec<u32> {
    let bend = |a: &Leg, b: &Leg| (wrap_angle(a.heading - b.heading).abs() - PI).abs();
    let partner = |leg: usize| {
        let others = (0..legs.len()).filter(|other| *other != leg);
        let nearest = others.min_by(|a, b| bend(legs[leg], legs[*a]).total_cmp(&bend(legs[leg], legs[*b])));
        nearest.filter(|other| opposite && bend(legs[leg], legs[*other]) < FRAC_PI_4)
    };
    let mut turns: Vec<u32> = Vec::new();
    let mut next = 0;
    for leg in 0..legs.len() {
        let with = partner(leg).filter(|other| *other < leg && partner(*other) == Some(leg));
        turns.push(with.map_or(next, |other| turns[other]));
        next += u32::from(with.is_none());
    }
    turns
}

/// The pose on a lane some distance (m) away from one end of its road.
fn lane_pose(network: &Network, road: RoadIndex, lane: LaneId, end: RoadEnd, distance: f64) -> Pose {
    let road = &network.roads[road.0 as usize];
    let s = if end == RoadEnd::Start { distance } else { road.length - distance };
    road.lane_pose(0, lane, s).expect("the lane is one of its street")
}
