//! The searches of a report with what they found, to compare them with those of another.

use std::collections::BTreeMap;

use super::{ReadError, StoredReport};
use crate::failure::Failure;
use crate::record::Column;
use crate::record::columns::{DRIVER, REWARD, RUN_ID, TOWN};
use crate::report::aggregate::SEARCHES;
use crate::tables::{BUDGET, FIRST_START, METHOD, SEARCH_BLOCK, SEARCH_RUN, TRIED};
use search::StartSet;

/// The number of rows of a table that are read at once.
const ROWS: usize = 1 << 12;

/// A search of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSearch {
    pub falsifier: String,
    /// The reward that it maximises; empty without one.
    pub reward: String,
    pub town: String,
    /// The driver.
    pub policy: String,
    /// Number of its block in the campaign, from 0.
    pub block: u64,
    /// Number of its run, from 0.
    pub run: u64,
    /// Simulator ticks that it might use.
    pub budget: u64,
    /// The starts that it tried.
    pub starts: StartSet,
    /// Number and hash of the first of them; `None` without one.
    pub first_start: Option<String>,
    /// Its failures, in the order in which it found them.
    pub failures: Vec<Failure>,
}

impl StoredReport {
    /// The searches, in the order of their table.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn searches(&self) -> Result<Vec<StoredSearch>, ReadError> {
        let mut found: BTreeMap<String, Vec<Failure>> = BTreeMap::new();
        for failure in self.failures()?.into_iter().filter(|failure| failure.is_of_search() && failure.is_failure()) {
            found.entry(failure.key.id.to_string()).or_default().push(failure);
        }
        let mut searches = Vec::new();
        self.each_part(SEARCHES, ROWS, |rows| {
            let text = |column: &Column<String>, row: usize| column.value(rows, row).map(Option::unwrap_or_default);
            let number = |column: &Column<u64>, row: usize| column.value(rows, row).map(Option::unwrap_or_default);
            for row in 0..rows.height() {
                let first = FIRST_START.value(rows, row)?.filter(|text| !text.is_empty());
                searches.push(StoredSearch {
                    falsifier: text(&METHOD, row)?,
                    reward: text(&REWARD, row)?,
                    town: text(&TOWN, row)?,
                    policy: text(&DRIVER, row)?,
                    block: number(&SEARCH_BLOCK, row)?,
                    run: number(&SEARCH_RUN, row)?,
                    budget: number(&BUDGET, row)?,
                    starts: text(&TRIED, row)?.parse().unwrap_or_default(),
                    first_start: first,
                    failures: found.remove(&text(&RUN_ID, row)?).unwrap_or_default(),
                });
            }
            Ok(())
        })?;
        Ok(searches)
    }
}
