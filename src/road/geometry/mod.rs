//! Points, poses, boxes and computations with them.
//!
//! The world frame is OpenDRIVE's: right-handed, `x` east, `y` north, metres; a yaw is in radians,
//! counter-clockwise from `+x`, wrapped to (−π, π] by [`wrap_angle`] and by nothing else. CARLA's
//! left-handed frame is `(x, −y, −yaw)`; the conversion happens at the edge, where files are read or written.

mod angle;
mod pose;
mod oriented_box;
mod sweep;
mod obstacles;
pub mod polygon;

pub use angle::wrap_angle;
pub use obstacles::{Obstacles, half_width_of};
pub use oriented_box::OrientedBox;
pub use pose::Pose;
pub use sweep::{Touch, first_touch, first_touch_of_boxes, time_to_touch};

/// A place in the plane (m).
pub type Point = nalgebra::Point2<f64>;

/// A displacement (m) or a velocity (m/s) in the plane.
pub type Vector = nalgebra::Vector2<f64>;
