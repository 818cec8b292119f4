//! How likely failures are, and how much of a box of parameters was shown to have none that a picture does not show.

mod cover;
mod encounters;

pub use cover::{CoverConfig, Coverage, Look, Picture, Point, Sampled, cover};
pub use encounters::Encounters;
