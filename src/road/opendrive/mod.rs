//! Reading OpenDRIVE: everything of versions 1.0 to 1.8 that a town of lanes, speed signs and traffic lights needs.
//!
//! The reader is tolerant. A problem that it can work around becomes an [`OpenDriveWarning`] with the road and the line; only
//! a file without any usable road is an [`OpenDriveError`]. Superelevation, shapes and lane heights are not read.

mod error;
mod attributes;
mod plan_view;
mod lanes;
mod roads;
mod junctions;
mod signals;
mod crosswalks;
mod traffic_lights;
mod file;

pub use error::{OpenDriveError, OpenDriveProblem, OpenDriveWarning};
pub use file::read;

#[cfg(test)]
mod tests;
