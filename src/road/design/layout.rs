use std::f64::consts::{FRAC_PI_6, PI, TAU};

use super::carriageway::Approach;
use super::{Carriageway, DesignError, Street, TownDesign};
use crate::RoadEnd;
use crate::geometry::{Point, wrap_angle};

/// The least angle between two streets (rad).
const MIN_ANGLE: f64 = FRAC_PI_6;
/// Nodes nearer than this lie on one place (m).
const SAME_PLACE: f64 = 0.01;
/// The least length of a road between bends and junctions (m): room for a speed sign and a traffic light.
const MIN_ROAD: f64 = 5.0;
/// Streets in line to within this angle need no bend (rad).
const IN_LINE: f64 = 1e-9;
/// How much more than half the width of a street the radius of its bend is at least (m).
const BEND_MARGIN: f64 = 0.5;
/// The least length of the straight part that a bend replaces (m); it prevents roads of a few millimetres.
const MIN_TANGENT: f64 = 1.0;

/// The straight part of a street between two of its nodes.
#[derive(Debug)]
pub(super) struct Edge {
    pub street: usize,
    /// Start node and end node.
    pub nodes: [usize; 2],
    /// Distance of the nodes (m).
    pub length: f64,
    /// Direction from the first node to the second (rad).
    pub heading: f64,
    /// How much of it the bends and junctions at both nodes take (m).
    pub cuts: [f64; 2],
    /// Whether some length remains between the cuts.
    pub fits: bool,
}

/// One end of an edge, seen from the node there.
#[derive(Debug)]
pub(super) struct Leg {
    pub edge: usize,
    /// The end of the edge that lies at the node.
    pub end: RoadEnd,
    /// Direction away from the node (rad).
    pub heading: f64,
}

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Joint {
    /// A fault, or no street at all.
    Nothing,
    /// A street ends.
    DeadEnd,
    /// A street goes straight on.
    Straight,
    /// A street bends.
    Bend,
    /// Three or four legs meet.
    Junction,
}

/// The design as a graph: edges between nodes, and how much of each the nodes take.
#[derive(Debug)]
pub(super) struct Layout {
    pub edges: Vec<Edge>,
    /// The legs of every node, counter-clockwise.
    pub legs: Vec<Vec<Leg>>,
    pub joints: Vec<Joint>,
}

impl Layout {
    pub fn new(design: &TownDesign, faults: &mut Vec<DesignError>) -> Self {
        let edges = edges(design, faults);
        find_same_places(design, faults);
        find_unused_nodes(design, faults);
        find_crossings(design, &edges, faults);
        let legs = legs(design, &edges);
        let mut layout = Self { edges, legs, joints: Vec::new() };
        for node in 0..design.nodes.len() {
            let joint = layout.joint(design, node, faults);
            if design.nodes[node].lights && layout.legs[node].len() < 3 {
                faults.push(DesignError::LightsWithoutJunction { node: design.nodes[node].name.clone() });
            }
            layout.joints.push(joint);
        }
        layout.cut(design, faults);
        layout
    }

    /// The angle from a leg to the next one counter-clockwise (rad), from 0 to 2π.
    pub fn gap(&self, node: usize, leg: usize) -> f64 {
        let legs = &self.legs[node];
        let next = &legs[(leg + 1) % legs.len()];
        let gap = next.heading - legs[leg].heading;
        if leg + 1 == legs.len() { gap + TAU } else { gap }
    }

    /// The lanes of a leg's street.
    pub fn carriageway(&self, design: &TownDesign, leg: &Leg) -> Carriageway {
        design.streets[self.edges[leg.edge].street].carriageway
    }

    /// The lanes of a leg, seen from its node.
    pub fn approach(&self, design: &TownDesign, leg: &Leg) -> Approach {
        self.carriageway(design, leg).at(leg.end, &design.profile)
    }

    /// The distance from the middle of a leg to the outer edge of its sidewalks (m).
    fn half_width(&self, design: &TownDesign, leg: &Leg) -> f64 {
        self.carriageway(design, leg).street_half_width(&design.profile)
    }

