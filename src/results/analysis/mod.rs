//! Classes of failure: the modes in which a pedestrian hits the car, and the starts that lead to them. The only code that knows smartcore.
//!
//! 1. A collision is a [`Failure`](crate::failure::Failure), sorted into a [`Kind`] by fixed rules.
//! 2. Within a kind the motions before the touch ([`Approach`]) are clustered. A number of clusters counts only when two halves of the
//!    data and bootstrap samples agree on it; each [`FailureMode`] has its medoid as an example.
//! 3. [`Explanation`] gives a few rules for the starts that end in a failure, and measures their predictions on episodes that were not
//!    used for learning.

mod kind;
mod approach;
mod agreement;
mod clusters;
mod failure_modes;
mod cases;
mod tree;
mod explanation;
#[cfg(test)]
mod tests;

pub use approach::Approach;
pub use cases::{Cases, Feature, Scale};
pub use clusters::Stability;
pub use explanation::{Condition, Explanation, Rule};
pub use failure_modes::{FailureMode, failure_modes};
pub use kind::Kind;
