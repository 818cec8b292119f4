use std::fmt;

use super::aggregate::{Cell, SearchCell};
use super::lost::{LostDriver, lost};
use crate::campaign::SearchResult;

/// What a reader must know before the figures of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Caution {
    /// A driver often does not reach its starts, or leaves the road.
    Lost(LostDriver),
    /// A search had no episode.
    EmptySearch {
        /// Its falsifier, town and driver.
        search: String,
        /// Simulator ticks that each run might use.
        budget: u64,
    },
}

impl fmt::Display for Caution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost(driver) => driver.fmt(f),
            Self::EmptySearch { search, budget } => write!(
                f,
                "{search} searched nothing: none of its episodes fits into a `budget` of {budget} ticks, so nothing is known; give a greater one"
            ),
        }
    }
}

/// All of them: of drivers, then of searches.
pub fn cautions(cells: &[Cell], results: &[SearchResult], searches: &[SearchCell]) -> Vec<Caution> {
    // Episodes that are left out fitted into the budget; why they are is said of the driver.
    let is_lost = |search: &SearchCell| {
        let mut own = results.iter().filter(|result| result.key.is_of_same_cell(&search.key));
        own.any(|result| result.spent.left_out > 0)
    };
    let empty = searches.iter().filter(|search| search.is_empty() && !is_lost(search));
    let empty = empty.map(|search| Caution::EmptySearch { search: search.in_full(), budget: search.budget });
    lost(cells, results).into_iter().map(Caution::Lost).chain(empty).collect()
}
