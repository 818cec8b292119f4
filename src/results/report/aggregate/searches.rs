use std::collections::BTreeSet;

use polars::prelude::DataFrame;

use crate::jobs::SearchResult;
use crate::record::columns::{DRIVER, REWARD, RUN_ID, TOWN};
use crate::record::{Column, Entry, Table, TableReference, entries, in_block};
use crate::tables::metrics::RUNS;
use crate::tables::{
    self, BUDGET, EVALUATED_EPISODES, EVALUATED_FAULTS, FAILED_STARTS, FAILURE_COUNT, FALSIFIED, FAULT_COUNT,
    FAULT_START_RATE, FAULT_STARTS, FIRST_FAILURE, FIRST_FAULT, FIRST_SIMULATIONS, FIRST_START, GOAL, INJURY, METHOD,
    PAIR, PLACE, PREVENTABLE_COUNT, Rate, Row, Rows, SEARCH_BLOCK, SEARCH_EPISODES, SEARCH_RUN, STARTS, TRIED, USED,
};
use compile::SearchKey;
use search::Failure;
use verdict::Blame;

/// The name of a table of searches.
pub const SEARCHES: &str = "searches";

/// The columns of a search's key, without the run.
pub fn search_key<'t, R>(key: impl Fn(&R) -> &SearchKey + Copy + 't) -> [Entry<'t, R>; 5] {
    [
        METHOD.of(move |row: &R| key(row).falsifier.clone()),
        REWARD
            .of(move |row: &R| key(row).reward.clone())
            .meaning("reward that it maximises; empty for a search without a reward"),
        TOWN.of(move |row: &R| key(row).town.clone()),
        DRIVER.of(move |row: &R| key(row).policy.clone()),
        SEARCH_BLOCK.of(move |row: &R| u64::from(key(row).block)),
    ]
}

/// Searches as a table, one row each, in the order given.
pub fn searches(results: &[SearchResult]) -> DataFrame {
    search_table().frame(results)
}

/// The columns of [`searches`].
pub fn search_table() -> Table<'static, SearchResult> {
    type Row = SearchResult;
    Table::new(
        SEARCHES,
        "One row for each search: a method in one town against one driver, one run. Rates within a search are shares of what it tried, \
         not the failure rate of the driver.",
    )
    .column(RUN_ID.of(|row: &Row| row.id.to_string()))
    .columns(search_key(|row: &Row| &row.key))
    .columns(entries! { row: &SearchResult;
        SEARCH_RUN = u64::from(row.key.run);
        BUDGET = row.budget;
        /// simulator ticks that it used; less than a command is left over, more by `ppo` with several environments, which stops when the first has used its
        /// share
        named(USED): u64 = row.spent.ticks;
        /// episodes that came to an end and count, without one that the budget cut off
        named(SEARCH_EPISODES): u64 = row.spent.episodes;
        /// further episodes that are left out; see `left_out` of `episodes`
        left_out_episodes: u64 = row.spent.left_out;
        STARTS = row.spent.starts.count();
        TRIED = row.spent.starts.to_string();
        FIRST_START = row.spent.first_start.map(|(number, hash)| format!("{number}:{hash:016x}"));
        /// episodes that ended in a collision, or that violate the goal of the search
        named(FAILURE_COUNT): u64 = row.spent.failures.len() as u64;
        /// starts from which a failure was found; the fair count between searches that leave a start after a failure (`cem`, `cma_es`, `mcts`) and those that
        /// walk once from each
        named(FAILED_STARTS): u64 = count_starts(row.spent.failures.iter());
        /// ticks used when the first was found, its own included; missing if none was found
        named(FIRST_FAILURE): f64 = row.spent.failures.first().map(|failure| failure.ticks as f64);
        /// simulations up to the first failure, its own included; finished episodes, also those that are left out; missing if none was found
        named(FIRST_SIMULATIONS): u64 = row.spent.failures.first().map(|failure| failure.simulations);
        /// failures that count against the driver; missing where the goal has no verdict, as all figures of faults
        named(FAULT_COUNT): u64 = row.is_judged().then(|| faults(row).count() as u64);
        /// starts from which a fault was found
        named(FAULT_STARTS): u64 = row.is_judged().then(|| count_starts(faults(row)));
        /// sum of the severe-injury risks of the faults, for 1,000 of `episodes`; what a careful human would have spared
        named(INJURY): f64 = injury(row);
        /// fresh episodes of the pedestrian that the search ended with, outside the budget; their starts are those of `evaluate`
        named(EVALUATED_EPISODES): u64 = evaluated(row, None);
        /// faults of these
        named(EVALUATED_FAULTS): u64 = row.is_judged().then(|| evaluated(row, Some(Blame::Fault)));
    })
}

