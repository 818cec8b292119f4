//! Moving along lanes: successors, predecessors, and how lanes are connected.

use super::hash_order::hash_order;
use super::lane_network::{LaneSlot, NetworkLane};
use super::{LaneKind, RoadIndex, RoadLink, Town, Waypoint};

/// CARLA's margin at the ends of lanes (m).
const EPSILON: f64 = 10.0 * f64::EPSILON;

/// Maximum number of lanes that one step may pass through, a guard against lanes without length that lead in circles.
const MAX_LANES: u32 = 4096;

/// Maximum number of lanes in a row that one step may pass through.
const MAX_DEPTH: u32 = 256;

/// The shortest spacing of generated waypoints (m).
const MIN_STEP: f64 = 1e-3;

/// A direction along lanes.
#[derive(Clone, Copy)]
enum Way {
    Ahead,
    Back,
}

impl Town {
    /// Appends the waypoints `distance` (m) ahead in driving direction, one for each branch.
    ///
    /// The distance is counted along reference lines. Nothing is appended if the lanes end before it, or if it is not
    /// positive.
    ///
    /// # Source
    /// CARLA `road/Map.cpp`, `GetNext`.
    pub fn next(&self, waypoint: Waypoint, distance: f64, out: &mut Vec<Waypoint>) {
        if let Some(slot) = self.network.slot(waypoint).filter(|_| distance > 0.0 && waypoint.s.is_finite()) {
            let mut left = MAX_LANES;
            self.walk(slot, waypoint.s, distance, MAX_DEPTH, &mut left, out);
        }
    }

    /// The starts of the lanes that follow a waypoint's lane.
    pub fn successors(&self, waypoint: Waypoint) -> impl Iterator<Item = Waypoint> + '_ {
        let lane = self.network.slot(waypoint).map(|slot| self.network.lane(slot));
        lane.map_or(&[][..], |lane| self.network.next(lane)).iter().map(|slot| {
            let lane = self.network.lane(*slot);
            lane.waypoint(entry(lane, Way::Ahead))
        })
    }

    /// The ends of the lanes that lead to a waypoint's lane.
    pub fn predecessors(&self, waypoint: Waypoint) -> impl Iterator<Item = Waypoint> + '_ {
        let lane = self.network.slot(waypoint).map(|slot| self.network.lane(slot));
        lane.map_or(&[][..], |lane| self.network.previous(lane)).iter().map(|slot| {
            let lane = self.network.lane(*slot);
            lane.waypoint(entry(lane, Way::Back))
        })
    }

    /// The start of a waypoint's lane in driving direction; `None` for a lane that does not exist.
    pub fn lane_start(&self, waypoint: Waypoint) -> Option<Waypoint> {
        let lane = self.network.lane(self.network.slot(waypoint)?);
        Some(lane.waypoint(entry(lane, Way::Ahead)))
    }

    /// Pairs of waypoints: the start of each driving lane of each section with each of its successors, or with its own
    /// end if there is none. The order is that of CARLA's client library for Linux.
    ///
    /// The lanes of a direct junction (OpenDRIVE 1.7) have no connecting roads between them. CARLA knows no such junction, so its topology
    /// ends there. [`Town::next`] and [`Town::successors`] lead on, as the file says.
    ///
    /// # Source
    /// CARLA `road/Map.cpp`, `GenerateTopology`; roads are in a hash table there, lanes are ordered by their numbers.
    pub fn topology(&self) -> Vec<(Waypoint, Waypoint)> {
        let mut pairs = Vec::new();
        for road in hash_order(self.roads.iter().map(|road| road.id)) {
            for (section, number) in self.roads[road].sections.iter().zip(0..) {
                for lane in section.lanes.iter().rev().filter(|lane| lane.kind == LaneKind::Driving) {
                    let slot = self.network.slot_of(RoadIndex(road as u32), number, lane.id);
                    let Some(lane) = slot.map(|slot| self.network.lane(slot)) else { continue };
                    let start = lane.waypoint(entry(lane, Way::Ahead));
                    let before = pairs.len();
                    let next = self.successors(start).filter(|next| !self.is_direct_way(lane, *next));
                    pairs.extend(next.map(|next| (start, next)));
                    if pairs.len() == before {
                        pairs.push((start, lane.waypoint(entry(lane, Way::Back))));
                    }
                }
            }
        }
        pairs
    }

    /// Whether a lane leads to the next one through a direct junction.
    fn is_direct_way(&self, lane: &NetworkLane, next: Waypoint) -> bool {
        let road = &self.roads[lane.road.0 as usize];
        let beyond = if lane.forward() { road.successor } else { road.predecessor };
        next.road != lane.road && matches!(beyond, Some(RoadLink::Junction(_))) && !self.is_junction(next)
    }

    /// Waypoints on all driving lanes, every `step` (m) along each road from its start; `None` for steps below a millimetre.
    ///
    /// # Source
    /// CARLA `road/Map.cpp`, `GenerateWaypoints`.
    pub fn generate_waypoints(&self, step: f64) -> Vec<Waypoint> {
        let mut waypoints = Vec::new();
        if step < MIN_STEP || step.is_nan() {
            return waypoints;
        }
        for (road, index) in self.roads.iter().zip(0..) {
            let mut s = EPSILON;
            // The sum is rounded as CARLA rounds it. If the length is a multiple of the step, this decides about a last waypoint.
            while s < road.length - EPSILON {
                for section in road.sections_at(s) {
                    let lanes = road.sections[section].lanes.iter();
                    let driving = lanes.filter(|lane| lane.kind == LaneKind::Driving && lane.id != 0);
                    waypoints.extend(driving.map(|lane| Waypoint {
                        road: RoadIndex(index),
                        section: section as u32,
                        lane: lane.id,
                        s,
                    }));
                }
                s += step;
            }
        }
        waypoints
    }

    fn walk(&self, slot: LaneSlot, s: f64, distance: f64, depth: u32, left: &mut u32, out: &mut Vec<Waypoint>) {
        let lane = self.network.lane(slot);
        let grows = lane.forward();
        let passed = s - lane.start + EPSILON;
        let remaining = if grows { lane.end - lane.start - passed } else { passed };
        if distance <= remaining {
            let moved = if grows { s + distance - EPSILON } else { s - distance + EPSILON };
            out.push(lane.waypoint(moved));
            return;
        }
        if depth == 0 {
            return;
        }
        let first = out.len();
        for slot in self.network.next(lane) {
            let Some(fewer) = left.checked_sub(1) else { return };
            *left = fewer;
            let middle = out.len();
            self.walk(*slot, entry(self.network.lane(*slot), Way::Ahead), distance - remaining, depth - 1, left, out);
            // CARLA puts the longer of two lists first.
            if out.len() - middle > middle - first {
                out[first..].rotate_left(middle - first);
            }
        }
    }
}

/// Where a lane is entered.
fn entry(lane: &NetworkLane, way: Way) -> f64 {
    let at_start = lane.forward() == matches!(way, Way::Ahead);
    if at_start { lane.start + 10.0 * EPSILON } else { lane.end - 10.0 * EPSILON }
}
