use polars::prelude::{DataFrame, PolarsResult};

use super::EpisodeRow;
use super::columns::{LEFT_OUT, OUTCOME};
use super::episodes::named;
use super::read::Weights;
use base::statistics::Weighted;

/// Counts of some episodes of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    pub episodes: u32,
    /// Those that count, with their weights: without error, and not left out.
    pub valid: Weighted,
    /// Their collisions, with their weights.
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
        let (outcomes, left_out, weights) = (OUTCOME.read(table)?, LEFT_OUT.read(table)?, Weights::read(table)?);
        for row in 0..table.height() {
            let outcome = outcomes.get(row);
            let counts = outcome != Some(named::ERROR) && left_out.get(row).is_none_or(str::is_empty);
            self.count(weights.get(row), counts, outcome == Some(named::COLLISION));
        }
        Ok(())
    }

    fn count(&mut self, weight: f64, counts: bool, collision: bool) {
        self.episodes += 1;
        if counts {
            self.valid.include(weight);
        }
        if counts && collision {
            self.collisions.include(weight);
        }
    }

    /// Adds an episode to the counts.
    pub fn add(&mut self, row: &EpisodeRow) {
        self.count(row.weight, row.outcome.counts(), row.outcome.is_collision());
    }
}
