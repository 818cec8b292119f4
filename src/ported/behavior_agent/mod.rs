//! CARLA's own `BehaviorAgent` as a car under test, release by release and with its quirks.
//!
//! `agent` shows a tick: red light, walkers, vehicles, speed for the road, and one run of the planner. The differences
//! between CARLA's releases are data in `release`; probable mistakes of CARLA can be switched off in
//! [`Quirks`]. Decisions sometimes depend on single bits (a pedestrian exactly dead ahead is not seen). Positions and
//! headings therefore pass through CARLA's left-handed frame and its 32-bit floats (`carla_frame`).
//!
//! Without a given plan the agent finds its own way (`way_finding`).
//!
//! Lane changes and the tailgating check are left out: they matter only on roads with several lanes per direction.
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
