//! Drivers of other programs, rebuilt from their recorded decisions.

pub mod behavior_agent;
pub mod lav;
pub mod interfuser;
pub mod pufferdrive;
