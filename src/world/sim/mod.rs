//! The simulator: vehicles and pedestrians, one tick at a time. It knows no driving policy and no reward.
//!
//! A tick is *observe, choose, propagate*: drivers and pedestrians read the [`World`], and [`World::tick`] moves every vehicle by
//! a [`Control`] and every pedestrian by a [`WalkCommand`] and reports the first [`Contact`].

mod blueprint;
mod vehicle;
mod pedestrian;
mod traffic_light;
mod actor;
mod start;
mod contact;
mod world;

pub use actor::{ActorId, Pedestrian, Vehicle};
pub use blueprint::{Control, ThrottleLine, VehicleBlueprint};
pub use contact::Contact;
pub use pedestrian::{Gait, PedestrianBody, PedestrianState, WalkCommand};
pub use start::{ActorStart, Start};
pub use traffic_light::{LightClock, LightColour, LightCycle};
pub use vehicle::{EYE, VehicleState, advance};
pub use world::{World, time_of};
