use std::f64::consts::{PI, TAU};

/// Wraps an angle (rad) to (−π, π].
///
/// # Example
/// ```
/// use road::geometry::wrap_angle;
/// use std::f64::consts::PI;
/// assert_eq!(wrap_angle(-PI), PI);
/// assert!((wrap_angle(3.0 * PI / 2.0) + PI / 2.0).abs() < 1e-15);
/// ```
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    angle - TAU * ((angle - PI) / TAU).ceil()
}
