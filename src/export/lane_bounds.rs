use road::geometry::Point;
use road::{Town, Waypoint};

/// The left and the right edge of a lane over the length of its section, in the direction of the reference line.
///
/// Both have the same number of points, at most `step` apart along the reference line (m).
pub(super) fn lane_bounds(town: &Town, lane: Waypoint, step: f64) -> [Vec<Point>; 2] {
    let section = &town.roads[lane.road.0 as usize].sections[lane.section as usize];
    let length = section.end - section.start;
    let count = (length / step).ceil().max(1.0);
    let mut bounds: [Vec<Point>; 2] = [Vec::new(), Vec::new()];
    for index in 0..=count as u32 {
        let s = section.start + length * f64::from(index) / count;
        for (bound, edge) in bounds.iter_mut().zip(town.lane_edges(Waypoint { s, ..lane }).into_iter().flatten()) {
            bound.push(edge);
        }
    }
    bounds
}
