//! CARLA's own `BehaviorAgent` as a car under test, release by release and with its accidents.
//!
//! A tick is read in `agent`: red light, walkers, vehicles, speed for the road, and one run of the planner. What
//! differs between CARLA's releases is data in `release`; what looks like an accident can be switched off in
//! [`Quirks`]. Decisions sometimes depend on single bits (a pedestrian exactly dead ahead is not seen), so positions and
//! headings pass through CARLA's left-handed frame and its 32-bit floats (`carla_frame`).
//!
//! Without a given plan the agent finds its own way (`way_finding`).
//!
//! Lane changes and the tailgating check, which matter only on roads with several lanes a direction, are left out.
//!
//! # Source
//! CARLA `PythonAPI/carla/agents/{navigation,tools}`, releases 0.9.11 to 0.9.15.

mod release;
mod profile;
mod quirks;
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
pub use quirks::Quirks;
pub use release::Release;
pub use way_finding::{AtDestination, WayFinding};
