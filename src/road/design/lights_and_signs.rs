use super::TownDesign;
use super::layout::Layout;
use super::network::Network;
use crate::geometry::{OrientedBox, Pose};
use crate::road::{LaneId, RoadEnd, RoadIndex, SpeedSign, TrafficLight};

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

/// Speed signs at the start of both driving lanes of every street with a limit, repeated after each node.
pub(super) fn speed_signs(design: &TownDesign, layout: &Layout, network: &Network) -> Vec<SpeedSign> {
    let half = SIGN_HALF_SIZE * design.profile.lane_width;
    let mut signs = Vec::new();
    for (road, edge) in network.along.iter().zip(&layout.edges) {
        let (Some(road), Some(limit)) = (*road, design.streets[edge.street].speed_limit) else { continue };
        for begin in [RoadEnd::Start, RoadEnd::End] {
            let lane = if begin == RoadEnd::Start { -1 } else { 1 };
            let pose = lane_pose(network, road, lane, begin, SIGN_DISTANCE);
            signs.push(SpeedSign { limit, trigger: OrientedBox::new(pose, half, half) });
        }
    }
    signs
}

/// One traffic light on every approach to a junction with lights; the legs take turns.
pub(super) fn traffic_lights(design: &TownDesign, layout: &Layout, network: &Network) -> Vec<TrafficLight> {
    let half_width = STOP_HALF_WIDTH * design.profile.lane_width;
    let mut lights = Vec::new();
    for (node, legs) in layout.legs.iter().enumerate().filter(|(node, _)| design.nodes[*node].lights) {
        let Some(junction) = network.at[node] else { continue };
        for (turn, leg) in legs.iter().enumerate() {
            let Some((road, end)) = network.mouth(leg) else { continue };
            let lane = if end == RoadEnd::End { -1 } else { 1 };
            let stop = lane_pose(network, road, lane, end, STOP_DISTANCE);
            lights.push(TrafficLight {
                group: network.junctions[junction.0 as usize].id,
                turn: turn as u32,
                turns: legs.len() as u32,
                road,
                stop,
                trigger: OrientedBox::new(stop, STOP_HALF_LENGTH, half_width),
            });
        }
    }
    lights
}

/// The pose on a lane some distance (m) away from one end of its road.
fn lane_pose(network: &Network, road: RoadIndex, lane: LaneId, end: RoadEnd, distance: f64) -> Pose {
    let road = &network.roads[road.0 as usize];
    let s = if end == RoadEnd::Start { distance } else { road.length - distance };
    road.lane_pose(0, lane, s).expect("streets have a driving lane in each direction")
}
