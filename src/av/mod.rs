//! Cars under test: driving policies and what they may see.
//!
//! A policy gets a [`Perception`] and gives a [`Control`](crate::sim::Control) every tick; it never sees the world, the
//! pedestrian's intentions or the reward. A new policy is one file here and one line in the catalogue.

mod perception;
mod driving_policy;
mod fault;
mod path;
mod view;
mod lane_keeping;
mod cruise;
mod idm;
pub mod behavior_agent;
pub mod lav;
pub mod interfuser;
pub mod external;
pub mod onnx;

pub use cruise::Cruise;
pub use driving_policy::{DrivingMode, DrivingPolicy};
pub use fault::Fault;
pub use idm::Idm;
pub use path::Path;
pub use perception::{Actor, Light, Perception, Sensors};
