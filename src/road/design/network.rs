use std::f64::consts::PI;

use super::carriageway::Approach;
use super::corner::{Side, corner};
use super::layout::{Joint, Layout, Leg};
use super::turning_lanes::{Exit, lane_pairs};
use super::{Carriageway, Node, StreetProfile, TownDesign};
use crate::geometry::{Point, Pose, Vector, wrap_angle};
use crate::{
    Connection, Cubic, Geometry, Junction, JunctionIndex, Lane, LaneId, LaneKind, LaneSection, PlanView, Profile, Road,
    RoadEnd, RoadIndex, RoadLink,
};

/// The roads of a design with their links.
#[derive(Debug, Default)]
pub(super) struct Network {
    pub roads: Vec<Road>,
    pub junctions: Vec<Junction>,
    /// For every road the edge it runs along, none in bends and junctions.
    pub edges: Vec<Option<usize>>,
    /// For every road the nodes at its ends.
    pub nodes: Vec<[usize; 2]>,
    /// For every edge its road; `None` if there is no room for it.
    pub along: Vec<Option<RoadIndex>>,
    /// For every node its junction.
    pub at: Vec<Option<JunctionIndex>>,
}

type Mouth = (RoadIndex, RoadEnd);

/// The way of one lane, or of a sidewalk alone, through a junction.
struct Way {
    /// The road before it, its lanes, and the place of the first lane among them.
    from: (Mouth, Approach, u32),
    /// The same after it.
    to: (Mouth, Approach, u32),
    driving: bool,
    sidewalk: bool,
}

impl Network {
    pub fn new(design: &TownDesign, layout: &Layout) -> Self {
        let mut network = Self::default();
        for edge in 0..layout.edges.len() {
            network.add_street_road(design, layout, edge);
        }
        for node in 0..design.nodes.len() {
            let junction = match layout.joints[node] {
                Joint::Nothing | Joint::DeadEnd => None,
                Joint::Straight => {
                    network.join_in_line(layout, node);
                    None
                }
                Joint::Bend => {
                    network.add_bend(design, layout, node);
                    None
                }
                Joint::Junction => Some(network.add_junction(design, layout, node)),
            };
            network.at.push(junction);
        }
        network
    }

    /// The mouth of a leg's road at its node.
    pub fn mouth(&self, leg: &Leg) -> Option<Mouth> {
        self.along[leg.edge].map(|road| (road, leg.end))
    }

    fn add_street_road(&mut self, design: &TownDesign, layout: &Layout, index: usize) {
        let edge = &layout.edges[index];
        if !edge.fits {
            self.along.push(None);
            return;
        }
        let direction = Vector::new(libm::cos(edge.heading), libm::sin(edge.heading));
        let start = design.nodes[edge.nodes[0]].position + direction * edge.cuts[0];
        let length = edge.length - edge.cuts[0] - edge.cuts[1];
        let line = PlanView::new(vec![Geometry::line(0.0, Pose::new(start.x, start.y, edge.heading), length)]);
        let street = &design.streets[edge.street];
        let lanes = street_lanes(street.carriageway, &design.profile);
        let road = self.add_road(&street.name, line, length, lanes, edge.nodes);
        self.roads[road.0 as usize].lane_offset = constant_offset(street.carriageway.divide(&design.profile));
        self.edges[road.0 as usize] = Some(index);
        self.along.push(Some(road));
    }

    fn join_in_line(&mut self, layout: &Layout, node: usize) {
        let legs = &layout.legs[node];
        if let (Some(first), Some(second)) = (self.mouth(&legs[0]), self.mouth(&legs[1])) {
            self.join(first, second);
        }
    }

    fn add_bend(&mut self, design: &TownDesign, layout: &Layout, node: usize) {
        let (mut first, mut second) = (&layout.legs[node][0], &layout.legs[node][1]);
        if layout.approach(design, first).inward == 0 {
            // The bend of a one-way street leads along it.
            (first, second) = (second, first);
        }
        let approach = layout.approach(design, first);
        let carriageway = Carriageway { forward: approach.inward, backward: approach.outward };
        let (Some(before), Some(after)) = (self.mouth(first), self.mouth(second)) else { return };
        let Node { name, position, .. } = &design.nodes[node];
        let (line, length) = corner(*position, side(layout, first), side(layout, second));
        let bend = self.add_road(name, line, length, street_lanes(carriageway, &design.profile), [node; 2]);
        self.roads[bend.0 as usize].lane_offset = constant_offset(carriageway.divide(&design.profile));
        self.join((bend, RoadEnd::Start), before);
        self.join((bend, RoadEnd::End), after);
    }

