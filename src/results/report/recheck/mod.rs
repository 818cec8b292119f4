//! A new version of a driver in the encounters of an old report, and in crossings that never change.
//!
//! The old failures are a biased choice: the old driver failed in all of them, so another driver fails in fewer. They show whether a fault is
//! gone, not which driver is better. That is what the fixed list is for: both drivers meet the same crossings from the same starts.

mod encounter;
mod failures;
mod crossings;
mod note;
mod table;

pub use crossings::CrossedStarts;
pub use encounter::{Encounter, Encounters, RerunOutcome};
pub use failures::{RecheckedFailures, WalkedBy};
pub use note::RecheckNote;
pub use table::{NOT_MET, crossed_reference, crossed_table, rechecked_reference, rechecked_table};

use std::path::PathBuf;

/// The result of a recheck.
#[derive(Debug, Clone)]
pub struct Recheck {
    /// The folder of the old report.
    pub report: PathBuf,
    /// The files of the new driver; `None` if they are those of the report.
    pub files: Vec<PathBuf>,
    /// What a reader of the result must know.
    pub notes: Vec<RecheckNote>,
    /// The failures of the report, met again.
    pub failures: Vec<RecheckedFailures>,
    /// The fixed list.
    pub crossings: Vec<CrossedStarts>,
}

impl Recheck {
    /// The number of encounters in which a driver failed as a program.
    pub fn errors(&self) -> u64 {
        let failures = self.failures.iter().map(|row| &row.encounters);
        failures.chain(self.crossings.iter().map(|row| &row.encounters)).map(Encounters::errors).sum()
    }
}
