use super::corner::{Side, corner};
use super::layout::{Joint, Layout, Leg};
use super::{Node, StreetProfile, TownDesign};
use crate::geometry::{Pose, Vector};
use crate::road::{
    Connection, Geometry, Junction, JunctionIndex, Lane, LaneId, LaneKind, LaneSection, PlanView, Profile, Road,
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
    /// For every edge its road; none where there is no room for it.
    pub along: Vec<Option<RoadIndex>>,
    /// For every node its junction.
    pub at: Vec<Option<JunctionIndex>>,
}

/// One end of a road.
type Mouth = (RoadIndex, RoadEnd);

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
        let name = &design.streets[edge.street].name;
        let road = self.add_road(name, line, length, street_lanes(&design.profile), edge.nodes);
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
        let (first, second) = (&layout.legs[node][0], &layout.legs[node][1]);
        let (Some(before), Some(after)) = (self.mouth(first), self.mouth(second)) else { return };
        let Node { name, position, .. } = &design.nodes[node];
        let (line, length) = corner(*position, side(layout, first), side(layout, second));
        let bend = self.add_road(name, line, length, street_lanes(&design.profile), [node; 2]);
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
            // Counter-clockwise from the next leg on: the rightmost way comes first, and the sidewalk runs along it.
            for turn in 1..legs.len() {
                let exit = &legs[(from + turn) % legs.len()];
                let Some(outgoing) = self.mouth(exit) else { continue };
                let (line, length) = corner(*position, side(layout, entry), side(layout, exit));
                let lanes = connecting_lanes(&design.profile, turn == 1);
                let connecting = self.add_road(name, line, length, lanes, [node; 2]);
                self.roads[connecting.0 as usize].junction = Some(index);
                let lane_links = self.connect(connecting, incoming, outgoing);
                let connections = &mut self.junctions[number as usize].connections;
                let (id, contact) = (connections.len() as u32, RoadEnd::Start);
                connections.push(Connection { id, incoming: incoming.0, connecting, contact, lane_links });
            }
        }
        index
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

    /// Links a connecting road with the roads before and after it, and gives the pairs of lanes (incoming, connecting).
    fn connect(&mut self, connecting: RoadIndex, incoming: Mouth, outgoing: Mouth) -> Vec<(LaneId, LaneId)> {
        self.link((connecting, RoadEnd::Start), RoadLink::Road(incoming.0, incoming.1));
        self.link((connecting, RoadEnd::End), RoadLink::Road(outgoing.0, outgoing.1));
        self.link_lanes((connecting, RoadEnd::Start), incoming.1);
        self.link_lanes((connecting, RoadEnd::End), outgoing.1);
        let lanes = &self.roads[connecting.0 as usize].sections[0].lanes;
        lanes.iter().filter_map(|lane| Some((lane.predecessor?, lane.id))).collect()
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

fn lane(profile: &StreetProfile, id: LaneId) -> Lane {
    let (kind, width) = match id.abs() {
        0 => (LaneKind::None, 0.0),
        1 => (LaneKind::Driving, profile.lane_width),
        2 => (LaneKind::Shoulder, profile.shoulder),
        _ => (LaneKind::Sidewalk, profile.sidewalk),
    };
    Lane { id, kind, width: Profile::constant(width), predecessor: None, successor: None }
}

fn street_lanes(profile: &StreetProfile) -> Vec<Lane> {
    (-3..=3).rev().map(|id| lane(profile, id)).collect()
}

fn connecting_lanes(profile: &StreetProfile, sidewalk: bool) -> Vec<Lane> {
    let rightmost = if sidewalk { -3 } else { -1 };
    (rightmost..=0).rev().map(|id| lane(profile, id)).collect()
}
