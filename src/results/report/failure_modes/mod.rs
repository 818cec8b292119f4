//! Failure modes: samples of a campaign's episodes go to [`analysis`](crate::analysis); classes, clusters and rules come back.
//!
//! Episodes arrive one run at a time. A cell is analysed when the last of its runs is there; then only its results stay in memory. So
//! memory does not grow with the episodes. The tables do not have the approach of the pedestrian, so a bounded number of collisions of
//! each kind is repeated to record it.

mod sample;
mod start;
mod repeat;
mod cell;
mod campaign;
mod tables;

pub use campaign::FailureModes;
pub use cell::{CellModes, Mode, Target};
pub use repeat::MAX_REPEATED;
pub use sample::{MAX_CASES, MAX_FAILURES};
pub use tables::{explanations, failure_modes, references};
