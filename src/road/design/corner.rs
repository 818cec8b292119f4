use std::f64::consts::PI;

use crate::geometry::{Point, Pose, Vector, wrap_angle};
use crate::{Geometry, PlanView};

/// Turns smaller than this are a kink between two lines (rad): an arc of so large a radius loses its digits.
const KINK: f64 = 1e-5;

/// One side of a corner: a direction away from the node (rad), and the distance from the node (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub heading: f64,
    pub cut: f64,
}

impl Side {
    fn place(&self, node: Point, distance: f64) -> Point {
        node + Vector::new(libm::cos(self.heading), libm::sin(self.heading)) * distance
    }
}

/// The way from one side of a node to another: an arc tangent to both, with a line before or after it where one side
/// reaches farther out. Gives also its length (m).
pub(super) fn corner(node: Point, from: Side, to: Side) -> (PlanView, f64) {
    let inward = from.heading + PI;
    let turn = wrap_angle(to.heading - inward);
    let tangent = if turn.abs() < KINK { 0.0 } else { from.cut.min(to.cut) };
    let mut pieces = Vec::new();
    let mut length = 0.0;
    if from.cut > tangent {
        let start = from.place(node, from.cut);
        pieces.push(Geometry::line(length, Pose::new(start.x, start.y, inward), from.cut - tangent));
        length += from.cut - tangent;
    }
    if tangent > 0.0 {
        let start = from.place(node, tangent);
        let curvature = libm::tan(turn / 2.0) / tangent;
        pieces.push(Geometry::arc(length, Pose::new(start.x, start.y, inward), turn / curvature, curvature));
        length += turn / curvature;
    }
    if to.cut > tangent {
        let start = to.place(node, tangent);
        pieces.push(Geometry::line(length, Pose::new(start.x, start.y, to.heading), to.cut - tangent));
        length += to.cut - tangent;
    }
    (PlanView::new(pieces), length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_a_line_and_a_quarter_circle() {
        let (east, north) = (Side { heading: 0.0, cut: 30.0 }, Side { heading: PI / 2.0, cut: 20.0 });
        let (plan, length) = corner(Point::new(5.0, 5.0), east, north);
        assert!((length - (10.0 + 10.0 * PI)).abs() < 1e-12);
        let middle = plan.pose(10.0 + 5.0 * PI).position();
        let centre = Point::new(25.0, 25.0);
        assert!(((middle - centre).norm() - 20.0).abs() < 1e-12);
        assert!((plan.pose(length).position() - Point::new(5.0, 25.0)).norm() < 1e-12);
    }
}
