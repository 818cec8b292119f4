//! Classes of failure: in how many ways a pedestrian hits the car, and which starts lead to them. The only code that knows smartcore.
//!
//! 1. A collision is a [`Failure`], sorted into a [`Kind`] by rules that anyone can check.
//! 2. Within a kind the ways to the touch ([`Approach`]) are clustered. A number of clusters counts only when two halves of the data
//!    and bootstrap samples agree on it; each [`FailureMode`] has its medoid as an example.
//! 3. [`Richness`] counts the classes, and estimates how many have not been seen.
//! 4. [`Explanation`] gives a few rules for which starts end in a failure, and how well they predict episodes that they were not
//!    learnt from.

mod failure;
mod approach;
mod agreement;
mod clusters;
mod failure_modes;
mod richness;
mod cases;
mod tree;
mod explanation;
#[cfg(test)]
mod tests;

pub use approach::{Approach, Station};
pub use cases::{Cases, Feature, Scale};
pub use clusters::Stability;
pub use explanation::{Condition, Explanation, Importance, Rule};
pub use failure::{Failure, Impact, Kind};
pub use failure_modes::{FailureMode, failure_modes};
pub use richness::{Richness, accumulation};
