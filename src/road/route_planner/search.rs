use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::graph::{Node, RouteGraph};

/// An entry of the queue: a way to a node, and what it is worth looking at.
struct Candidate {
    priority: f64,
    count: u32,
    node: Node,
    cost: f64,
    parent: Option<Node>,
}

impl Ord for Candidate {
    /// The cheapest is the greatest, and of equals the one queued first.
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

/// What is known of a node.
#[derive(Clone, Copy, Default)]
struct Known {
    /// Cost of the best way so far, and the straight line to the goal.
    queued: Option<(f64, f64)>,
    /// The node before it, once it has been looked at; the beginning has none.
    explored: Option<Option<Node>>,
}

/// A way from one node to another, both included; none where no way leads.
///
/// A* with costs in points and the straight line in metres. With a point every two metres the line weighs twice as much as
/// the way, so the search runs towards the goal and stops at the first way it meets, which need not be the shortest.
///
/// # Source
/// networkx `algorithms/shortest_paths/astar.py`: the order among equals, and that a node may be looked at again.
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
