use polars::prelude::DataFrame;

use super::search_figures::{
    FAILED_STARTS, FAILURE_COUNT, FAULT, FAULT_STARTS, FIRST_FAILURE, FIRST_SIMULATIONS, Figures, INJURY,
};
use crate::jobs::SearchResult;
use crate::record::columns::{BLOCK, DRIVER, REWARD, RUN, RUN_ID, TOWN};
use crate::record::{Column, Entry, Table};
use compile::SearchKey;

pub const METHOD: Column<String> = Column::new("method", "", "the search, by the name of its method");
/// The name of a table of searches.
pub const SEARCHES: &str = "searches";
pub const STARTS: Column<u64> = Column::new(
    "starts",
    "",
    "different starts of these episodes; starts 0, 1, 2, … of a run are the same for all searches",
);
pub const TRIED: Column<String> = Column::new("tried", "", "numbers of these starts, as `0-31 40`");
pub const FIRST_START: Column<String> = Column::new(
    "first_start",
    "",
    "number of the first of these starts and hash of it as it was drawn; searches with equal ones have the same starts",
);
pub const SEARCH_BLOCK: Column<u64> =
    Column::new(BLOCK.name, "", "number of the `search` block in its campaign, from 0");
pub const SEARCH_RUN: Column<u64> = Column::new(RUN.name, "", RUN.doc);
pub const BUDGET: Column<u64> = Column::new("budget_ticks", "", "simulator ticks that each run may use");
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

pub type Searched<'a> = (&'a SearchResult, Figures);

/// Searches as a table, one row each, in the order given.
pub fn searches(results: &[SearchResult]) -> DataFrame {
    let rows: Vec<Searched<'_>> = results.iter().map(|result| (result, Figures::new(result))).collect();
    search_table().frame(&rows)
}

/// The columns of [`searches`].
pub fn search_table<'a>() -> Table<'a, Searched<'a>> {
    type Row<'a> = Searched<'a>;
    Table::new(
        SEARCHES,
        "One row for each search: a method in one town against one driver, one run. Rates within a search are shares of what it tried, \
         not the failure rate of the driver.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.0.id.to_string()))
    .columns(search_key(|row: &Row<'_>| &row.0.key))
    .column(SEARCH_RUN.of(|row: &Row<'_>| u64::from(row.0.key.run)))
    .column(BUDGET.of(|row: &Row<'_>| row.0.budget))
    .count(
        "used_ticks",
        "simulator ticks that it used; less than a command is left over, more by `ppo` with several environments, \
         which stops when the first has used its share",
        |row| row.0.spent.ticks,
    )
    .count(
        "episodes",
        "episodes that came to an end and count, without one that the budget cut off",
        |row| row.0.spent.episodes,
    )
    .count(
        "left_out_episodes",
        "further episodes that are left out; see `left_out` of `episodes`",
        |row| row.0.spent.left_out,
    )
    .column(STARTS.of(|row: &Row<'_>| row.0.spent.starts.count()))
    .column(TRIED.of(|row: &Row<'_>| row.0.spent.starts.to_string()))
    .column(FIRST_START.of(|row: &Row<'_>| row.0.spent.first_start.map(|(number, hash)| format!("{number}:{hash:016x}"))))
    .count(
        FAILURE_COUNT,
        "episodes that ended in a collision, or that violate the goal of the search",
        |row| row.1.failures as u64,
    )
    .count(
        FAILED_STARTS,
        "starts from which a failure was found; the fair count between searches that leave a start after a failure \
         (`cem`, `cma_es`, `mcts`) and those that walk once from each",
        |row| row.1.failed_starts as u64,
    )
    .number(
        FIRST_FAILURE,
        "ticks used when the first was found, its own included; missing if none was found",
        |row| row.1.first.map(|ticks| ticks as f64),
    )
    .count(
        FIRST_SIMULATIONS,
        "simulations up to the first failure, its own included; finished episodes, also those that are left out; \
         missing if none was found",
        |row| row.1.first_simulations,
    )
    .count(
        FAULT,
        "failures that count against the driver; missing where the goal has no verdict, as \
         all figures of faults",
        |row| row.1.judged_count(row.1.fault),
    )
    .count(FAULT_STARTS, "starts from which a fault was found", |row| row.1.judged_count(row.1.fault_starts))
    .number(
        INJURY,
        "sum of the severe-injury risks of the faults, for 1,000 of `episodes`; what a careful human would have \
         spared",
        |row| row.1.injury,
    )
    .count(
        "evaluated_episodes",
        "fresh episodes of the pedestrian that the search ended with, outside the budget; their starts are those \
         of `evaluate`",
        |row| row.1.evaluated,
    )
    .count("evaluated_faults", "faults of these", |row| row.1.judged_count(row.1.evaluated_faults))
}