/// What the tables made of searches need besides.
fn more() -> [Entry<'static, SearchResult>; 4] {
    let count = Column::<u64>::new;
    let rate = |row: &SearchResult| {
        let starts = row.spent.starts.count();
        (starts > 0 && row.is_judged()).then(|| count_starts(faults(row)) as f64 / starts as f64)
    };
    [
        GOAL.of(|row: &SearchResult| row.goal().map(|named| named.name.to_string())),
        count(PREVENTABLE_COUNT, "", "")
            .of(|row: &SearchResult| row.failures().filter(|find| find.is(Blame::Preventable)).count() as u64),
        Column::<f64>::new(FAULT_START_RATE, "", "").of(rate),
        count(FIRST_FAULT, "", "").of(|row: &SearchResult| faults(row).map(|failure| failure.ticks).min()),
    ]
}

/// The faults that a search found.
fn faults(result: &SearchResult) -> impl Iterator<Item = &Failure> {
    result.failures().filter(|find| find.is(Blame::Fault)).map(|find| find.failure)
}

/// The number of different starts of failures.
fn count_starts<'a>(failures: impl Iterator<Item = &'a Failure>) -> u64 {
    failures.map(|failure| failure.start).collect::<BTreeSet<_>>().len() as u64
}

/// The avoidable injury of a thousand episodes; `None` without any.
fn injury(result: &SearchResult) -> Option<f64> {
    let injury: f64 = result.failures().filter_map(|find| Some(find.verdict()?.avoidable_injury())).sum();
    (result.spent.episodes > 0).then(|| injury * 1000.0 / result.spent.episodes as f64)
}

/// The number of fresh episodes that count, or of those that count against the driver in this way.
fn evaluated(result: &SearchResult, blame: Option<Blame>) -> u64 {
    let is = |blame, each: &verdict::Judged| each.is(result.criterion(), blame);
    let counted = result.evaluated.iter().filter(|each| each.outcome.counts());
    counted.filter(|each| blame.is_none_or(|blame| is(blame, each))).count() as u64
}

/// The searches with the further columns that the tables made of them need.
pub fn all_of_searches(results: &[SearchResult]) -> DataFrame {
    search_table().columns(more()).frame(results)
}

/// All runs of a falsifier in one town against one driver.
pub type SearchCell = Row<SearchKey>;

/// The cells of searches, in the order of first appearance, with the key of the first run.
///
/// # Panics
/// Never: a table of searches has these columns.
pub fn search_cells(results: &[SearchResult], searches: &DataFrame) -> Rows<SearchKey> {
    if results.is_empty() {
        return Rows::default();
    }
    let first = |table: &DataFrame, row| Ok(results[PLACE.value(table, row)?.unwrap_or_default() as usize].key.clone());
    let cells = tables::search_cells(searches).and_then(|cells| Rows::new(cells, first));
    cells.expect("a bug: a table of searches has its columns")
}

/// The documentation of the table of cells of searches.
pub fn search_cell_reference() -> TableReference {
    let keys = Table::new("search_cells", "One row for each search, town and driver, over all runs.")
        .columns(search_key(|key: &SearchKey| key));
    let mut all = keys.reference();
    all.columns.push(Column::<u64>::new("runs", "", "number of runs").reference());
    all.columns.extend(tables::search_cell_columns());
    all
}

impl Row<SearchKey> {
    /// A figure over the runs, with its interval.
    pub fn rate(&self, figure: &str) -> Rate {
        self.figure(figure, "")
    }

    /// The number of its runs, and of those that found a failure.
    pub fn runs(&self) -> [u64; 2] {
        [RUNS.name, FALSIFIED].map(|column| self.whole_number(column))
    }

    /// The budget of each run (simulator ticks).
    pub fn budget(&self) -> u64 {
        self.whole_number(BUDGET.name)
    }

    /// Whether no run tried a start, so that nothing is known.
    pub fn is_empty(&self) -> bool {
        self.rate(STARTS.name).value == Some(0.0)
    }

    /// Its name, for people.
    pub fn in_full(&self) -> String {
        let key = &self.key;
        format!("{}{} in {} against {}", key.falsifier, in_block("search", key.block), key.town, key.policy)
    }
}

/// Two searches, or two drivers, of one town, compared by a figure, with the number of the pair.
pub type SearchPair = Row<u64>;

pub(crate) fn search_pairs(searches: &DataFrame) -> Rows<u64> {
    let number = |table: &DataFrame, row| Ok(PAIR.value(table, row)?.unwrap_or_default());
    let pairs = tables::search_pairs(searches).and_then(|pairs| Rows::new(pairs, number));
    pairs.expect("a bug: a table of searches has its columns")
}
