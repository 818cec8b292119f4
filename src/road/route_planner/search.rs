use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::graph::{Node, RouteGraph};

/// An entry of the queue: a way to a node, and its priority.
struct Candidate {
    priority: f64,
    count: u32,
    node: Node,
    cost: f64,
    parent: Option<Node>,
}

impl Ord for Candidate {
    /// The cheapest entry is the greatest; of equal ones it is the one queued first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.priority.total_cmp(&self.priority).then_with(|| other.count.cmp(&self.count))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// What is known about a node.
#[derive(Clone, Copy, Default)]
struct Known {
    /// Cost of the best way found, and the straight line to the goal.
    queued: Option<(f64, f64)>,
    /// The node before it, once it has been explored; the first node has none.
    explored: Option<Option<Node>>,
}

/// A way from one node to another, both included; `None` if no way leads there.
///
/// A* with costs in points and the straight line in metres. With a point every two metres the line weighs twice as much as
/// the way. The search therefore runs towards the goal and stops at the first way it meets, which need not be the shortest.
///
/// # Source
/// networkx `algorithms/shortest_paths/astar.py`: the order of equal entries, and that a node may be explored again.
pub(super) fn find_way(graph: &RouteGraph, from: Node, to: Node) -> Option<Vec<Node>> {
    let mut known = vec![Known::default(); graph.len()];
    let mut queue = BinaryHeap::new();
    let mut count = 0;
    queue.push(Candidate { priority: 0.0, count, node: from, cost: 0.0, parent: None });
    while let Some(Candidate { node, cost, parent, .. }) = queue.pop() {
        if node == to {
            let mut way = vec![node];
            let mut before = parent;
            while let Some(node) = before {
                way.push(node);
                before = known[node as usize].explored.flatten();
            }
            way.reverse();
            return Some(way);
        }
        let here = &mut known[node as usize];
        if let Some(earlier) = here.explored {
            let worse = here.queued.is_some_and(|(queued, _)| queued < cost);
            if earlier.is_none() || worse {
                continue;
            }
        }
        here.explored = Some(parent);
        for edge in graph.edges(node) {
            let cost = cost + edge.cost();
            let neighbour = &mut known[edge.to as usize];
            let line = match neighbour.queued {
                Some((queued, _)) if queued <= cost => continue,
                Some((_, line)) => line,
                None => graph.distance(edge.to, to),
            };
            neighbour.queued = Some((cost, line));
            count += 1;
            queue.push(Candidate { priority: cost + line, count, node: edge.to, cost, parent: Some(node) });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::client_location::ClientLocation;
    use super::super::graph::Edge;
    use super::super::segment::Place;
    use super::*;
    use crate::geometry::Pose;
    use crate::{RoadIndex, RoadOption, RoutePoint, Waypoint};

    /// Nodes on a small grid and edges of one to three points, so that many ways are equally good.
    fn tangle() -> RouteGraph {
        let mut state: u64 = 12345;
        let mut draw = |range: u64| {
            state = (state * 1_103_515_245 + 12345) % (1 << 31);
            (state >> 16) % range
        };
        let waypoint = Waypoint { road: RoadIndex(0), section: 0, lane: -1, s: 0.0 };
        let option = RoadOption::LaneFollow;
        let point = RoutePoint { waypoint, pose: Pose::default(), lane_width: 4.0, is_junction: false, option };
        let place = Place { point, location: ClientLocation::default() };
        let mut graph = RouteGraph::default();
        for _ in 0..30 {
            let x = draw(10) as f64;
            graph.add_node([x, draw(10) as f64, 0.0]);
        }
        for _ in 0..90 {
            let (from, to) = (draw(30) as Node, draw(30) as Node);
            let places = vec![place; 2 + draw(3) as usize];
            graph.put(from, Edge { to, places, junction: false, directions: None });
        }
        graph
    }

    /// The result of networkx 3.6 on the same graph.
    #[test]
    fn ways_are_those_of_networkx() {
        let graph = tangle();
        assert_eq!(find_way(&graph, 0, 7).unwrap(), [0, 7]);
        assert_eq!(find_way(&graph, 20, 14).unwrap(), [20, 0, 18, 14], "7 points, though 4 would do");
        assert_eq!(find_way(&graph, 5, 18).unwrap(), [5, 8, 29, 3, 18]);
        assert_eq!(find_way(&graph, 25, 1), None);
        assert_eq!(find_way(&graph, 8, 8).unwrap(), [8]);
        // The ways between all pairs, as one number.
        let mut sum: u128 = 0;
        for (from, to) in (0..30).flat_map(|from| (0..30).map(move |to| (from, to))) {
            for node in find_way(&graph, from, to).unwrap_or_default().into_iter().chain([99]) {
                sum = (sum * 31 + u128::from(node)) % ((1 << 61) - 1);
            }
        }
        assert_eq!(sum, 404_817_634_110_220_571);
    }
}
