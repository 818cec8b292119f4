//! Reads reports back: the data to repeat an episode, to compare it, and to judge cells.

mod stored;
mod divergence;
mod gate;

pub use divergence::divergence;
pub use gate::{Gate, GateError, Judged};
pub use stored::{Difference, ReadError, StoredFailure, StoredReport, differences, failure};
