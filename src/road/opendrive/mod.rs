//! Reading OpenDRIVE: everything of versions 1.0 to 1.8 that a town of lanes, speed limits, signs and traffic lights needs.
//!
//! The reader is tolerant. A problem that it can work around becomes an [`OpenDriveWarning`] with the road and the line; only
//! a file without any usable road, or with a lane that is wider than a kilometre, is an [`OpenDriveError`]. Superelevation, shapes, lane heights and most kinds of signs are not used;
//! a warning for each kind has the number of them.
//!
//! What the standard has no place for is in `userData` elements, which `export` writes: which objects are obstacles, and the exact place where
//! a speed sign takes effect.

mod attributes;
mod budget;
mod plan_view;
mod limits;
mod lanes;
mod roads;
mod junctions;
mod placed;
mod obstacles;
mod signals;
mod crosswalks;
mod traffic_lights;
mod give_way;
mod unused;
mod file;
mod insertion;

pub use super::opendrive_error::{OpenDriveError, OpenDriveProblem, OpenDriveWarning};
pub use file::read;
pub use insertion::{Addition, insert};
pub use limits::add_speed_sign;
pub use obstacles::{OBSTACLE, TRIGGER};
