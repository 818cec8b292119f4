//! Imperfect sensors in front of any driving policy.
//!
//! [`SensorWrapper`] is itself a [`DrivingPolicy`](super::DrivingPolicy): it takes the true perception and hands the policy inside
//! one whose pedestrians and vehicles are what a [`SensorModel`] believes. Everything else (the road, the ego, the lights)
//! stays exact.
//!
//! At an *update* of the sensors each actor is looked for:
//!
//! | step | what | in |
//! |---|---|---|
//! | field | is it in the window and in a sector? | [`Field`] |
//! | sight | which share of it do rays from the eye reach? | [`visible_share`] |
//! | luck | is it missed this time? taken for a vehicle? | [`Luck`], [`SensorModel::miss_rate`] |
//! | measurement | where does it seem to be, how fast, how large? | [`Drift`] |
//! | memory | if it was not found: is it still remembered? | `Track` |
//!
//! What was believed at the last update that is old enough (latency) reaches the driver, moved on by its velocity if the
//! model says so. All draws come from streams named by actor and purpose below the policy's own, so that neither the
//! policy's draws nor those of another purpose change with a setting.

mod chance;
mod field;
mod sight;
mod model;
mod track;
mod ghost;
mod wrapper;

pub use chance::{Drift, Luck};
pub use field::{Field, Seam, Sector};
pub use model::SensorModel;
pub use sight::visible_share;
pub use wrapper::SensorWrapper;
