//! The road network of a town: roads with lanes, junctions, what stands beside them, and routes through it.
//!
//! Reference lines, lane numbers and links are OpenDRIVE's; what is asked of them (`next`, nearest lane) is what
//! CARLA's map answers, since its driver's decisions hang on it.

mod cubic;
mod plan_view;
mod lane;
mod road;
mod junction;
mod furniture;
mod waypoint;

pub use cubic::{Cubic, Profile};
pub use furniture::{SpeedSign, TrafficLight};
pub use junction::{Connection, Junction};
pub use lane::{Lane, LaneId, LaneKind};
pub use plan_view::{Geometry, PlanView, Shape};
pub use road::{JunctionIndex, LaneSection, Road, RoadEnd, RoadIndex, RoadLink};
pub use waypoint::{LaneStretch, PosedWaypoint, Waypoint};
