//! Steering along a path and the speed for its bends, for our own policies.

use super::{Path, Perception};

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

/// The speed (m/s) at which an average driver would be at the start of a path.
pub fn cruising_speed(path: &Path, perception: &Perception<'_>) -> f64 {
    speed_for_bends(path, speed_for_limits(path, perception, LIMIT_SHARE, COMFORT), COMFORT, COMFORT)
}

/// A greatest speed (m/s) at a place ahead, which is this far away (m): of a lower limit, or of a sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Demand {
    pub gap: f64,
    pub speed: f64,
}

/// A driver begins to brake for a demand at this share of the speed that is allowed now, so that it does not switch between pedals.
const EARLY: f64 = 0.9;

impl Demand {
    /// The greatest speed now (m/s) for a driver that brakes with a deceleration (m/s²) from now on.
    pub fn allowed(&self, braking: f64) -> f64 {
        (self.speed * self.speed + 2.0 * braking * self.gap).sqrt()
    }

    /// The acceleration (m/s²) with which a driver at a speed (m/s) meets the demand at its place; infinite while it need not brake with this
    /// deceleration (m/s²).
    pub fn acceleration(&self, speed: f64, braking: f64) -> f64 {
        let brakes = speed > self.speed && speed > EARLY * self.allowed(braking);
        if brakes { (self.speed * self.speed - speed * speed) / (2.0 * self.gap).max(0.2) } else { f64::INFINITY }
    }
}

/// The speed limit on the lane of a path's first point (m/s).
pub fn limit_here(path: &Path, perception: &Perception<'_>) -> f64 {
    path.points().next().map_or(perception.speed_limit, |here| perception.limit_at(here.waypoint))
}

/// The lower limit ahead on a path for which a driver that wants a share of the limit has to brake first, with this deceleration (m/s²). A limit
/// on a sign counts from the sign on.
pub(super) fn lower_limit(path: &Path, perception: &Perception<'_>, share: f64, braking: f64) -> Option<Demand> {
    let mut points = path.points();
    let here = points.next().filter(|_| perception.town.has_limits())?;
    let own = share * perception.limit_at(here.waypoint);
    let (mut last, mut along) = (&here.pose, -here.pose.to_local(perception.ego.pose.position()).x);
    let mut lowest: Option<Demand> = None;
    for point in points {
        along += (point.pose.position() - last.position()).norm();
        last = &point.pose;
        let there = Demand { gap: along.max(0.0), speed: share * perception.limit_at(point.waypoint) };
        let first = |lowest: Demand| there.allowed(braking) < lowest.allowed(braking);
        if there.speed < own && lowest.is_none_or(first) {
            lowest = Some(there);
        }
    }
    lowest
}

/// The speed (m/s) of a driver that wants a share of the limit: of the limit of its lane, and braking (m/s²) in time for lower limits ahead.
pub fn speed_for_limits(path: &Path, perception: &Perception<'_>, share: f64, braking: f64) -> f64 {
    let ahead = lower_limit(path, perception, share, braking).map_or(f64::INFINITY, |lower| lower.allowed(braking));
    (share * limit_here(path, perception)).min(ahead)
}

/// The speed (m/s) at which the ego takes every bend ahead within a lateral acceleration, and stops at the end of the road
/// with comfortable braking, both in m/s².
pub fn speed_for_bends(path: &Path, wanted: f64, lateral: f64, braking: f64) -> f64 {
    let mut allowed = wanted * wanted;
    let mut along = 0.0;
    for step in path.steps() {
        let length = step.length.max(0.1);
        let curvature = step.turn / length;
        if step.turn > 0.0 && curvature > 1e-4 {
            allowed = allowed.min(lateral / curvature + 2.0 * braking * along);
        }
        along += length;
    }
    if path.ends() {
        allowed = allowed.min(2.0 * braking * (along - 3.0).max(0.0));
    }
    allowed.sqrt()
}