    fn joint(&self, design: &TownDesign, node: usize, faults: &mut Vec<DesignError>) -> Joint {
        let legs = &self.legs[node];
        let mut sound = true;
        if legs.len() > 4 {
            faults.push(DesignError::ManyLegs { node: design.nodes[node].name.clone(), legs: legs.len() });
            sound = false;
        }
        for (index, leg) in legs.iter().enumerate().filter(|_| legs.len() > 1) {
            let gap = self.gap(node, index);
            if gap < MIN_ANGLE - 1e-9 {
                let street = |leg: &Leg| design.streets[self.edges[leg.edge].street].name.clone();
                faults.push(DesignError::SharpAngle {
                    node: design.nodes[node].name.clone(),
                    first: street(leg),
                    second: street(&legs[(index + 1) % legs.len()]),
                    degrees: gap.to_degrees(),
                    least: MIN_ANGLE.to_degrees(),
                });
                sound = false;
            }
        }
        let joint = match legs.len() {
            _ if !sound => Joint::Nothing,
            0 => Joint::Nothing,
            1 => Joint::DeadEnd,
            2 if (self.gap(node, 0) - PI).abs() <= IN_LINE => Joint::Straight,
            2 => Joint::Bend,
            _ => Joint::Junction,
        };
        match self.lane_fault(design, node, joint) {
            Some(fault) => {
                faults.push(fault);
                Joint::Nothing
            }
            None => joint,
        }
    }

    fn lane_fault(&self, design: &TownDesign, node: usize, joint: Joint) -> Option<DesignError> {
        let legs = &self.legs[node];
        let street = |leg: &Leg| design.streets[self.edges[leg.edge].street].name.clone();
        let name = || design.nodes[node].name.clone();
        let approach = |leg: &Leg| self.approach(design, leg);
        match joint {
            Joint::Nothing | Joint::DeadEnd => None,
            Joint::Straight | Joint::Bend => {
                let (first, second) = (approach(&legs[0]), approach(&legs[1]));
                let (node, streets) = (name(), (street(&legs[0]), street(&legs[1])));
                if first.inward + second.inward == 0 || first.outward + second.outward == 0 {
                    return Some(DesignError::OneWayAgainst { node, first: streets.0, second: streets.1 });
                }
                if (first.inward, first.outward) != (second.outward, second.inward) {
                    return Some(DesignError::UnequalLanes { node, first: streets.0, second: streets.1 });
                }
                let needed = self.half_width(design, &legs[0]) + BEND_MARGIN;
                let tight = joint == Joint::Bend && design.bend_radius < needed;
                tight.then_some(DesignError::TightBend { node, street: streets.0, radius: design.bend_radius, needed })
            }
            Joint::Junction => legs.iter().enumerate().find_map(|(index, leg)| {
                let others =
                    || legs.iter().enumerate().filter(move |(other, _)| *other != index).map(|(_, leg)| approach(leg));
                let own = approach(leg);
                let stuck = own.inward > 0 && others().all(|other| other.outward == 0);
                let unreachable = own.outward > 0 && others().all(|other| other.inward == 0);
                (stuck || unreachable).then(|| DesignError::NoWay { node: name(), street: street(leg), stuck })
            }),
        }
    }

    /// Cuts the edges back from bends and junctions.
    fn cut(&mut self, design: &TownDesign, faults: &mut Vec<DesignError>) {
        for node in 0..self.legs.len() {
            for leg in 0..self.legs[node].len() {
                let cut = self.leg_cut(design, node, leg);
                let Leg { edge, end, .. } = self.legs[node][leg];
                self.edges[edge].cuts[usize::from(end == RoadEnd::End)] = cut;
            }
        }
        for edge in &mut self.edges {
            let needed = edge.cuts[0] + edge.cuts[1] + MIN_ROAD;
            edge.fits = edge.length >= needed;
            if !edge.fits {
                faults.push(DesignError::ShortLeg {
                    street: design.streets[edge.street].name.clone(),
                    from: design.nodes[edge.nodes[0]].name.clone(),
                    to: design.nodes[edge.nodes[1]].name.clone(),
                    length: edge.length,
                    needed,
                });
            }
        }
    }

    /// The tangent of half the angle by which a street turns at a bend.
    fn half_turn(&self, node: usize) -> f64 {
        libm::tan(wrap_angle(self.gap(node, 0) - PI).abs() / 2.0)
    }

    /// How far from its node a leg starts (m).
    fn leg_cut(&self, design: &TownDesign, node: usize, leg: usize) -> f64 {
        match self.joints[node] {
            Joint::Nothing | Joint::DeadEnd | Joint::Straight => 0.0,
            Joint::Bend => (design.bend_radius * self.half_turn(node)).max(MIN_TANGENT),
            Joint::Junction => {
                // The outer edges of two neighbouring streets are joined by an arc of the corner's radius, and so the
                // middles by an arc about the same centre. If one street is wider, the arc is that of two such streets.
                let legs = &self.legs[node];
                let count = legs.len();
                let (next, last) = ((leg + 1) % count, (leg + count - 1) % count);
                let half_width =
                    |other: usize| self.half_width(design, &legs[leg]).max(self.half_width(design, &legs[other]));
                [(leg, next), (last, last)]
                    .map(|(side, other)| (self.gap(node, side), half_width(other) + design.corner_radius))
                    .into_iter()
                    .filter(|&(gap, _)| gap < PI)
                    .map(|(gap, radius)| radius / libm::tan(gap / 2.0))
                    .fold(design.junction_radius, f64::max)
            }
        }
    }
}

