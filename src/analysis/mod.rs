//! Failure modes: in how many ways a trained pedestrian hits the car. The only code that knows smartcore.
//!
//! Collisions are first sorted by rules anyone can check (side of the impact, whether the car moved), then clustered by
//! how they began and went.

mod failure_modes;
mod clusters;

pub use failure_modes::{FailureMode, Impact, failure_modes};
