//! CARLA's own `BehaviorAgent` as a car under test, release by release and with its probable mistakes.
//!
//! `agent` shows a tick: red light, walkers, vehicles, speed for the road, and one run of the planner. The differences
//! between CARLA's releases are data in `release`. Decisions sometimes depend on single bits (a pedestrian exactly dead
//! ahead is not seen). Positions and headings therefore pass through CARLA's left-handed frame and its 32-bit floats
//! (`carla_frame`).
//!
//! Probable mistakes of CARLA that are kept:
//!
//! - Distances begin at the bumper, and are shortened by half the ego.
//! - An obstacle outside the ego's lane, by the nearest centre line, is invisible.
//! - In junctions the route is a zig-zag and the obstacle a bow-tie, both with holes.
//! - Without a walker near by, the walker step of newer releases tests all vehicles with its wider cone.
//! - The first obstacle found counts, not the nearest one.
//! - An emergency stop straightens the wheels, freezes the planner, and uses half of the brake in all releases but the oldest.
//! - An obstacle exactly dead ahead is not seen.
//! - An obstacle is measured at its back, the far side of one that faces the car.
//!
//! Without a given plan the agent finds its own way (`way_finding`).
//!
//! Lane changes and the tailgating check are left out: they matter only on roads with several lanes per direction.
//!
//! # Source
//! CARLA `PythonAPI/carla/agents/{navigation,tools}`, releases 0.9.11 to 0.9.15.

mod release;
mod profile;
mod carla_frame;
mod way_finding;
mod planner;
mod controller;
mod red_light;
mod polygon;
mod obstacle;
mod decision;
mod agent;
mod kind;

pub use agent::{AgentConfig, BehaviorAgent};
pub use decision::Decision;
pub use profile::Profile;
pub use release::Release;
pub use way_finding::{AtDestination, WayFinding};
