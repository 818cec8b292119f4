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
        let (here, [ahead, left]) = (self.pose.position(), self.pose.axes());
        let way = |corner: Point| {
            let offset = corner - here;
            let local = Vector::new(ahead.dot(&offset), left.dot(&offset));
            let nearest =
                Vector::new(local.x.clamp(-self.half.x, self.half.x), local.y.clamp(-self.half.y, self.half.y));
            corner - (here + ahead * nearest.x + left * nearest.y)
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
