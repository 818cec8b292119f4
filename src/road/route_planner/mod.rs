//! Ways to a destination, as CARLA's `GlobalRoutePlanner` finds them.
//!
//! The lanes are cut into segments between forks (`segment`), and the segments make a graph (`graph`). A search finds a way
//! through it that need not be the shortest (`search`), and each junction on the way gets a turn (`turns`). The points of the
//! segments are then joined (`planner`). Whether the last point before a junction belongs to a segment depends on the last
//! bit of CARLA's 32-bit locations (`client_location`). The order of branches at forks depends on its hash tables.
//!
//! Lane changes are left out: CARLA allows them where the road marks do. No road mark of its Town01 and Town02 does.
//!
//! # Source
//! CARLA 0.9.15 `PythonAPI/carla/agents/navigation/global_route_planner.py`.

mod client_location;
mod segment;
mod graph;
mod search;
mod turns;
mod planner;

pub use planner::RoutePlanner;
