use std::f64::consts::{PI, TAU};

use crate::{ReferenceFrame, Scaling};
use base::choice;
use road::Frenet;
use road::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};

/// The angle that an observation scaled to units divides by (rad), the distance (m) and the speed (m/s).
pub(super) const UNITS: (f64, f64, f64) = (PI, 30.0, 8.0);

/// The greatest amounts of the numbers about the road (m; m; m; m; 1; 1; m; rad): greater ones are cut, and one scaled to units is divided by its own.
pub(super) const ROAD: [f64; ObservationSpec::ROAD_DIM] = [60.0, 20.0, 10.0, 6.0, 1.0, 1.0, 2.0, 2.0];

choice! {
    /// The meaning of the paper's "relative scalar speed".
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ObservedSpeed {
        /// The ego's speed.
        Ego = "ego",
        /// The length of the difference of the two velocities.
        Relative = "relative",
    }
}

/// A pedestrian's observation of the ego: the paper's state, in the frame of the pedestrian's heading.
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
    /// The speed that [`ObservedSpeed`] selects.
    pub speed: f64,
}

impl Observation {
    /// The observation of an ego by a pedestrian at this pose and with this speed (m/s).
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

/// Converts an [`Observation`] to the numbers of a state: bearing, distance, relative heading, speed; then the road, how far the view is free along the
/// rays, and the nearest other actors.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservationSpec {
    /// The direction from which the angles are measured.
    pub frame: ReferenceFrame,
    /// The units of the state.
    pub scaling: Scaling,
    /// The meaning of the speed.
    pub speed: ObservedSpeed,
    /// Whether the road is seen.
    pub road: bool,
    /// The number of directions in which obstacles are seen, evenly around from the direction of the frame, counterclockwise.
    pub rays: usize,
    /// The number of places for other actors, the nearest first.
    pub others: usize,
}

/// Another actor than the ego, as a pedestrian sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenActor {
    pub pose: Pose,
    /// In the world (m/s).
    pub velocity: Vector,
    /// Half extents along its heading and across it (m).
    pub half: Vector,
    pub is_vehicle: bool,
}

impl ObservationSpec {
    /// The numbers of a state about the ego.
    pub const DIM: usize = 4;

    /// The numbers of a state about another actor: 1 if there is one, 1 if it is a vehicle, how far it is ahead and to the left, its velocity in these
    /// directions, and its half extents.
    pub const OTHER_DIM: usize = 8;

    /// The numbers of a state about the road.
    pub const ROAD_DIM: usize = 8;

    /// The length of a ray (m): what is farther is not seen.
    pub const REACH: f64 = 20.0;

    /// The numbers of a state.
    pub fn dim(&self) -> usize {
        Self::DIM + self.seen_road() + self.rays + self.others * Self::OTHER_DIM
    }

    /// The numbers of the state about the road: 8 or none.
    pub(crate) fn seen_road(&self) -> usize {
        if self.road { Self::ROAD_DIM } else { 0 }
    }

    /// The numbers about the ego for an observation in the frame of the pedestrian's heading.
    pub fn encode(&self, seen: &Observation, pedestrian: &Pose, initial_heading: f64, ego: Point) -> [f64; Self::DIM] {
        let turn = wrap_angle(pedestrian.yaw - self.frame.origin(pedestrian, initial_heading, ego));
        // On the line of sight the bearing is always 0; the pedestrian's own heading replaces it.
        let first = match self.frame {
            ReferenceFrame::LineOfSight => turn,
            _ => wrap_angle(seen.bearing + turn),
        };
        let state = [first, seen.distance, wrap_angle(seen.relative_heading + turn), seen.speed];
        match self.scaling {
            Scaling::Natural => state,
            Scaling::Unit => {
                let (turn, distance, speed) = UNITS;
                [state[0] / turn, state[1] / distance, state[2] / turn, state[3] / speed]
            }
        }
    }

