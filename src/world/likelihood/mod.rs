//! How likely failures are: the probability of an event in an encounter with a pedestrian who walks as people do, by counting.
//!
//! Beside it, [`cover`] shows how much of a [`BoxOfStarts`] can fail where a picture of it says that it passes.

mod box_of_starts;
mod cover;
mod encounters;
mod estimate;
mod event;

#[cfg(test)]
mod tests;

pub use box_of_starts::BoxOfStarts;
pub use cover::{CoverConfig, Coverage, Look, Picture, Point, Sampled, cover};
pub use encounters::{Encounters, Question};
pub use estimate::{Encounter, Estimate, Likelihood, Limits, encounters_needed, estimate};
pub use event::{Event, Events};
