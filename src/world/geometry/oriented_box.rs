use super::{Point, Pose, Vector};

/// A rectangle with a heading: a car, a building, a parked van.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Centre and heading.
    pub pose: Pose,
    /// Half extents along the heading and across it (m), both positive.
    pub half: Vector,
}

impl OrientedBox {
    /// Makes a box from its centre, heading and half extents (along, across) (m).
    pub fn new(pose: Pose, half_length: f64, half_width: f64) -> Self {
        Self { pose, half: Vector::new(half_length, half_width) }
    }

    /// Makes an axis-parallel box from two opposite corners, in any order.
    pub fn spanning(a: Point, b: Point) -> Self {
        let centre = nalgebra::center(&a, &b);
        let half = (b - a).abs() / 2.0;
        Self::new(Pose::new(centre.x, centre.y, 0.0), half.x, half.y)
    }

    /// The distance from a point to the box (m); 0 inside.
    pub fn distance_to(&self, point: Point) -> f64 {
        let local = self.pose.to_local(point).abs();
        Vector::new((local.x - self.half.x).max(0.0), (local.y - self.half.y).max(0.0)).norm()
    }

    /// Whether two boxes overlap or touch; by separating axes.
    pub fn overlaps(&self, other: &Self) -> bool {
        let offset = other.pose.position() - self.pose.position();
        // Most boxes are too far from each other for any headings.
        if offset.norm() > (self.half.norm() + other.half.norm()) * (1.0 + 1e-9) {
            return false;
        }
        let (ours, theirs) = (self.pose.axes(), other.pose.axes());
        let reach = |axis: &Vector, sides: &[Vector; 2], half: &Vector| {
            half.x * axis.dot(&sides[0]).abs() + half.y * axis.dot(&sides[1]).abs()
        };
        ours.iter()
            .chain(&theirs)
            .all(|axis| offset.dot(axis).abs() <= reach(axis, &ours, &self.half) + reach(axis, &theirs, &other.half))
    }

    /// The shortest vector from this box to another one (m); zero when they overlap or touch.
    pub fn separation(&self, other: &Self) -> Vector {
        if self.overlaps(other) {
            return Vector::zeros();
        }
        // Of two separate boxes, a corner of one is nearest to the other.
        let (there, back) = (self.way_to_corners(other), -other.way_to_corners(self));
        if there.norm_squared() <= back.norm_squared() { there } else { back }
    }

    /// The shortest vector from this box to a corner of another one.
    fn way_to_corners(&self, other: &Self) -> Vector {
        let way = |corner: Point| {
            let local = self.pose.to_local(corner);
            let nearest =
                Vector::new(local.x.clamp(-self.half.x, self.half.x), local.y.clamp(-self.half.y, self.half.y));
            corner - self.pose.to_world(nearest)
        };
        let [first, others @ ..] = other.corners().map(way);
        let shorter = |a: Vector, b: Vector| if b.norm_squared() < a.norm_squared() { b } else { a };
        others.into_iter().fold(first, shorter)
    }

    /// Whether the straight line between two points meets the box; by slabs.
    pub fn is_crossed_by(&self, from: Point, to: Point) -> bool {
        let (start, way) = (self.pose.to_local(from), self.pose.to_local(to) - self.pose.to_local(from));
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            if way[axis] == 0.0 {
                if start[axis].abs() > self.half[axis] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((-self.half[axis] - start[axis]) / way[axis], (self.half[axis] - start[axis]) / way[axis]);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        }
        low <= high
    }

    /// The corners, counter-clockwise from the front left.
    pub fn corners(&self) -> [Point; 4] {
        let (l, w) = (self.half.x, self.half.y);
        let (Pose { x, y, .. }, [ahead, left]) = (self.pose, self.pose.axes());
        let corner = |(l, w)| Point::new(x + ahead.x * l + left.x * w, y + ahead.y * l + left.y * w);
        [(l, w), (-l, w), (-l, -w), (l, -w)].map(corner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_overlap_unless_an_axis_separates_them() {
        let car = OrientedBox::new(Pose::new(0.0, 0.0, 0.0), 2.0, 1.0);
        let turned = |x, y| OrientedBox::new(Pose::new(x, y, std::f64::consts::FRAC_PI_4), 1.0, 1.0);
        assert!(car.overlaps(&turned(3.4, 0.0)) && !car.overlaps(&turned(3.42, 0.0)));
        assert!(!car.overlaps(&turned(2.8, 1.8)), "corner to corner, where axis-parallel bounds overlap");
    }

    #[test]
    fn the_separation_leads_from_side_to_side_or_from_corner_to_corner() {
        let car = OrientedBox::new(Pose::new(0.0, 0.0, 0.0), 2.0, 1.0);
        let at = |x, y, yaw| OrientedBox::new(Pose::new(x, y, yaw), 2.0, 1.0);
        assert_eq!(car.separation(&at(1.0, 1.0, 0.5)), Vector::zeros());
        assert!((car.separation(&at(5.5, 0.5, 0.0)) - Vector::new(1.5, 0.0)).norm() < 1e-12, "side to side");
        assert!((car.separation(&at(7.0, 6.0, 0.0)) - Vector::new(3.0, 4.0)).norm() < 1e-12, "corner to corner");
        let turned = at(0.0, -4.0, std::f64::consts::FRAC_PI_2);
        assert!((car.separation(&turned) - Vector::new(0.0, -1.0)).norm() < 1e-12);
        assert!((turned.separation(&car) - Vector::new(0.0, 1.0)).norm() < 1e-12);
    }

    #[test]
    fn a_line_meets_a_box_or_passes_its_corner() {
        let car = OrientedBox::new(Pose::new(10.0, 0.0, std::f64::consts::FRAC_PI_2), 2.0, 1.0);
        let eye = Point::origin();
        assert!(car.is_crossed_by(eye, Point::new(20.0, 0.0)) && car.is_crossed_by(eye, Point::new(10.0, 1.9)));
        assert!(!car.is_crossed_by(eye, Point::new(8.9, 0.0)), "it ends before the box");
        assert!(!car.is_crossed_by(eye, Point::new(9.0, 2.1)) && !car.is_crossed_by(eye, Point::new(-20.0, 0.0)));
    }

    #[test]
    fn distance_is_zero_inside_and_euclidean_at_corners() {
        let unit = OrientedBox::spanning(Point::new(-1.0, -1.0), Point::new(1.0, 1.0));
        assert_eq!(unit.distance_to(Point::new(0.5, -0.5)), 0.0);
        assert!((unit.distance_to(Point::new(4.0, 5.0)) - 5.0).abs() < 1e-12);
    }
}