fn edges(design: &TownDesign, faults: &mut Vec<DesignError>) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (street, Street { name, nodes, .. }) in design.streets.iter().enumerate() {
        if nodes.len() < 2 {
            faults.push(DesignError::ShortStreet { street: name.clone(), nodes: nodes.len() });
        }
        for &node in nodes.iter().filter(|&&node| node >= design.nodes.len()) {
            faults.push(DesignError::UnknownNode { street: name.clone(), node });
        }
        for pair in nodes.windows(2) {
            let (Some(from), Some(to)) = (design.nodes.get(pair[0]), design.nodes.get(pair[1])) else { continue };
            if pair[0] == pair[1] {
                faults.push(DesignError::RepeatedNode { street: name.clone(), node: from.name.clone() });
                continue;
            }
            let way = to.position - from.position;
            // Nodes on one place are a fault of their own; between them there is no direction.
            if way.norm() >= SAME_PLACE {
                let heading = libm::atan2(way.y, way.x);
                let nodes = [pair[0], pair[1]];
                edges.push(Edge { street, nodes, length: way.norm(), heading, cuts: [0.0; 2], fits: true });
            }
        }
    }
    edges
}

fn legs(design: &TownDesign, edges: &[Edge]) -> Vec<Vec<Leg>> {
    let mut legs: Vec<Vec<Leg>> = design.nodes.iter().map(|_| Vec::new()).collect();
    for (index, edge) in edges.iter().enumerate() {
        let back = wrap_angle(edge.heading + PI);
        legs[edge.nodes[0]].push(Leg { edge: index, end: RoadEnd::Start, heading: edge.heading });
        legs[edge.nodes[1]].push(Leg { edge: index, end: RoadEnd::End, heading: back });
    }
    for around in &mut legs {
        around.sort_by(|a, b| a.heading.total_cmp(&b.heading));
    }
    legs
}

fn find_same_places(design: &TownDesign, faults: &mut Vec<DesignError>) {
    for (index, first) in design.nodes.iter().enumerate() {
        for second in &design.nodes[index + 1..] {
            if (first.position - second.position).norm() < SAME_PLACE {
                faults.push(DesignError::SamePlace { first: first.name.clone(), second: second.name.clone() });
            }
        }
    }
}

fn find_unused_nodes(design: &TownDesign, faults: &mut Vec<DesignError>) {
    let mut used = vec![false; design.nodes.len()];
    for &node in design.streets.iter().flat_map(|street| &street.nodes) {
        if let Some(used) = used.get_mut(node) {
            *used = true;
        }
    }
    let unused = design.nodes.iter().zip(used).filter(|(_, used)| !used);
    faults.extend(unused.map(|(node, _)| DesignError::UnusedNode { node: node.name.clone() }));
}

/// Maximum number of reported crossings and overlaps; each pair of streets may have one.
pub(super) const MAX_FAULTS: usize = 100;

fn find_crossings(design: &TownDesign, edges: &[Edge], faults: &mut Vec<DesignError>) {
    let ends = |edge: &Edge| edge.nodes.map(|node| design.nodes[node].position);
    let name = |edge: &Edge| design.streets[edge.street].name.clone();
    for (index, first) in edges.iter().enumerate() {
        for second in &edges[index + 1..] {
            if first.nodes.iter().any(|node| second.nodes.contains(node)) {
                continue;
            }
            if let Some(place) = crossing(ends(first), ends(second)) {
                if faults.len() >= MAX_FAULTS {
                    return;
                }
                faults.push(DesignError::Crossing { first: name(first), second: name(second), x: place.x, y: place.y });
            }
        }
    }
}

/// The point that two line segments have in common; `None` for parallel ones.
fn crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    let (along, across, between) = (b - a, d - c, c - a);
    let area = along.perp(&across);
    if area == 0.0 {
        return None;
    }
    let (t, u) = (between.perp(&across) / area, between.perp(&along) / area);
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)).then(|| a + along * t)
}
