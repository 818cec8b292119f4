//! The cause of a failure, by running it again with one thing changed.
//!
//! An [`Incident`] is a failure by what repeats it. [`Reruns`] run it with other commands or another driver. [`shrink()`] finds the fewest commands that
//! keep its [`FailureKind`]; [`explain()`] finds the [`Change`] of what the driver sees or does that turns it, and the [`Weakness`](world::av::Weakness) that this shows.
//!
//! A driver is asked as a black box: its commands are compared, bit for bit, with those that it gives when nobody is there, when somebody suddenly stands
//! in its way, or when the pedestrian is somewhere else than she is. So a cause is found for a program of the user, too. [`DriverParts`](episode::DriverParts) are what can be
//! exchanged of a driver of ours.

mod altered;
mod around;
#[expect(clippy::module_inception, reason = "a cause is the noun of its file")]
mod cause;
mod experiments;
mod explain;
mod failure_kind;
mod incident;
mod lasting;
mod needs;
mod plan;
mod profile;
mod sentence;
mod setting;
mod shown;
mod shrink;
mod violated;

pub use altered::{Change, unseeing};
pub use around::{Around, StartRule, around};
use cause::FACULTIES;
pub use cause::{Cause, MAX_RUNS, MAX_RUNS_OF_PROGRAM, Questions, RunLimit, TurnedBy};
pub use explain::{explain, explain_any};
pub use failure_kind::FailureKind;
pub use incident::{Incident, Rerun, Reruns, WrapMaker};
pub use needs::{Need, needed, needed_names, needs};
pub use plan::{Plan, Segment};
pub use shrink::{Limit, Shrunk, shrink};
pub use violated::{part_of, unit_of, violated_part};
