//! Reads reports back: the data to repeat an episode, to compare it, and to judge cells.

mod stored;
mod divergence;
mod gate;
mod condition;
mod failures;
mod searches;

pub use condition::GateError;
pub use divergence::divergence;
pub use failures::Touches;
pub use gate::{Gate, Judged, TooFewRuns, requirements_in};
pub use searches::StoredSearch;
pub use stored::{Difference, ReadError, StoredReport, StoredRun, differences};
