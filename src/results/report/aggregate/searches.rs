use polars::prelude::DataFrame;

use super::requirements::{INSTANT, NO_VERDICT, PART, PRIORITY, REQUIREMENT, ROBUSTNESS, ROBUSTNESS_UNIT};
use super::search_figures::{
    FAILED_STARTS, FAILURE_COUNT, FAULT, FAULT_START_RATE, FAULT_STARTS, FIRST_FAILURE, FIRST_FAULT, FIRST_SIMULATIONS,
    Figures, INJURY, PREVENTABLE,
};
use crate::failure::{Failure, Violation};
use crate::jobs::Find;
use crate::jobs::SearchResult;
use crate::record::columns::{
    BLOCK, DIGEST, DRIVING_MODE, EPISODE_LENGTH, EPISODE_REWARD, IMPACT, IMPACT_SPEED, POLICY, REWARD, RUN, RUN_ID,
    STATE_HASHES, TOWN,
};
use crate::record::{Column, Entry, Signed, Table, verdict_columns};
use compile::SearchKey;
use world::env::Impact;
use world::falsifier;

pub const FALSIFIER: Column<String> = Column::new("falsifier", "", "name of the falsifier");
pub const FAILURE: Column<u64> =
    Column::new("failure", "", "number of the failure in its search, from 0; `RUN_ID:FAILURE` is its name");
pub const START: Column<u64> = Column::new("start", "", "number of its start");
pub const FOUND_AFTER: Column<u64> = Column::new("found_after_ticks", "", "simulator ticks that the search had used");
pub const COMMANDS: Column<String> = Column::new(
    "commands",
    "",
    "`heading@speed` in rad and m/s, one for each decision, in the world frame; equal seeds, starts and commands give equal digests",
);
/// The name of a table of searches.
pub const SEARCHES: &str = "searches";
pub const STARTS: Column<u64> = Column::new(
    "starts",
    "",
    "different starts of these episodes; starts 0, 1, 2, … of a run are the same for all falsifiers",
);
pub const TRIED: Column<String> = Column::new(
    "tried",
    "",
    "numbers of these starts, as `0-31 40`; `archive` leaves starts with a small predicted gain without an episode",
);
pub const FIRST_START: Column<String> = Column::new(
    "first_start",
    "",
    "number of the first of these starts and hash of it as it was drawn: searches with equal ones have the same starts",
);
/// The stem of the files of the table of failures.
pub const FAILURES: &str = "search_failures";

pub const SEARCH_BLOCK: Column<u64> =
    Column::new(BLOCK.name, "", "number of the `search` block in its campaign, from 0");
pub const SEARCH_RUN: Column<u64> = Column::new(RUN.name, "", "number of the run, from 0");
pub const BUDGET: Column<u64> = Column::new("budget_ticks", "", "simulator ticks that each run may use");
/// The columns of a search's key, without the run.
pub fn search_key<'t, R>(key: impl Fn(&R) -> &SearchKey + Copy + 't) -> [Entry<'t, R>; 6] {
    [
        FALSIFIER.of(move |row: &R| key(row).falsifier.clone()),
        Column::<String>::new("method", "", "kind of the falsifier").of(move |row: &R| key(row).method),
        REWARD
            .of(move |row: &R| key(row).reward.clone())
            .meaning("reward that it maximises; empty for a falsifier without a reward"),
        TOWN.of(move |row: &R| key(row).town.clone()),
        POLICY.of(move |row: &R| key(row).policy.clone()),
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
        "One row for each search: a falsifier in one town against one policy, one run. Rates within a search are shares of what it tried, \
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
        "further episodes that are left out: see `left_out` of `episodes`",
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
        "starts from which a failure was found; the fair count between methods that leave a start after a failure \
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
        "simulations up to the first failure, its own included: finished episodes, also those that are left out; \
         missing if none was found",
        |row| row.1.first_simulations,
    )
    .count(PREVENTABLE, "failures that both careful humans avoid", |row| row.1.judged_count(row.1.preventable))
    .count(
        FAULT,
        "failures that count against the driver: see `fault` of `search_failures`, and `goal_fault` where there is a \
         goal; missing where the goal has no verdict, as all figures of faults",
        |row| row.1.judged_count(row.1.fault),
    )
    .count(FAULT_STARTS, "starts from which a fault was found", |row| row.1.judged_count(row.1.fault_starts))
    .number(
        FAULT_START_RATE,
        "their share of `starts`; for an exhaustive search the ceiling of all others",
        |row| row.1.fault_start_rate,
    )
    .number(
        FIRST_FAULT,
        "ticks used when the first fault was found, its own included; missing if none was found",
        |row| row.1.first_fault.map(|ticks| ticks as f64),
    )
    .number(
        INJURY,
        "sum of the severe-injury risks of the faults, for 1,000 of `episodes`: what a careful human would have \
         spared",
        |row| row.1.injury,
    )
    .count(
        "evaluated_episodes",
        "fresh episodes of the controller that the falsifier ended with, outside the budget; their starts are those \
         of `evaluate`",
        |row| row.1.evaluated,
    )
    .count(
        "evaluated_failures",
        "collisions of these, or violations of the goal",
        |row| row.1.evaluated_failures as u64,
    )
    .count("evaluated_faults", "faults of these", |row| row.1.judged_count(row.1.evaluated_faults))
    .number("evaluated_reward", "their mean reward; 0 without a reward", |row| row.1.evaluated_reward)
}

