use road::geometry::{Point, Pose};

/// A location in the form of CARLA's client: left-handed, 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Location {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

impl Location {
    /// Converts from the world frame; `height` is above the ground (m).
    pub fn new(place: Point, height: f64) -> Self {
        Self { x: place.x as f32, y: -place.y as f32, z: height as f32 }
    }

    /// The distance as CARLA's C++ computes it, in 32 bits (m).
    pub fn distance(self, other: Self) -> f64 {
        let (x, y, z) = (other.x - self.x, other.y - self.y, other.z - self.z);
        f64::from((x * x + y * y + z * z).sqrt())
    }

    /// The distance as CARLA's Python computes it, in 64 bits (m).
    pub fn exact_distance(self, other: Self) -> f64 {
        let (x, y) = self.offset(other);
        let z = f64::from(other.z) - f64::from(self.z);
        (x * x + y * y + z * z).sqrt() + f64::EPSILON
    }

    /// The planar offset to another location, from 32-bit coordinates in 64 bits (m).
    pub fn offset(self, other: Self) -> (f64, f64) {
        (f64::from(other.x) - f64::from(self.x), f64::from(other.y) - f64::from(self.y))
    }

    /// Moves by `length` along a direction; the product is computed in 64 bits, the sum in 32.
    pub fn moved(self, direction: Direction, length: f64) -> Self {
        let along = |component: f32| (length * f64::from(component)) as f32;
        Self { x: self.x + along(direction.x), y: self.y + along(direction.y), z: self.z }
    }
}

/// A unit vector in the form of CARLA's client; rounding makes it up to a few 1e-8 longer or shorter than 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Direction {
    pub x: f32,
    pub y: f32,
}

impl Direction {
    /// The heading of a pose.
    pub fn new(pose: &Pose) -> Self {
        let radians = yaw_degrees(pose) * (std::f32::consts::PI / 180.0);
        let (sin, cos) = libm::sincos(f64::from(radians));
        Self { x: cos as f32, y: sin as f32 }
    }

    /// The direction to its right.
    pub fn right(self) -> Self {
        Self { x: -self.y, y: self.x }
    }

    /// Its components in 64 bits.
    pub fn widened(self) -> (f64, f64) {
        (f64::from(self.x), f64::from(self.y))
    }
}

/// The heading of a pose computed in 64 bits from CARLA's 32-bit yaw.
pub(super) fn exact_heading(pose: &Pose) -> (f64, f64) {
    let (sin, cos) = libm::sincos(f64::from(yaw_degrees(pose)).to_radians());
    (cos, sin)
}

fn yaw_degrees(pose: &Pose) -> f32 {
    -pose.yaw.to_degrees() as f32
}

/// A cone with its tip at a location, for obstacles and lights. Locations exactly dead ahead are outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cone {
    pub tip: Location,
    /// Where it points.
    pub heading: (f64, f64),
    /// Its planar reach (m).
    pub reach: f64,
    /// Cosine of half its opening.
    pub cosine: f64,
}

impl Cone {
    /// Whether it contains a location, in the plane. It always contains a location at its tip.
    ///
    /// The cosine is not normalised by the heading's length, which makes the hollow middle up to 0.016° wide.
    pub fn holds(&self, location: Location) -> bool {
        let (x, y) = self.tip.offset(location);
        let distance = (x * x + y * y).sqrt();
        if distance < 0.001 {
            return true;
        }
        let cosine = (self.heading.0 * x + self.heading.1 * y) / distance;
        distance <= self.reach && cosine > self.cosine && cosine < 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_left_handed() {
        let north = Pose::new(3.0, 4.0, std::f64::consts::FRAC_PI_2);
        assert_eq!(Location::new(north.position(), 0.9), Location { x: 3.0, y: -4.0, z: 0.9 });
        let heading = Direction::new(&north);
        assert!(heading.y < -0.999_999 && heading.x.abs() < 1e-6);
        assert!(heading.right().x > 0.999_999, "east is to the right of north");
    }

    #[test]
    fn a_hollow_cone_is_blind_dead_ahead_and_nowhere_else() {
        let cone = Cone { tip: Location::default(), heading: (1.0, 0.0), reach: 10.0, cosine: 0.5 };
        let at = |x, y| Location { x, y, z: 0.0 };
        assert!(!cone.holds(at(5.0, 0.0)) && cone.holds(at(5.0, 0.001)) && cone.holds(at(5.0, -0.001)));
        assert!(cone.holds(at(5.0, 8.6)) && !cone.holds(at(5.0, 8.7)), "60 degrees to each side");
        assert!(!cone.holds(at(10.1, 0.1)) && !cone.holds(at(-1.0, 0.0)));
        assert!(cone.holds(at(0.0, 0.0)), "the tip itself");
    }
}
