use std::collections::BTreeMap;

use super::segment::{Place, Segment};
use crate::geometry::Vector;
use crate::{LaneId, RoadIndex, Town, Waypoint};

/// The index of a node in the graph.
pub(super) type Node = u32;

/// A segment in the graph.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    /// Where it leads.
    pub to: Node,
    /// Its points, both ends included.
    pub places: Vec<Place>,
    /// Whether it starts in a junction.
    pub junction: bool,
    /// Its heading at its end, and the direction from its start to its end; unknown for loose ends.
    pub directions: Option<(Vector, Vector)>,
}

impl Edge {
    fn new(to: Node, segment: Segment, loose: bool) -> Self {
        let (entry, exit) = (segment.entry(), segment.exit());
        let ([x, y, z], [to_x, to_y, to_z]) = (entry.location.widened(), exit.location.widened());
        let (chord, rise) = (Vector::new(to_x - x, to_y - y), to_z - z);
        // A unit vector in space, seen from above.
        let chord = chord / ((chord.norm_squared() + rise * rise).sqrt() + f64::EPSILON);
        let directions = (!loose).then(|| (exit.point.pose.forward(), chord));
        Self { to, junction: entry.point.is_junction, directions, places: segment.places }
    }

    /// The cost of passing it (points).
    pub fn cost(&self) -> f64 {
        (self.places.len() - 1) as f64
    }
}

type LaneKey = (RoadIndex, u32, LaneId);

fn lane_key(waypoint: Waypoint) -> LaneKey {
    (waypoint.road, waypoint.section, waypoint.lane)
}

/// Where segments start and end, and the segments between.
///
/// Two ends in the same cubic metre are one node. Of two segments between the same nodes the later one is kept; in tight
/// junctions the route therefore follows CARLA's graph, not the lanes.
#[derive(Debug, Default)]
pub(super) struct RouteGraph {
    /// The place of each node in whole metres.
    nodes: Vec<[f64; 3]>,
    /// The segments that start at each node, in order of their first appearance.
    edges: Vec<Vec<Edge>>,
    /// The two nodes between which each lane lies.
    lanes: BTreeMap<LaneKey, (Node, Node)>,
}

impl RouteGraph {
    /// Cuts a town into segments with a point every `sampling` (m).
    pub fn new(town: &Town, sampling: f64) -> Self {
        let mut graph = Self::default();
        let mut known = BTreeMap::new();
        let mut exits = Vec::new();
        for (entry, exit) in town.topology() {
            let Some(segment) = Segment::new(town, entry, exit, sampling) else { continue };
            let [from, to] = [segment.entry(), segment.exit()].map(|end| {
                let whole = end.location.whole();
                *known.entry(whole).or_insert_with(|| graph.add_node(whole.map(|metres| metres as f64)))
            });
            exits.push((*segment.exit(), to));
            graph.lanes.insert(lane_key(entry), (from, to));
            graph.put(from, Edge::new(to, segment, false));
        }
        for (exit, from) in exits {
            if graph.lanes.contains_key(&lane_key(exit.point.waypoint)) {
                continue;
            }
            let loose = Segment::loose_end(town, exit, sampling);
            let end = loose.as_ref().map_or(exit.location, |segment| segment.exit().location);
            let to = graph.add_node(end.widened());
            graph.lanes.insert(lane_key(exit.point.waypoint), (from, to));
            if let Some(segment) = loose {
                graph.put(from, Edge::new(to, segment, true));
            }
        }
        graph
    }

    /// Adds a node at a place (m).
    pub fn add_node(&mut self, place: [f64; 3]) -> Node {
        self.nodes.push(place);
        self.edges.push(Vec::new());
        (self.nodes.len() - 1) as Node
    }

    /// Adds a segment, or replaces the one between the same nodes.
    pub fn put(&mut self, from: Node, edge: Edge) {
        let edges = &mut self.edges[from as usize];
        match edges.iter_mut().find(|other| other.to == edge.to) {
            Some(other) => *other = edge,
            None => edges.push(edge),
        }
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The segments that start at a node.
    pub fn edges(&self, node: Node) -> &[Edge] {
        &self.edges[node as usize]
    }

    /// The segment from one node to another.
    pub fn edge(&self, from: Node, to: Node) -> Option<&Edge> {
        self.edges(from).iter().find(|edge| edge.to == to)
    }

    /// The straight line between two nodes (m).
    pub fn distance(&self, a: Node, b: Node) -> f64 {
        let apart = self.nodes[a as usize].iter().zip(self.nodes[b as usize]).map(|(a, b)| (a - b) * (a - b));
        apart.sum::<f64>().sqrt()
    }

    /// The nodes between which the lane of a waypoint lies.
    pub fn ends(&self, waypoint: Waypoint) -> Option<(Node, Node)> {
        self.lanes.get(&lane_key(waypoint)).copied()
    }
}
