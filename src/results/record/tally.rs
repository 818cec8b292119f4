use polars::prelude::{DataFrame, PolarsResult};

use super::EpisodeRow;
use super::columns::{COLLISION, OUTCOME};
use super::episodes::named;
use super::read::Weights;
use base::statistics::Weighted;

/// Counts of some episodes of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    pub episodes: u32,
    /// Those without error, with their weights.
    pub valid: Weighted,
    /// The collisions, with their weights.
    pub collisions: Weighted,
    /// Whether no more episodes are needed.
    pub enough: bool,
}

impl Tally {
    /// Counts the rows of a table of episodes.
    ///
    /// # Errors
    /// A column is missing or holds something else.
    pub fn of(table: &DataFrame) -> PolarsResult<Self> {
        let mut tally = Self::default();
        tally.add_all(table)?;
        Ok(tally)
    }

    /// Adds the rows of a table of episodes to the counts.
    ///
    /// # Errors
    /// As [`Tally::of`].
    pub fn add_all(&mut self, table: &DataFrame) -> PolarsResult<()> {
        let (outcomes, collisions) = (OUTCOME.read(table)?, COLLISION.read(table)?);
        let weights = Weights::read(table)?;
        for row in 0..table.height() {
            let (in_error, hit) = (outcomes.get(row) == Some(named::ERROR), collisions.get(row).unwrap_or_default());
            self.count(weights.get(row), in_error, hit);
        }
        Ok(())
    }

    fn count(&mut self, weight: f64, in_error: bool, collision: bool) {
        self.episodes += 1;
        if !in_error {
            self.valid.include(weight);
        }
        if collision {
            self.collisions.include(weight);
        }
    }

    /// Adds an episode to the counts.
    pub fn add(&mut self, row: &EpisodeRow) {
        self.count(row.weight, row.outcome.fault().is_some(), row.outcome.is_collision());
    }
}
