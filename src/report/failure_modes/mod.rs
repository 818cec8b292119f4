//! Failure modes: samples of a campaign's episodes go to [`analysis`](crate::analysis); classes, clusters and rules come back.
//!
//! Episodes arrive one run at a time. A cell is analysed when the last of its runs is there, and then forgotten but for the results,
//! so memory does not grow with the episodes. How the pedestrian came to the car is not in the tables: a bounded number of collisions
//! of each kind is repeated to see it.

mod sample;
mod start;
mod repeat;
mod cell;
mod campaign;
mod tables;

pub use campaign::FailureModes;
pub use cell::{CellModes, Mode, Target};
pub use repeat::MOST as MOST_REPEATED;
pub use sample::{MOST_CASES, MOST_FAILURES};
pub use tables::{
    accumulated, explanation_features, explanations, failure_modes, mode_accumulation, mode_counts, references,
};
