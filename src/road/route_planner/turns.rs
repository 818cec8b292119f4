use super::graph::{Edge, Node, RouteGraph};
use crate::RoadOption;
use crate::geometry::Vector;

/// Turns below this angle are straight on (rad).
const STRAIGHT: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Names the turns along a way through the graph, one segment after the other.
///
/// A junction is named where the route enters it from a road; later segments in the same junction get the same name.
#[derive(Debug, Default)]
pub(super) struct Turns {
    /// The node at which the current junction ends.
    junction_end: Option<Node>,
    previous: Option<RoadOption>,
}

impl Turns {
    /// The option of the segment that starts at the `index`-th node of a way; `None` if the way has no such segment.
    pub fn name(&mut self, graph: &RouteGraph, way: &[Node], index: usize) -> Option<RoadOption> {
        let (here, next) = (*way.get(index)?, *way.get(index + 1)?);
        let ahead = graph.edge(here, next)?;
        let option = match index.checked_sub(1).map(|before| way[before]) {
            None => RoadOption::LaneFollow,
            Some(before) => match (self.junction_end, self.previous) {
                // Node 0 is never remembered: CARLA asks whether the number is positive.
                (Some(end), Some(previous)) if end > 0 && end != before && ahead.junction => previous,
                _ => {
                    self.junction_end = None;
                    let behind = graph.edge(before, here)?;
                    if !behind.junction && ahead.junction {
                        let (end, last) = junction_exit(graph, &way[index..], ahead);
                        self.junction_end = Some(end);
                        let others = graph.edges(here).iter().filter(|edge| edge.to != next);
                        match (behind.directions, last.directions) {
                            (Some((arriving, _)), Some((leaving, _))) => turn(arriving, leaving, others),
                            // CARLA does not store this one.
                            _ => return Some(RoadOption::LaneFollow),
                        }
                    } else {
                        RoadOption::LaneFollow
                    }
                }
            },
        };
        self.previous = Some(option);
        Some(option)
    }
}

/// The last segment of the junction that a way enters, and the node at its end.
fn junction_exit<'a>(graph: &'a RouteGraph, way: &[Node], first: &'a Edge) -> (Node, &'a Edge) {
    let edges = way.windows(2).map_while(|ends| graph.edge(ends[0], ends[1]));
    edges.take_while(|edge| edge.junction).last().map_or((first.to, first), |edge| (edge.to, edge))
}

/// Compares the turn with the directions of the other exits, as seen on arrival.
fn turn<'a>(arriving: Vector, leaving: Vector, others: impl Iterator<Item = &'a Edge>) -> RoadOption {
    let cosine = arriving.dot(&leaving) / (arriving.norm() * leaving.norm());
    if libm::acos(cosine.clamp(-1.0, 1.0)) < STRAIGHT {
        return RoadOption::Straight;
    }
    let others = others.filter_map(|edge| edge.directions);
    let range = others.map(|(_, chord)| arriving.perp(&chord)).fold(None, |range: Option<(f64, f64)>, side| {
        Some(range.map_or((side, side), |(low, high)| (low.min(side), high.max(side))))
    });
    let (rightmost, leftmost) = range.unwrap_or((0.0, 0.0));
    let side = arriving.perp(&leaving);
    if side > leftmost || (side >= rightmost && side > 0.0) { RoadOption::Left } else { RoadOption::Right }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading(degrees: f64) -> Vector {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Vector::new(cos, sin)
    }

    fn exit(degrees: f64) -> Edge {
        Edge { to: 0, places: Vec::new(), junction: true, directions: Some((heading(degrees), heading(degrees))) }
    }

    fn named(leaving: f64, others: &[f64]) -> RoadOption {
        let others: Vec<Edge> = others.iter().map(|degrees| exit(10.0 + degrees)).collect();
        turn(heading(10.0), heading(10.0 + leaving), others.iter())
    }

    #[test]
    fn turns_are_named_by_angle_and_by_the_other_exits() {
        assert_eq!(named(34.0, &[0.0]), RoadOption::Straight);
        assert_eq!(named(36.0, &[0.0]), RoadOption::Left);
        assert_eq!(named(-90.0, &[0.0, 90.0]), RoadOption::Right);
        assert_eq!(named(90.0, &[]), RoadOption::Left);
        assert_eq!(named(-36.0, &[]), RoadOption::Right);
    }

    #[test]
    fn the_leftmost_of_two_exits_to_the_right_is_called_left() {
        assert_eq!(named(-40.0, &[-70.0]), RoadOption::Left);
        assert_eq!(named(40.0, &[60.0]), RoadOption::Right);
        assert_eq!(named(40.0, &[-20.0, 60.0]), RoadOption::Left, "between the others its own side decides");
    }
}
