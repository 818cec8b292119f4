//! Reports read back: what is needed to repeat an episode, to compare it, and to judge cells.

mod stored;
mod parting;
mod gate;

pub use gate::{Gate, GateError, Judged};
pub use parting::parting;
pub use stored::{Difference, ReadError, StoredFailure, StoredReport, differences, failure};
