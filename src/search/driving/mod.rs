//! A car that learns to drive: the environment whose agent is the ego, and the imitation of another driver before it learns by itself.
//!
//! A [`DriveEnv`] plays the episodes of a [`Simulation`](episode::Simulation), run-ups included: on the run-up the car drives alone, then it
//! meets a pedestrian. It observes the numbers that a network of [`av::onnx`](world::av::onnx) gets, and chooses an acceleration and a steer in every
//! tick, as such a network does. [`inputs`] says how the numbers are scaled; an exported network holds the scaling.

mod drive_env;
mod drive_rule;
mod imitation;
mod wheel;

pub use drive_env::DriveEnv;
pub use drive_rule::{DriveReward, DriveRule};
pub(crate) use imitation::{Pupil, imitate};
pub use wheel::{ACTION_BOUNDS, ACTION_SCALES, inputs};
