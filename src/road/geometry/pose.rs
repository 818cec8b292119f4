use serde::{Deserialize, Serialize};

use super::{Point, Vector, wrap_angle};

/// A place and a heading in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// Position east (m).
    pub x: f64,
    /// Position north (m).
    pub y: f64,
    /// Heading (rad), counter-clockwise from `+x`, in (−π, π].
    pub yaw: f64,
}

/// From x, y (m) and heading (rad).
impl From<[f64; 3]> for Pose {
    fn from([x, y, yaw]: [f64; 3]) -> Self {
        Self::new(x, y, yaw)
    }
}

impl Pose {
    /// Makes a pose, wrapping the heading.
    pub fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self { x, y, yaw: wrap_angle(yaw) }
    }

    /// The pose at a share of the way to another: on a line, turning the shorter way.
    pub fn between(&self, next: &Self, share: f64) -> Self {
        let place = self.position() + (next.position() - self.position()) * share;
        Self::new(place.x, place.y, self.yaw + wrap_angle(next.yaw - self.yaw) * share)
    }

    /// The place without the heading.
    pub fn position(&self) -> Point {
        Point::new(self.x, self.y)
    }

    /// The unit vector along the heading.
    pub fn forward(&self) -> Vector {
        self.axes()[0]
    }

    /// The unit vector to the left of the heading.
    pub fn left(&self) -> Vector {
        self.axes()[1]
    }

    /// The unit vectors along the heading and to the left of it.
    pub fn axes(&self) -> [Vector; 2] {
        let (sin, cos) = libm::sincos(self.yaw);
        [Vector::new(cos, sin), Vector::new(-sin, cos)]
    }

    /// A point of this pose's own frame (`x` ahead, `y` to the left) in the world.
    pub fn to_world(&self, local: Vector) -> Point {
        let (sin, cos) = libm::sincos(self.yaw);
        Point::new(self.x + cos * local.x - sin * local.y, self.y + sin * local.x + cos * local.y)
    }

    /// A point of the world in this pose's own frame: `x` ahead, `y` to the left (m).
    pub fn to_local(&self, point: Point) -> Vector {
        let (sin, cos) = libm::sincos(self.yaw);
        let (dx, dy) = (point.x - self.x, point.y - self.y);
        Vector::new(cos * dx + sin * dy, -sin * dx + cos * dy)
    }

    /// The bearing of a point from the heading (rad), positive to the left, in (−π, π].
    pub fn bearing_to(&self, point: Point) -> f64 {
        let local = self.to_local(point);
        libm::atan2(local.y, local.x)
    }
}
