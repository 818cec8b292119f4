//! Runs a campaign: trainings, then evaluations, then searches, side by side on rayon's threads.
//!
//! Results come back in the order of the plan, whatever the threads did. Progress goes to an [`Observer`].

mod row;
mod observer;
mod watch;
mod stopping;
mod search;
mod run;

pub use observer::{Observer, Silent};
pub use row::EpisodeRow;
pub use run::{Finished, TrainingResult, run, smoke};
pub use search::SearchResult;
pub use stopping::StoppingRule;
pub use watch::watch;
