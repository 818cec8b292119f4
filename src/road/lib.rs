//! The road network of a town: roads with lanes, junctions, objects beside them, and routes through it.
//!
//! Reference lines, lane numbers and links are OpenDRIVE's. Queries (`next`, nearest lane) return what CARLA's map returns,
//! since the decisions of its driver depend on it.

pub mod geometry;
mod cubic;
mod spiral;
mod curve_table;
mod plan_view;
mod lane;
mod road;
mod junction;
mod waypoint;
mod furniture;
mod assumed_limit;
mod hash_order;
mod lane_network;
mod chord;
mod chord_tree;
mod chord_grid;
mod lane_index;
mod opendrive_error;
mod town;
mod levels;
mod around;
mod frenet;
mod topology;
pub mod opendrive;
mod route;
mod route_planner;
pub mod design;
pub mod crosswalk;
mod lane_route;

pub use around::LaneAround;
pub use assumed_limit::{AssumedLimit, FIRST_LIMIT};
pub use cubic::{Cubic, Profile};
pub use frenet::Frenet;
pub use furniture::{Crosswalk, GiveWay, GiveWaySign, SpeedSign, TrafficLight};
pub use junction::{Connection, Junction};
pub use lane::{Lane, LaneFilter, LaneId, LaneKind};
pub use lane_route::{MissingTurn, lane_route};
pub use levels::{Crossing, LEVEL};
pub use opendrive_error::{OpenDriveError, OpenDriveProblem, OpenDriveWarning};
pub use plan_view::{Geometry, PlanView, Shape};
pub use road::{JunctionIndex, LaneSection, Road, RoadEnd, RoadIndex, RoadLink};
pub use route::{ForkRule, RandomWalk, RoadOption, RoutePoint, turn};
pub use route_planner::RoutePlanner;
pub use town::{MapFile, Town, TownParts};
pub use waypoint::{LaneStretch, Place, Waypoint};
