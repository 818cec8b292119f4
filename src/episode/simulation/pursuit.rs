//! The heading of a pedestrian that meets a moving car, and of one that is on its way.

use road::geometry::{Point, Pose, Vector, wrap_angle};
use world::sim::VehicleState;

/// The heading (rad) in which a pedestrian here meets a point of the ego at this speed (m/s). See [`Scene::meeting`](crate::Scene::meeting).
pub(super) fn meeting_heading(here: Point, ego: &VehicleState, point: Point, speed: f64, lead: f64) -> f64 {
    let offset = point - here;
    let velocity = ego.pose.forward() * ego.speed;
    let place = offset + velocity * (lead * meeting_time(offset, velocity, speed).unwrap_or(0.0));
    wrap_angle(libm::atan2(place.y, place.x))
}

/// The heading (rad) of a pedestrian here on its way to a destination; without one, straight across the way of the ego as both were at the start.
pub(super) fn walking_heading(here: Point, destination: Option<Point>, ego: &Pose, start: Point) -> f64 {
    destination.map_or_else(|| across(ego, start), |there| libm::atan2(there.y - here.y, there.x - here.x))
}

/// The direction straight across the way of a car, away from the side of a place (rad).
pub(crate) fn across(car: &Pose, place: Point) -> f64 {
    let across = car.left() * if car.to_local(place).y > 0.0 { -1.0 } else { 1.0 };
    libm::atan2(across.y, across.x)
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
