use std::collections::BTreeMap;

use super::layout::Layout;
use super::network::Network;
use super::{Street, TownDesign};
use crate::{FIRST_LIMIT, LaneKind, Road, RoadLink, Shape};

/// A bend, or a turn in a junction, that asks a car at the speed limit for much lateral acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FastBend {
    /// Index into [`TownDesign::streets`]: the street that bends, or from which cars turn.
    pub street: usize,
    pub in_junction: bool,
    /// Radius of the innermost driving lane (m).
    pub radius: f64,
    /// The highest limit at which cars come (m/s).
    pub limit: f64,
    /// Lateral acceleration of a car at the limit in that lane (m/s²).
    pub lateral: f64,
}

impl TownDesign {
    /// For each street of a design that can be built the bend, and the turn in a junction, that asks a car at its limit for the highest lateral
    /// acceleration, if that is above `most` (m/s²): in bends, and in junctions.
    pub fn fast_bends(&self, most: [f64; 2]) -> Vec<FastBend> {
        let layout = Layout::new(self, &mut Vec::new());
        let network = Network::new(self, &layout);
        let limits = self.limits();
        let mut found: BTreeMap<(usize, bool), FastBend> = BTreeMap::new();
        for (index, road) in network.roads.iter().enumerate().filter(|(index, _)| network.edges[*index].is_none()) {
            let Some(radius) = least_radius(road) else { continue };
            let in_junction = network.roads[index].junction.is_some();
            let ends = [road.predecessor, road.successor.filter(|_| !in_junction)];
            let edge = |end: &Option<RoadLink>| match end {
                Some(RoadLink::Road(before, _)) => network.edges[before.0 as usize],
                _ => None,
            };
            for street in ends.iter().filter_map(edge).map(|edge| layout.edges[edge].street) {
                let limit = limits[street];
                let bend = FastBend { street, in_junction, radius, limit, lateral: limit * limit / radius };
                let worst = found.entry((street, in_junction)).or_insert(bend);
                if bend.lateral > worst.lateral {
                    *worst = bend;
                }
            }
        }
        found.into_values().filter(|bend| bend.lateral > most[usize::from(bend.in_junction)]).collect()
    }

    /// The highest limit at which cars come on each street (m/s): its own, or without one the highest of the last signs before it, or
    /// [`FIRST_LIMIT`] where a car has passed none.
    fn limits(&self) -> Vec<f64> {
        let mut limits: Vec<f64> =
            self.streets.iter().map(|street| street.speed_limit.unwrap_or(FIRST_LIMIT)).collect();
        let mut entered: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        for (number, street) in self.streets.iter().enumerate().filter(|(_, street)| street.speed_limit.is_none()) {
            street.begins().iter().for_each(|node| entered[*node].push(number));
        }
        let mut open: Vec<usize> = (0..self.streets.len()).collect();
        while let Some(street) = open.pop() {
            for next in self.streets[street].ends().iter().flat_map(|node| &entered[*node]) {
                if limits[*next] < limits[street] {
                    limits[*next] = limits[street];
                    open.push(*next);
                }
            }
        }
        limits
    }
}

impl Street {
    /// The nodes at which cars can come onto it.
    fn begins(&self) -> &[usize] {
        if self.carriageway.backward > 0 { &self.nodes } else { &self.nodes[..self.nodes.len().saturating_sub(1)] }
    }

    /// The nodes at which cars can leave it.
    fn ends(&self) -> &[usize] {
        if self.carriageway.backward > 0 { &self.nodes } else { self.nodes.get(1..).unwrap_or_default() }
    }
}

/// The least radius of the middle of a driving lane on the arcs of a road (m); `None` without any.
fn least_radius(road: &Road) -> Option<f64> {
    let lanes = &road.sections.first()?.lanes;
    let arcs = road.plan_view.pieces().iter().filter_map(|piece| match piece.shape {
        Shape::Arc(curvature) => Some((curvature, [piece.s, piece.s + piece.length])),
        _ => None,
    });
    // How far to the left of the reference line the middle of each driving lane is, without the offset of all.
    let middle = |id: i32| {
        let inner = lanes.iter().filter(|lane| lane.id.signum() == id.signum() && lane.id.abs() <= id.abs());
        let widths: f64 = inner.map(|lane| lane.width.value(0.0) * if lane.id == id { 0.5 } else { 1.0 }).sum();
        widths * f64::from(id.signum())
    };
    let driving = || lanes.iter().filter(|lane| lane.kind == LaneKind::Driving).map(|lane| middle(lane.id));
    let radii = arcs.flat_map(|(curvature, ends)| {
        let radius = move |(aside, s)| 1.0 / curvature.abs() - curvature.signum() * (aside + road.lane_offset.value(s));
        driving().flat_map(move |aside| ends.map(|s| (aside, s))).map(radius)
    });
    radii.min_by(f64::total_cmp)
}