/// The failures of all searches as a table, one row each, in the order in which they were found.
pub fn search_failures(results: &[SearchResult]) -> DataFrame {
    let finds: Vec<Find<'_>> = results.iter().flat_map(SearchResult::finds).collect();
    let mut table = failure_table().frame(&finds);
    if results.iter().any(|result| result.goal().is_some()) {
        table = table
            .hstack(&violation_table().values(&finds.iter().map(Failure::from).collect::<Vec<_>>()))
            .expect("the columns have other names");
    }
    table
}

pub const GOAL_PREVENTABLE: Column<bool> = Column::new(
    "goal_preventable",
    "",
    "whether both careful humans satisfy the goal from the start of the danger on; missing where it has no verdict",
);
pub const GOAL_FORESEEABLE: Column<bool> = Column::new(
    "goal_foreseeable",
    "",
    "whether the pedestrian of the violation moved as people do; missing where the goal has no verdict",
);
pub const GOAL_FAULT: Column<bool> = Column::new(
    "goal_fault",
    "",
    "whether the violation counts against the driver: see `fault` of `requirements`; missing where the goal has no verdict",
);

/// The columns of the violations of goals; empty of collisions.
fn violation_table() -> Table<'static, Failure> {
    fn of<T>(value: impl Fn(&Violation) -> T) -> impl Fn(&Failure) -> Option<T> {
        move |row| row.violation.as_ref().map(&value)
    }
    let judged =
        |value: fn(&Failure) -> bool| move |row: &Failure| row.violation.as_ref()?.preventable.map(|_| value(row));
    Table::new("", "")
        .column(REQUIREMENT.of(of(|found| found.requirement.clone())))
        .column(PRIORITY.of(of(|found| found.priority)))
        .column(ROBUSTNESS.of(|row: &Failure| Signed(row.violation.as_ref().map(|found| found.robustness))))
        .column(ROBUSTNESS_UNIT.of(of(|found| found.unit.clone())))
        .column(INSTANT.of(|row: &Failure| row.violation.as_ref().map(|_| row.length)))
        .column(
            PART.of(|row: &Failure| {
                row.violation.as_ref().map(|found| found.part.clone()).filter(|part| !part.is_empty())
            }),
        )
        .column(GOAL_PREVENTABLE.of(|row: &Failure| row.violation.as_ref()?.preventable))
        .column(GOAL_FORESEEABLE.of(judged(|row| row.foreseeable)))
        .column(GOAL_FAULT.of(judged(|row| row.fault)))
        .column(NO_VERDICT.of(of(|found| found.no_verdict.clone())))
}

/// The columns of [`search_failures`] that all failures have.
pub fn failure_table<'a>() -> Table<'a, Find<'a>> {
    type Row<'a> = Find<'a>;
    let doc = "One row for each failure that a search found, with the commands that lead to it; `searches` has the search of `run_id`. Where a search has a goal, `requirement`, \
               `priority`, `robustness`, `unit`, `instant_s` and `part` follow, as in `requirements`, and `goal_preventable`, `goal_foreseeable`, \
               `goal_fault` and `no_verdict`.";
    Table::new(FAILURES, doc)
        .column(RUN_ID.of(|row: &Row<'_>| row.id.to_string()))
        .column(TOWN.of(|row: &Row<'_>| row.key.town.clone()))
        .column(POLICY.of(|row: &Row<'_>| row.key.policy.clone()))
        .column(FAILURE.of(|row: &Row<'_>| row.number as u64))
        .column(START.of(|row: &Row<'_>| row.failure.start))
        .column(FOUND_AFTER.of(|row: &Row<'_>| row.failure.ticks))
        .column(IMPACT.of(|row: &Row<'_>| Impact::of(&row.failure.outcome).map(Impact::name)))
        .column(DRIVING_MODE.of(|row: &Row<'_>| row.failure.outcome.last_mode.name()))
        .column(IMPACT_SPEED.of(|row: &Row<'_>| row.failure.outcome.impact_speed()))
        .column(EPISODE_REWARD.of(|row: &Row<'_>| row.failure.outcome.reward))
        .column(EPISODE_LENGTH.of(|row: &Row<'_>| row.failure.outcome.duration))
        .column(COMMANDS.of(|row: &Row<'_>| commands(row.failure)))
        .column(DIGEST.of(|row: &Row<'_>| format!("{:016x}", row.failure.outcome.digest)))
        .column(STATE_HASHES.of(|row: &Row<'_>| row.failure.outcome.state_hashes.to_string()))
        .columns(verdict_columns(|row: &Row<'_>| row.verdict()))
}

/// Commands as `heading@speed` (rad, m/s), with all digits that are needed to read the same numbers back.
fn commands(failure: &falsifier::Failure) -> String {
    let each = failure.commands.iter().map(|command| format!("{}@{}", command.heading, command.speed));
    each.collect::<Vec<_>>().join(" ")
}
