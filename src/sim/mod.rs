//! The simulator: one ego vehicle, one pedestrian, one tick at a time. It knows no driving policy and no reward.
//!
//! A tick is *observe, choose, propagate*: whoever drives reads [`World`], and [`World::tick`] moves both actors by a
//! [`Control`] and a [`WalkCommand`] and reports the first [`Contact`].

mod vehicle;
mod blueprint;
mod pedestrian;
mod traffic_light;
mod contact;
mod world;

pub use blueprint::{ThrottleLine, VehicleBlueprint};
pub use contact::Contact;
pub use pedestrian::{PedestrianBody, PedestrianState, WalkCommand};
pub use traffic_light::{LightClock, LightColour, LightCycle};
pub use vehicle::{Control, VehicleState};
pub use world::{Scene, World};
