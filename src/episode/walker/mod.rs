//! Pedestrians that walk.
//!
//! A [`WalkPolicy`] chooses commands decision by decision: as the user of a simulation, or within it as the [`Controller`] of a role. A new one is one
//! file here and one line in the catalogue.

mod walk_policy;
mod controller;
mod fault_streak;
mod trained;
mod random;
mod homing;
mod intercept;
mod recorded_walking;
mod social_force;
mod natural;
mod scripted;
mod outside;

pub use controller::Controller;
pub use fault_streak::FaultStreak;
pub use homing::{Homing, HomingKeys};
pub use intercept::{Intercept, InterceptKeys};
pub use natural::{Forces, Gaps, Natural, NaturalKeys, Recording, log_likelihood};
pub use outside::{
    Networked, NetworkedKeys, PROTOCOL, Programmed, ProgrammedKeys, UnsuitableNetwork, network_differs, network_fits,
};
pub use random::{Random, RandomKeys};
pub use recorded_walking::RecordedWalking;
pub use scripted::{Scripted, ScriptedKeys};
pub use trained::{ActionMode, TrainedWalker};
pub use walk_policy::WalkPolicy;
