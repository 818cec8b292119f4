//! Commands of pedestrians that know the ego's position: straight at the ego, or to its future position.

use super::PedestrianEnv;
use crate::geometry::{Point, Vector, wrap_angle};
use crate::sim::{VehicleState, WalkCommand};

impl PedestrianEnv {
    /// The command of a homing pedestrian: straight at the ego, at its greatest speed.
    pub fn homing(&self, pedestrian: usize) -> WalkCommand {
        let (state, speed) = (&self.world().pedestrians[pedestrian].state, self.greatest_speed(pedestrian));
        let offset = self.world().ego().state.pose.position() - state.pose.position();
        WalkCommand { heading: libm::atan2(offset.y, offset.x), speed }
    }

    /// The command of an intercepting pedestrian: to the nearest place where it can meet an ego that keeps its velocity, or straight at
    /// the ego when there is none.
    pub fn intercept(&self, pedestrian: usize) -> WalkCommand {
        self.meeting(pedestrian, self.world().ego().state.pose.position(), self.greatest_speed(pedestrian), 1.0)
    }

    /// The command of a pedestrian that meets a point of the ego at this speed (m/s), if the ego keeps its velocity; straight at the point
    /// when it cannot meet it. `lead` is the share of the ego's way until then by which it aims ahead of the point: 1 meets it, 0 walks
    /// straight at it.
    pub fn meeting(&self, pedestrian: usize, point: Point, speed: f64, lead: f64) -> WalkCommand {
        let (pose, ego) = (&self.world().pedestrians[pedestrian].state.pose, &self.world().ego().state);
        WalkCommand { heading: meeting_heading(pose.position(), ego, point, speed, lead), speed }
    }

    /// The middle of the ego's bumper.
    pub(super) fn bumper(&self) -> Point {
        let ego = self.world().ego();
        ego.state.pose.to_world(Vector::new(ego.blueprint.half_length, 0.0))
    }

    fn greatest_speed(&self, pedestrian: usize) -> f64 {
        self.scenario().cast.pedestrian(pedestrian).action.speed.1
    }
}

/// The heading (rad) in which a pedestrian here meets a point of the ego at this speed (m/s). See [`PedestrianEnv::meeting`].
pub(super) fn meeting_heading(here: Point, ego: &VehicleState, point: Point, speed: f64, lead: f64) -> f64 {
    let offset = point - here;
    let velocity = ego.pose.forward() * ego.speed;
    let place = offset + velocity * (lead * meeting_time(offset, velocity, speed).unwrap_or(0.0));
    wrap_angle(libm::atan2(place.y, place.x))
}

/// The least time (s) after which a pedestrian at the origin can reach a car at `offset` with `velocity`.
fn meeting_time(offset: Vector, velocity: Vector, speed: f64) -> Option<f64> {
    // |offset + velocity t| = speed t
    let a = velocity.norm_squared() - speed * speed;
    let b = offset.dot(&velocity);
    let c = offset.norm_squared();
    if a.abs() < 1e-9 {
        return (b < 0.0).then(|| -c / (2.0 * b));
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (t1, t2) = ((-b - root) / a, (-b + root) / a);
    let earliest = t1.min(t2);
    let latest = t1.max(t2);
    if earliest > 0.0 { Some(earliest) } else { (latest > 0.0).then_some(latest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_meeting_point_is_reached_by_both_at_once() {
        let (offset, velocity) = (Vector::new(-20.0, 5.0), Vector::new(7.0, 0.0));
        let t = meeting_time(offset, velocity, 3.5).unwrap();
        assert!(((offset + velocity * t).norm() - 3.5 * t).abs() < 1e-9);
        assert_eq!(meeting_time(Vector::new(20.0, 0.0), Vector::new(7.0, 0.0), 3.5), None, "it drives away, faster");
        let same = meeting_time(Vector::new(-10.0, 0.0), Vector::new(3.5, 0.0), 3.5).unwrap();
        assert!((same - 10.0 / 7.0).abs() < 1e-9);
    }
}
