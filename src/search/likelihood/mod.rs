//! How likely failures are: the probability of an event in an encounter with a pedestrian who walks as people do, by counting.
//!
//! Beside it, [`cover`] shows how much of a [`BoxOfStarts`] can fail where a picture of it says that it passes.

mod box_of_starts;
mod cover;
mod encounters;
mod estimate;

pub use box_of_starts::BoxOfStarts;
pub(crate) use cover::latin_hypercube;
pub use cover::{CoverConfig, Coverage, Look, Picture, Point, Sampled, cover};
pub use encounters::Encounters;
pub use estimate::{Encounter, Estimate, Likelihood, Limits, encounters_needed, estimate};
