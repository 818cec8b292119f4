//! Polygons by their corners, in order.

use super::Point;

/// Whether a polygon contains a point, by the even-odd rule.
pub fn contains(corners: &[Point], point: Point) -> bool {
    let crossings = edges(corners).filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// The distance of a point from a polygon (m); 0 on it.
pub fn distance(corners: &[Point], point: Point) -> f64 {
    if contains(corners, point) {
        return 0.0;
    }
    let to_edge = |(a, b): (Point, Point)| {
        let (chord, offset) = (b - a, point - a);
        let share = (offset.dot(&chord) / chord.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (offset - chord * share).norm()
    };
    edges(corners).map(to_edge).fold(f64::INFINITY, f64::min)
}

fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}
