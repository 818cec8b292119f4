//! Cars under test: driving policies and their perception.
//!
//! In every tick a policy gets a [`Perception`] and returns a [`Control`](crate::sim::Control). It never sees the world, a
//! pedestrian's commands or the reward. Any policy can drive any vehicle: a perception is that of one vehicle. A new policy is
//! one file here and one line in the catalogue. [`sensors`] puts imperfect sensors in front of any of them.

mod perception;
mod driving_policy;
mod actuation_delay;
mod fault;
mod path;
pub mod view;
mod lane_keeping;
mod cruise;
mod native;
mod crosswalks;
mod give_way;
mod idm;
mod route_trace;
mod lane_follower;
mod guarded;
mod emergency_brake;
mod aeb;
mod careful_human;
mod rss_guarded;
mod predictive;
mod oracle_brake;
mod weakness;
pub mod sensors;
pub mod reference_drivers;
pub mod external;
pub mod onnx;

pub use actuation_delay::ActuationDelay;
pub use aeb::{Aeb, AebKeys};
pub use careful_human::CarefulHuman;
pub use cruise::{Cruise, CruiseKeys};
pub use driving_policy::{DrivingMode, DrivingPolicy};
pub use emergency_brake::BrakeKeys;
pub use fault::{Exit, Fault, Word};
pub use idm::Idm;
pub use lane_keeping::cruising_speed;
pub use native::{Native, NativeKeys};
pub use oracle_brake::OracleBrake;
pub use path::Path;
pub use perception::{Actor, Light, Perception, PerfectSensors};
pub use predictive::Predictive;
pub use rss_guarded::RssGuarded;
pub use weakness::Weakness;
