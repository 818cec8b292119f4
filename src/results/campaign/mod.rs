//! Runs a campaign: trainings, evaluations, searches, estimates and covers as tasks, side by side on rayon's threads.
//!
//! A [`ResultStore`] stores finished tasks and returns them in a later run. An [`Observer`] hears every [`Event`]. An evaluation starts when
//! its pedestrian is trained. Results are in the order of the plan and do not depend on the threads.

mod task;
mod event;
mod result_store;
mod watch;
mod repeat;
mod chunk;
mod search_result;
mod search;
mod estimate;
mod cover;
mod cover_result;
mod harden;
mod queue;
mod run;
mod shard;
mod smoke;

pub use cover_result::{CoverResult, FoundInBox};
pub use estimate::EstimateResult;
pub use event::{Event, Observer, Silent};
pub use harden::HardenResult;
pub(crate) use repeat::repeat_episodes;
pub use repeat::{Repeatable, Repeated, networks};
pub use result_store::{Claim, InMemory, Progress, ResultStore};
pub use run::{Finished, TrainingResult, collect, complete, run, run_tasks};
pub use search_result::{Find, SearchResult};
pub use shard::{Shard, deal, shard};
pub use smoke::smoke;
pub use task::{Task, TaskError, tasks, units};
pub use watch::watch;
