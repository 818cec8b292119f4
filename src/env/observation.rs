use crate::geometry::{Pose, Vector, wrap_angle};

/// What the paper's "relative scalar speed" is taken to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObservedSpeed {
    /// The ego's speed.
    Ego,
    /// The length of the difference of the two velocities.
    Relative,
}

/// What the pedestrian knows of the ego: the paper's state, in the frame of the pedestrian's heading.
///
/// | paper | field | unit |
/// |---|---|---|
/// | α | `bearing` | rad, positive to the left |
/// | d | `distance` | m, between centres |
/// | β | `relative_heading` | rad, positive to the left |
/// | v | `speed` | m/s |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Direction to the ego's centre.
    pub bearing: f64,
    /// Distance to the ego's centre.
    pub distance: f64,
    /// Direction in which the ego moves.
    pub relative_heading: f64,
    /// Speed, as [`ObservedSpeed`] says.
    pub speed: f64,
}

impl Observation {
    /// Looks at an ego from a pedestrian that faces along its pose and walks so fast (m/s).
    pub fn new(pedestrian: &Pose, walking: f64, ego: &Pose, ego_speed: f64, observed: ObservedSpeed) -> Self {
        let offset: Vector = ego.position() - pedestrian.position();
        let speed = match observed {
            ObservedSpeed::Ego => ego_speed,
            ObservedSpeed::Relative => (ego.forward() * ego_speed - pedestrian.forward() * walking).norm(),
        };
        Self {
            bearing: pedestrian.bearing_to(ego.position()),
            distance: offset.norm(),
            relative_heading: wrap_angle(ego.yaw - pedestrian.yaw),
            speed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_car_coming_from_the_left() {
        let pedestrian = Pose::new(0.0, 0.0, FRAC_PI_2);
        let seen = Observation::new(&pedestrian, 0.0, &Pose::new(-10.0, 0.0, 0.0), 8.0, ObservedSpeed::Ego);
        assert!((seen.bearing - FRAC_PI_2).abs() < 1e-12);
        assert!((seen.relative_heading + FRAC_PI_2).abs() < 1e-12);
        assert_eq!((seen.distance, seen.speed), (10.0, 8.0));
        let relative = Observation::new(&pedestrian, 6.0, &Pose::new(-10.0, 0.0, 0.0), 8.0, ObservedSpeed::Relative);
        assert!((relative.speed - 10.0).abs() < 1e-12);
    }
}
