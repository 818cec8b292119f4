//! Ways to a destination, as CARLA's `GlobalRoutePlanner` finds them.
//!
//! The lanes are cut into segments between forks (`segment`), the segments make a graph (`graph`), a search finds a way
//! through it that need not be the shortest (`search`), each junction on the way gets a turn (`turns`), and the points of the
//! segments are strung together (`planner`). Whether the last point before a junction belongs to a segment hangs on the
//! last bit of CARLA's 32-bit locations (`client_location`), and what happens at forks on the order of its hash tables.
//!
//! Lane changes are left out: CARLA allows them where the road marks do, which is nowhere in its Town01 and Town02.
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
