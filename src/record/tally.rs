use polars::prelude::{DataFrame, PolarsResult};

use super::EpisodeRow;
use super::columns::{COLLISION, OUTCOME};
use super::episodes::named;

/// Some episodes of an evaluation, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// The number of episodes.
    pub episodes: u32,
    /// The number without error.
    pub valid: u64,
    /// The number of collisions.
    pub collisions: u64,
    /// Whether no more are needed.
    pub enough: bool,
}

impl Tally {
    /// Counts the rows of a table of episodes.
    ///
    /// # Errors
    /// A column is missing or holds something else.
    pub fn of(table: &DataFrame) -> PolarsResult<Self> {
        let errors = OUTCOME.read(table)?.iter().filter(|outcome| *outcome == Some(named::ERROR)).count();
        Ok(Self {
            episodes: table.height() as u32,
            valid: (table.height() - errors) as u64,
            collisions: u64::from(COLLISION.read(table)?.sum().unwrap_or_default()),
            enough: false,
        })
    }

    /// Counts an episode too.
    pub fn add(&mut self, row: &EpisodeRow) {
        self.episodes += 1;
        self.valid += u64::from(row.outcome.fault().is_none());
        self.collisions += u64::from(row.outcome.is_collision());
    }
}