    /// The numbers about the road for a pedestrian in the coordinates of the ego's lane; all are 0 in a town without driving lanes.
    pub fn encode_road(
        &self,
        seen: Option<Frenet>,
        pedestrian: &Pose,
        initial_heading: f64,
        ego: Point,
    ) -> [f64; Self::ROAD_DIM] {
        let Some(Frenet { along, left, beyond_edge, inside, direction, car_left, car_turn }) = seen else {
            return [0.0; Self::ROAD_DIM];
        };
        let (sin, cos) = libm::sincos(direction - self.frame.origin(pedestrian, initial_heading, ego));
        let mut state = [along, left, beyond_edge, inside, cos, sin, car_left, car_turn];
        for (number, most) in state.iter_mut().zip(ROAD) {
            *number = number.clamp(-most, most) / if self.scaling == Scaling::Unit { most } else { 1.0 };
        }
        state
    }

    /// The numbers about another actor.
    pub fn encode_other(
        &self,
        pedestrian: &Pose,
        initial_heading: f64,
        ego: Point,
        other: &SeenActor,
    ) -> [f64; Self::OTHER_DIM] {
        let yaw = self.frame.origin(pedestrian, initial_heading, ego);
        let frame = Pose { yaw, ..*pedestrian };
        let (place, half) = (frame.to_local(other.pose.position()), other.half);
        let velocity = [other.velocity.dot(&frame.forward()), other.velocity.dot(&frame.left())];
        let (metres, pace) = match self.scaling {
            Scaling::Natural => (1.0, 1.0),
            Scaling::Unit => (UNITS.1, UNITS.2),
        };
        let is_vehicle = f64::from(other.is_vehicle);
        [
            1.0,
            is_vehicle,
            place.x / metres,
            place.y / metres,
            velocity[0] / pace,
            velocity[1] / pace,
            half.x / metres,
            half.y / metres,
        ]
    }

    /// Writes how far the view is free along each ray: in metres, or over their length.
    pub fn look(&self, pedestrian: &Pose, initial_heading: f64, ego: Point, obstacles: &Obstacles, seen: &mut [f64]) {
        if seen.is_empty() {
            return;
        }
        let (first, between) = (self.frame.origin(pedestrian, initial_heading, ego), TAU / seen.len() as f64);
        let directions = (0..seen.len()).map(|number| first + between * number as f64);
        let rays: Vec<Vector> =
            directions.map(|way| Vector::new(libm::cos(way), libm::sin(way)) * Self::REACH).collect();
        obstacles.free_shares(pedestrian.position(), &rays, seen);
        if self.scaling == Scaling::Natural {
            seen.iter_mut().for_each(|share| *share *= Self::REACH);
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

    #[test]
    fn walking_at_the_bearing_of_the_state_leads_to_the_ego() {
        use crate::ActionSpec;
        let (pose, ego) = (Pose::new(3.0, 4.0, 2.5), Pose::new(-5.0, 1.0, 0.2));
        for frame in [ReferenceFrame::Heading, ReferenceFrame::Initial, ReferenceFrame::World] {
            let scaling = Scaling::Natural;
            let observation =
                ObservationSpec { frame, scaling, speed: ObservedSpeed::Ego, road: false, rays: 0, others: 0 };
            let action =
                ActionSpec { frame, scaling, speed: (0.0, 3.5), heading: ActionSpec::ANY_HEADING, destination: None };
            let seen = Observation::new(&pose, 0.0, &ego, 5.0, ObservedSpeed::Ego);
            let state = observation.encode(&seen, &pose, 0.3, ego.position());
            let command = action.command([state[0], 1.0], |_| frame.origin(&pose, 0.3, ego.position()));
            let towards = libm::atan2(ego.y - pose.y, ego.x - pose.x);
            assert!(wrap_angle(command.heading - towards).abs() < 1e-12, "{frame:?}");
        }
    }
}