    fn add_junction(&mut self, design: &TownDesign, layout: &Layout, node: usize) -> JunctionIndex {
        let number = self.junctions.len() as u32;
        let index = JunctionIndex(number);
        let Node { name, position, .. } = &design.nodes[node];
        self.junctions.push(Junction { id: number, name: name.clone(), connections: Vec::new() });
        let legs = &layout.legs[node];
        for (from, entry) in legs.iter().enumerate() {
            let Some(incoming) = self.mouth(entry) else { continue };
            self.link(incoming, RoadLink::Junction(index));
            let approach = layout.approach(design, entry);
            // Counter-clockwise from the next leg on: the rightmost way comes first, and the sidewalk runs along it.
            let mut exits = Vec::new();
            for leg in (1..legs.len()).map(|turn| &legs[(from + turn) % legs.len()]) {
                let Some(outgoing) = self.mouth(leg) else { continue };
                exits.push((leg, outgoing, layout.approach(design, leg)));
            }
            let open: Vec<_> = exits.iter().filter(|(_, _, exit)| approach.inward > 0 && exit.outward > 0).collect();
            let turns: Vec<Exit> = open
                .iter()
                .map(|(leg, _, exit)| Exit { turn: wrap_angle(leg.heading - entry.heading - PI), lanes: exit.outward })
                .collect();
            let next = exits.first().map(|(_, outgoing, _)| *outgoing);
            let mut has_sidewalk = false;
            for ((leg, outgoing, exit), pairs) in open.into_iter().zip(lane_pairs(approach.inward, &turns)) {
                for (own, other) in pairs {
                    let sidewalk =
                        Some(*outgoing) == next && (own, other) == (approach.inward, exit.outward) && !has_sidewalk;
                    has_sidewalk |= sidewalk;
                    let way =
                        Way { from: (incoming, approach, own), to: (*outgoing, *exit, other), driving: true, sidewalk };
                    self.add_way(design, (*position, name), (side(layout, entry), side(layout, leg)), index, &way);
                }
            }
            if let Some((leg, outgoing, exit)) = exits.first().filter(|_| !has_sidewalk) {
                // No lane leads around this corner.
                let (own, other) = (approach.inward + 1, exit.outward + 1);
                let way = Way {
                    from: (incoming, approach, own),
                    to: (*outgoing, *exit, other),
                    driving: false,
                    sidewalk: true,
                };
                self.add_way(design, (*position, name), (side(layout, entry), side(layout, leg)), index, &way);
            }
        }
        index
    }

    /// Adds the connecting road of a way through a junction.
    fn add_way(
        &mut self,
        design: &TownDesign,
        (position, name): (Point, &str),
        (from, to): (Side, Side),
        junction: JunctionIndex,
        way: &Way,
    ) {
        let ((incoming, entry, own), (outgoing, exit, other)) = (way.from, way.to);
        let (line, length) = corner(position, from, to);
        let (driving, sidewalk) = (u32::from(way.driving), way.sidewalk);
        let lanes = lanes(&[], &beside(&design.profile, driving, sidewalk));
        let node = self.nodes[incoming.0.0 as usize][usize::from(incoming.1 == RoadEnd::End)];
        let connecting = self.add_road(name, line, length, lanes, [node; 2]);
        self.link((connecting, RoadEnd::Start), RoadLink::Road(incoming.0, incoming.1));
        self.link((connecting, RoadEnd::End), RoadLink::Road(outgoing.0, outgoing.1));
        // Seen along the way, the lanes that lead away from the node lie right of the line between the directions, too.
        let left_edge = |divide: f64, place: u32| divide - f64::from(place - 1) * design.profile.lane_width;
        let road = &mut self.roads[connecting.0 as usize];
        road.lane_offset = shift(left_edge(entry.divide, own), left_edge(-exit.divide, other), length);
        road.junction = Some(junction);
        let mut lane_links = Vec::new();
        for (lane, place) in road.sections[0].lanes.iter_mut().filter(|lane| lane.id != 0).zip(0..) {
            let before = entry.inward_lane(own + place);
            (lane.predecessor, lane.successor) = (Some(before), Some(exit.outward_lane(other + place)));
            lane_links.push((before, lane.id));
        }
        let connections = &mut self.junctions[junction.0 as usize].connections;
        let (id, contact) = (connections.len() as u32, RoadEnd::Start);
        connections.push(Connection { id, incoming: incoming.0, connecting, contact, lane_links });
    }

