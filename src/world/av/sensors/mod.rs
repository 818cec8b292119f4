//! Imperfect sensors in front of any driving policy.
//!
//! [`SensorWrapper`] is itself a [`DrivingPolicy`](super::DrivingPolicy). It takes the true perception and passes on to the inner
//! policy one with the pedestrians and vehicles that a [`SensorModel`] believes in. Everything else (the road, the ego, the lights)
//! stays exact.
//!
//! At an *update* of the sensors each actor passes these steps:
//!
//! | step | what | in |
//! |---|---|---|
//! | field | is it in the window and in a sector? | [`SensorModel::covers`] |
//! | sight | which share of it do rays from the eye reach? | [`visible_share`](road::geometry::Obstacles::visible_share) |
//! | luck | is it missed this time? taken for a vehicle? | [`Luck`], [`SensorModel::miss_rate`] |
//! | measurement | where does it seem to be, how fast, how large? | [`Drift`] |
//! | memory | if it was not found: is it still remembered? | `Track` |
//!
//! The driver gets the beliefs of the last update that is old enough (latency), moved on by their velocities if the
//! model does so. All draws come from streams named by actor and purpose below the policy's own. Neither the
//! policy's draws nor those of another purpose therefore change with a setting.

mod chance;
mod model;
mod track;
mod ghost;
mod wrapper;

pub use chance::{Drift, Luck};
pub use model::{ConfusedAs, Prediction, Seam, Sector, SensorKeys, SensorModel};
pub use wrapper::SensorWrapper;
