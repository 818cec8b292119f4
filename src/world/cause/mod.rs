//! The cause of a failure, by running it again with one thing changed.
//!
//! An [`Incident`] is a failure by what repeats it. [`Reruns`] run it with other commands or another driver, [`shrink`] finds the fewest commands that
//! keep its [`FailureKind`].

mod failure_kind;
mod incident;
mod plan;
mod shrink;

pub use failure_kind::FailureKind;
pub use incident::{Incident, Rerun, Reruns};
pub use plan::{Plan, Segment};
pub use shrink::{Limit, Shrunk, shrink};
