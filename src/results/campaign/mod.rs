//! Runs a campaign: the parts of its jobs as tasks, side by side on rayon's threads.
//!
//! A [`ResultStore`] stores finished tasks and returns them in a later run. An [`Observer`] receives every [`Event`]. A job starts when the
//! one that it needs has ended. Results are in the order of the plan and do not depend on the threads.

mod task;
mod event;
mod result_store;
mod part;
mod finished;
mod queue;
mod run;
mod shard;

pub use event::{Event, Observer, Silent};
pub use finished::{Collect, Finished, collect};
pub use part::Part;
pub use result_store::{Claim, NoStore, ResultStore, State, Stored};
pub use run::{run, run_tasks};
pub use shard::{Shard, deal, shard};
pub use task::{Task, TaskError, tasks};