    fn add_road(
        &mut self,
        name: &str,
        plan_view: PlanView,
        length: f64,
        lanes: Vec<Lane>,
        nodes: [usize; 2],
    ) -> RoadIndex {
        let id = self.roads.len() as u32;
        self.roads.push(Road {
            id,
            name: name.to_owned(),
            length,
            junction: None,
            left_hand: false,
            plan_view,
            lane_offset: Profile::default(),
            sections: vec![LaneSection { start: 0.0, end: length, lanes }],
            predecessor: None,
            successor: None,
        });
        self.edges.push(None);
        self.nodes.push(nodes);
        RoadIndex(id)
    }

    fn join(&mut self, first: Mouth, second: Mouth) {
        for (own, other) in [(first, second), (second, first)] {
            self.link(own, RoadLink::Road(other.0, other.1));
            self.link_lanes(own, other.1);
        }
    }

    fn link(&mut self, (road, end): Mouth, to: RoadLink) {
        let road = &mut self.roads[road.0 as usize];
        match end {
            RoadEnd::Start => road.predecessor = Some(to),
            RoadEnd::End => road.successor = Some(to),
        }
    }

    /// Links the lanes at a mouth with those of a road that has this end there.
    fn link_lanes(&mut self, (road, end): Mouth, other: RoadEnd) {
        for lane in self.roads[road.0 as usize].sections[0].lanes.iter_mut().filter(|lane| lane.id != 0) {
            // Two roads head to head have left and right exchanged.
            let linked = Some(if end == other { -lane.id } else { lane.id });
            match end {
                RoadEnd::Start => lane.predecessor = linked,
                RoadEnd::End => lane.successor = linked,
            }
        }
    }
}

fn side(layout: &Layout, leg: &Leg) -> Side {
    Side { heading: leg.heading, cut: layout.edges[leg.edge].cuts[usize::from(leg.end == RoadEnd::End)] }
}

/// A width of each lane from the line between the directions outwards: driving lanes, then perhaps shoulder and sidewalk.
fn beside(profile: &StreetProfile, driving: u32, sidewalk: bool) -> Vec<(LaneKind, f64)> {
    let mut lanes = vec![(LaneKind::Driving, profile.lane_width); driving as usize];
    if sidewalk {
        lanes.extend([(LaneKind::Shoulder, profile.shoulder), (LaneKind::Sidewalk, profile.sidewalk)]);
    }
    lanes
}

/// The lanes of a road from left to right, given outwards on either side.
fn lanes(left: &[(LaneKind, f64)], right: &[(LaneKind, f64)]) -> Vec<Lane> {
    let lane = |id: LaneId, (kind, width)| Lane {
        id,
        kind,
        width: Profile::constant(width),
        limits: Vec::new(),
        predecessor: None,
        successor: None,
    };
    let on_left = (1..).zip(left).map(|(id, each)| lane(id, *each));
    let on_right = (1..).zip(right).map(|(id, each)| lane(-id, *each));
    let mut lanes: Vec<Lane> = on_left.collect();
    lanes.reverse();
    lanes.push(lane(0, (LaneKind::None, 0.0)));
    lanes.extend(on_right);
    lanes
}

fn street_lanes(carriageway: Carriageway, profile: &StreetProfile) -> Vec<Lane> {
    lanes(&beside(profile, carriageway.backward, true), &beside(profile, carriageway.forward, true))
}

/// A lane offset (m) that leads smoothly from one value to another over a length (m).
fn shift(from: f64, to: f64, length: f64) -> Profile {
    let step = to - from;
    if step == 0.0 {
        return constant_offset(from);
    }
    let (c, d) = (3.0 * step / (length * length), -2.0 * step / (length * length * length));
    Profile::new(vec![Cubic { start: 0.0, a: from, b: 0.0, c, d }])
}

fn constant_offset(offset: f64) -> Profile {
    if offset == 0.0 { Profile::default() } else { Profile::constant(offset) }
}
