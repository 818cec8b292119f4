use road::geometry::{Point, Pose, wrap_angle};

/// Pixels per metre of LAV's bird's-eye map.
pub(super) const PIXELS_PER_METRE: f64 = 4.0;

/// A place in LAV's ego frame (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EgoPoint {
    /// To the right of the ego.
    pub right: f64,
    /// Behind the ego; a place ahead is negative.
    pub back: f64,
}

impl EgoPoint {
    /// Makes a point.
    pub const fn new(right: f64, back: f64) -> Self {
        Self { right, back }
    }

    /// A place of the world in the frame of the ego at this pose.
    pub fn seen_from(ego: &Pose, place: Point) -> Self {
        let local = ego.to_local(place);
        Self { right: -local.y, back: -local.x }
    }

    /// The same place in the frame of the ego, for a point in an object's own frame.
    ///
    /// The object's yaw (rad) is relative to the ego and positive clockwise.
    ///
    /// # Source
    /// `transform_points` of LAV.
    pub fn out_of_object(self, object: Self, yaw: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw);
        Self { right: self.right * cos - self.back * sin, back: self.right * sin + self.back * cos } + object
    }

    /// Distance to another point (m).
    pub fn distance(self, other: Self) -> f64 {
        let (right, back) = (self.right - other.right, self.back - other.back);
        (right * right + back * back).sqrt()
    }
}

impl std::ops::Add for EgoPoint {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { right: self.right + other.right, back: self.back + other.back }
    }
}

/// The heading of a body relative to the ego (rad), positive clockwise.
pub(super) fn clockwise_yaw(ego: &Pose, body: &Pose) -> f64 {
    wrap_angle(ego.yaw - body.yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn right_and_back_are_seen_from_the_ego() {
        let north = Pose::new(10.0, 0.0, FRAC_PI_2);
        let seen = EgoPoint::seen_from(&north, Point::new(13.0, 5.0));
        assert!(seen.distance(EgoPoint::new(3.0, -5.0)) < 1e-12, "{seen:?}");
    }

    #[test]
    fn a_car_that_crosses_to_the_left_drives_to_the_left() {
        let ego = Pose::new(0.0, 0.0, 0.0);
        let crossing = Pose::new(9.0, -3.0, FRAC_PI_2);
        let (place, yaw) = (EgoPoint::seen_from(&ego, crossing.position()), clockwise_yaw(&ego, &crossing));
        let ahead = EgoPoint::new(0.0, -1.0).out_of_object(place, yaw);
        assert!(ahead.distance(EgoPoint::new(2.0, -9.0)) < 1e-12, "{ahead:?}");
    }
}
