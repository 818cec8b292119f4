use crate::geometry::{Point, Pose, Vector, wrap_angle};

/// The coverage of a camera or a scanner: a sector of a circle around the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// Direction of its middle from the heading (rad), positive to the left.
    pub facing: f64,
    /// Whole angle of the sector (rad).
    pub width: f64,
    /// Its range (m).
    pub range: f64,
}

impl Sector {
    fn covers(&self, bearing: f64, distance: f64) -> bool {
        distance <= self.range && wrap_angle(bearing - self.facing).abs() <= self.width / 2.0
    }
}

/// Directions in which more is missed, such as the seam between the images of two cameras.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seam {
    /// Direction of its middle from the heading (rad), positive to the left.
    pub facing: f64,
    /// Whole angle that it covers (rad).
    pub width: f64,
    /// Rate at which actors in it are missed in addition to all other misses.
    pub miss: f64,
}

/// The field of the sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Extent ahead of the ego's middle (m).
    pub ahead: f64,
    /// Extent behind it (m).
    pub behind: f64,
    /// Extent to either side (m).
    pub aside: f64,
    /// Extent from the eye (m).
    pub range: f64,
    /// Distance of the eye ahead of the ego's middle (m).
    pub eye: f64,
    /// The covered sectors; all directions when empty.
    pub sectors: Vec<Sector>,
    /// The directions in which more is missed.
    pub seams: Vec<Seam>,
}

impl Default for Field {
    /// Everything.
    fn default() -> Self {
        let all = f64::INFINITY;
        Self { ahead: all, behind: all, aside: all, range: all, eye: 0.0, sectors: Vec::new(), seams: Vec::new() }
    }
}

impl Field {
    /// The place of the eye for an ego at this pose.
    pub fn eye(&self, ego: &Pose) -> Point {
        ego.to_world(Vector::new(self.eye, 0.0))
    }

    /// The distance of a place from the eye (m) and the rate at which a seam hides it; `None` when it is outside.
    pub fn covers(&self, ego: &Pose, place: Point) -> Option<(f64, f64)> {
        let local = ego.to_local(place);
        let offset = Vector::new(local.x - self.eye, local.y);
        let distance = offset.norm();
        let outside = local.x > self.ahead || local.x < -self.behind || local.y.abs() > self.aside;
        if outside || distance > self.range {
            return None;
        }
        if self.sectors.is_empty() && self.seams.is_empty() {
            return Some((distance, 0.0));
        }
        let bearing = libm::atan2(offset.y, offset.x);
        let covered = self.sectors.is_empty() || self.sectors.iter().any(|sector| sector.covers(bearing, distance));
        let in_seam = |seam: &&Seam| wrap_angle(bearing - seam.facing).abs() <= seam.width / 2.0;
        let seam = self.seams.iter().filter(in_seam).map(|seam| seam.miss).fold(0.0, f64::max);
        covered.then_some((distance, seam))
    }
}
