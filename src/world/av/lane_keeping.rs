//! Steering along a path and the speed for its bends, for our own policies.

use super::{Path, Perception};
use crate::geometry::wrap_angle;

/// The steer towards a point ahead on the path: pure pursuit.
///
/// The wheel angle is `atan(2 L sin α / d)` for a point at distance d and bearing α. The look-ahead grows with the speed.
///
/// # Source
/// Coulter, *Implementation of the pure pursuit path tracking algorithm*, CMU-RI-TR-92-01.
pub fn steer(path: &Path, perception: &Perception<'_>) -> f64 {
    let (ego, blueprint) = (&perception.ego, perception.blueprint);
    let speed = ego.speed();
    let look_ahead = (0.6 * speed).clamp(3.5, 15.0);
    let here = ego.pose.position();
    let Some(target) = path.ahead(here, look_ahead) else { return 0.0 };
    let distance = (target.pose.position() - here).norm();
    if distance < 0.5 {
        return 0.0;
    }
    let bearing = ego.pose.bearing_to(target.pose.position());
    let wheel = libm::atan(2.0 * blueprint.wheelbase * libm::sin(bearing) / distance);
    blueprint.steer_for(wheel, speed)
}

/// Share of the limit that [`cruising_speed`] is on a straight street.
const LIMIT_SHARE: f64 = 0.9;
/// Acceleration in bends and deceleration before them in [`cruising_speed`] (m/s²).
const COMFORT: f64 = 2.0;

/// The speed (m/s) at which an average driver would be at the start of a path, under a limit (m/s).
pub fn cruising_speed(path: &Path, limit: f64) -> f64 {
    speed_for_bends(path, LIMIT_SHARE * limit, COMFORT, COMFORT)
}

/// The speed (m/s) at which the ego takes every bend ahead within a lateral acceleration, and stops at the end of the road
/// with comfortable braking, both in m/s².
pub fn speed_for_bends(path: &Path, wanted: f64, lateral: f64, braking: f64) -> f64 {
    let mut allowed = wanted * wanted;
    let mut along = 0.0;
    let mut before: Option<&crate::geometry::Pose> = None;
    for point in path.points() {
        if let Some(last) = before {
            let step = (point.pose.position() - last.position()).norm().max(0.1);
            let curvature = wrap_angle(point.pose.yaw - last.yaw).abs() / step;
            if curvature > 1e-4 {
                allowed = allowed.min(lateral / curvature + 2.0 * braking * along);
            }
            along += step;
        }
        before = Some(&point.pose);
    }
    if path.ends() {
        allowed = allowed.min(2.0 * braking * (along - 3.0).max(0.0));
    }
    allowed.sqrt()
}
