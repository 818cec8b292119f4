use std::collections::BTreeSet;

use polars::prelude::DataFrame;

use super::survival::{MedianTime, median_time};
use crate::analysis::Impact;
use crate::campaign::{Evaluated, SearchResult};
use crate::compile::SearchKey;
use crate::env::{Ending, Outcome};
use crate::falsifier::Failure;
use crate::judge::Verdict;
use crate::record::columns::{
    BLOCK, DIGEST, DRIVING_MODE, EPISODE_LENGTH, EPISODE_REWARD, IMPACT, IMPACT_SPEED, MOTION, POLICY, REWARD, RUN,
    RUN_ID, STATE_HASHES, TOWN,
};
use crate::record::metric::MEAN;
use crate::record::{Column, Entry, Interval, Table, verdict_columns};
use crate::statistics::mean_interval;

/// The figures of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    ticks: u64,
    failures: usize,
    failed_starts: usize,
    failure_rate: Option<f64>,
    first: Option<u64>,
    distinct: usize,
    /// The number of failures, and the number of their cells, of those that are preventable and of those that are attributable.
    preventable: [usize; 2],
    attributable: [usize; 2],
    attributable_rate: Option<f64>,
    attributable_starts: usize,
    attributable_start_rate: Option<f64>,
    evaluated_collisions: usize,
    evaluated_rate: Option<f64>,
    evaluated_attributable: usize,
    evaluated_attributable_rate: Option<f64>,
    evaluated_reward: Option<f64>,
}

impl Figures {
    /// The figures by which two searches are compared, with their names.
    pub(super) fn compared(&self) -> [(&'static str, Option<f64>); 4] {
        [
            (DISTINCT_PER_MILLION, per_million(self.attributable[1], self.ticks)),
            (ATTRIBUTABLE_RATE, self.attributable_rate),
            (ATTRIBUTABLE_START_RATE, self.attributable_start_rate),
            (EVALUATED_ATTRIBUTABLE_RATE, self.evaluated_attributable_rate),
        ]
    }

    pub(super) fn new(result: &SearchResult) -> Self {
        let spent = &result.spent;
        let share = |part: usize, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        let cells: BTreeSet<_> = spent.failures.iter().map(|failure| failure.cell).collect();
        let judged = |counts: fn(&Verdict) -> bool| {
            let found = spent.failures.iter().zip(&result.verdicts);
            let found = found.filter(|(_, verdict)| verdict.as_ref().is_some_and(counts));
            let cells: Vec<_> = found.map(|(failure, _)| failure.cell).collect();
            [cells.len(), cells.into_iter().collect::<BTreeSet<_>>().len()]
        };
        let found = spent.failures.iter().zip(&result.verdicts);
        let faults = found.filter(|(_, verdict)| verdict.as_ref().is_some_and(Verdict::is_attributable));
        let attributable_starts = faults.map(|(failure, _)| failure.start).collect::<BTreeSet<_>>().len();
        let (evaluated, number) = (&result.evaluated, result.evaluated.len() as u64);
        let evaluated_collisions = evaluated.iter().filter(|each| each.outcome.is_collision()).count();
        let attributable = |each: &&Evaluated| each.verdict.as_ref().is_some_and(Verdict::is_attributable);
        let evaluated_attributable = evaluated.iter().filter(attributable).count();
        let reward: f64 = evaluated.iter().map(|each| each.outcome.reward).sum();
        Self {
            ticks: spent.ticks,
            failures: spent.failures.len(),
            failed_starts: spent.failures.iter().map(|failure| failure.start).collect::<BTreeSet<_>>().len(),
            failure_rate: share(spent.failures.len(), spent.episodes),
            first: spent.failures.first().map(|failure| failure.ticks),
            distinct: cells.len(),
            preventable: judged(Verdict::is_preventable),
            attributable: judged(Verdict::is_attributable),
            attributable_rate: share(judged(Verdict::is_attributable)[0], spent.episodes),
            attributable_starts,
            attributable_start_rate: share(attributable_starts, spent.starts.count()),
            evaluated_collisions,
            evaluated_rate: share(evaluated_collisions, number),
            evaluated_attributable,
            evaluated_attributable_rate: share(evaluated_attributable, number),
            evaluated_reward: (number > 0).then(|| reward / number as f64),
        }
    }
}

/// The kind of a failure: the side of the car that was hit, whether it moved, and what its driver was doing.
fn kind(outcome: &Outcome) -> (Impact, bool, &'static str) {
    match outcome.ending {
        Ending::Collision { front, moving, bearing, .. } => {
            (Impact::new(front, bearing), moving, outcome.last_mode.name())
        }
        _ => unreachable!("a failure is a collision"),
    }
}

/// The number of events in a million ticks.
fn per_million(count: usize, ticks: u64) -> Option<f64> {
    (ticks > 0).then(|| count as f64 * 1e6 / ticks as f64)
}

/// All runs of a falsifier in one town against one policy, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchCell {
    /// The falsifier, the town and the policy; the run is the first.
    pub key: SearchKey,
    /// The budget of each run (simulator ticks).
    pub budget: u64,
    /// The number of runs.
    pub runs: usize,
    /// The number of runs without a failure.
    pub censored: usize,
    /// Ticks to the first failure.
    pub first_failure: MedianTime,
    /// Share of the episodes that failed. This and the following are means over runs with intervals.
    pub failure_rate: Average,
    /// Failures.
    pub failures: Average,
    /// The number of starts from which a failure was found.
    pub failed_starts: Average,
    /// The number of kinds of failures.
    pub distinct: Average,
    /// Preventable failures.
    pub preventable: Average,
    /// Preventable failures with a foreseeable pedestrian.
    pub attributable: Average,
    /// These in a million ticks.
    pub attributable_per_million: Average,
    /// Kinds of these in a million ticks.
    pub distinct_attributable_per_million: Average,
    /// Collision rate of the walk policy that it ended up with.
    pub evaluated_rate: Average,
    /// Share of the controller's episodes that ended in an attributable collision.
    pub evaluated_attributable_rate: Average,
    /// Share of the search's own episodes that ended in an attributable collision.
    pub attributable_rate: Average,
    /// Share of the starts from which it found one.
    pub attributable_start_rate: Average,
}

impl SearchCell {
    /// Its name, for people.
    pub fn in_full(&self) -> String {
        let key = &self.key;
        let block = if key.block == 0 { String::new() } else { format!(" #{}", key.block) };
        format!("{}{block} in {} against {}", key.falsifier, key.town, key.policy)
    }
}

/// A mean over runs with Student's 95 % interval. The mean is none without a value, the interval with fewer than two values.
pub type Average = (Option<f64>, Option<(f64, f64)>);

fn average(values: impl Iterator<Item = Option<f64>>) -> Average {
    let values: Vec<f64> = values.flatten().collect();
    if values.is_empty() {
        return (None, None);
    }
    let (mean, interval) = mean_interval(&values);
    // No averaged value can be below 0.
    (Some(mean), interval.map(|(low, high)| (low.max(0.0), high)))
}

/// Gathers runs into cells, in the order of first appearance.
pub fn search_cells(results: &[SearchResult]) -> Vec<SearchCell> {
    let mut cells: Vec<Vec<&SearchResult>> = Vec::new();
    for result in results {
        match cells.iter_mut().find(|cell| cell[0].key.is_of_same_cell(&result.key)) {
            Some(cell) => cell.push(result),
            None => cells.push(vec![result]),
        }
    }
    cells.iter().map(|cell| gather(cell)).collect()
}

fn gather(cell: &[&SearchResult]) -> SearchCell {
    let figures: Vec<Figures> = cell.iter().map(|result| Figures::new(result)).collect();
    let times: Vec<(f64, bool)> = figures
        .iter()
        .zip(cell)
        .map(|(figures, result)| (figures.first.unwrap_or(result.spent.ticks) as f64, figures.first.is_some()))
        .collect();
    let over = |value: &dyn Fn(&Figures) -> Option<f64>| average(figures.iter().map(value));
    SearchCell {
        key: cell[0].key.clone(),
        budget: cell[0].budget,
        runs: cell.len(),
        censored: figures.iter().filter(|figures| figures.first.is_none()).count(),
        first_failure: median_time(&times),
        failure_rate: share(over(&|figures| figures.failure_rate)),
        failures: over(&|figures| Some(figures.failures as f64)),
        failed_starts: over(&|figures| Some(figures.failed_starts as f64)),
        distinct: over(&|figures| Some(figures.distinct as f64)),
        preventable: over(&|figures| Some(figures.preventable[0] as f64)),
        attributable: over(&|figures| Some(figures.attributable[0] as f64)),
        attributable_per_million: over(&|figures| per_million(figures.attributable[0], figures.ticks)),
        distinct_attributable_per_million: over(&|figures| per_million(figures.attributable[1], figures.ticks)),
        evaluated_rate: share(over(&|figures| figures.evaluated_rate)),
        evaluated_attributable_rate: share(over(&|figures| figures.evaluated_attributable_rate)),
        attributable_rate: share(over(&|figures| figures.attributable_rate)),
        attributable_start_rate: share(over(&|figures| figures.attributable_start_rate)),
    }
}

/// Cuts the interval of a share at 1.
fn share((mean, interval): Average) -> Average {
    (mean, interval.map(|(low, high)| (low, high.min(1.0))))
}

/// The falsifier of a search.
/// Name of the falsifier.
pub const FALSIFIER: Column<String> = Column::new("falsifier", "", "name of the falsifier");
/// Its number in the search.
pub const FAILURE: Column<u64> =
    Column::new("failure", "", "number of the failure in its search, from 0; `RUN_ID:FAILURE` is its name");
/// The start.
pub const START: Column<u64> = Column::new("start", "", "number of its start");
/// Ticks when it was found.
pub const FOUND_AFTER: Column<u64> = Column::new("found_after_ticks", "", "simulator ticks that the search had used");
/// The commands of the pedestrian.
pub const COMMANDS: Column<String> = Column::new(
    "commands",
    "",
    "`heading@speed` in rad and m/s, one for each decision, in the world frame; equal seeds, starts and commands give equal digests",
);
/// The cell of a failure.
const CELL: Column<String> = Column::new(
    "cell",
    "",
    "how the two met: place on the car, direction of the walk relative to the car, impact speed in m/s, walking speed in m/s, the driver's \
     mode; failures in one cell count as one finding",
);
/// The name of a table of searches.
pub const SEARCHES: &str = "searches";
/// The number of starts of a search.
pub const STARTS: Column<u64> = Column::new(
    "starts",
    "",
    "different starts of these episodes; starts 0, 1, 2, … of a run are the same for all falsifiers",
);
/// The numbers of these starts.
pub const TRIED: Column<String> = Column::new(
    "tried",
    "",
    "numbers of these starts, as `0-31 40`; `archive` leaves starts that promise little without an episode",
);
/// The hash of the first start.
pub const FIRST_START: Column<String> = Column::new(
    "first_start",
    "",
    "number of the first of these starts and hash of it as it was drawn: searches with equal ones have the same starts",
);
/// The stem of the files of the table of failures.
pub const FAILURES: &str = "search_failures";

/// The number of its block.
pub const SEARCH_BLOCK: Column<u64> =
    Column::new(BLOCK.name, "", "number of the `search` block in its campaign, from 0");
/// The number of its run.
pub const SEARCH_RUN: Column<u64> = Column::new(RUN.name, "", "number of the run, from 0");
/// The budget of each run.
pub const BUDGET: Column<u64> = Column::new("budget_ticks", "", "simulator ticks that each run may use");
// The columns of searches that cells of searches summarise.
const FAILURE_COUNT: &str = "failures";
const FAILURE_RATE: &str = "failure_rate";
const FAILED_STARTS: &str = "failed_starts";
const FIRST_FAILURE: &str = "first_failure_ticks";
const DISTINCT: &str = "distinct_failures";
const PREVENTABLE: &str = "preventable_failures";
const ATTRIBUTABLE: &str = "attributable_failures";
const ATTRIBUTABLE_RATE: &str = "attributable_rate";
const ATTRIBUTABLE_START_RATE: &str = "attributable_start_rate";
const ATTRIBUTABLE_PER_MILLION: &str = "attributable_per_million_ticks";
const DISTINCT_PER_MILLION: &str = "distinct_attributable_per_million_ticks";
const EVALUATED_RATE: &str = "evaluated_rate";
const EVALUATED_ATTRIBUTABLE_RATE: &str = "evaluated_attributable_rate";

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

/// The number of a search's run.
fn run<'t, R>(key: impl Fn(&R) -> &SearchKey + 't) -> Entry<'t, R> {
    SEARCH_RUN.of(move |row: &R| u64::from(key(row).run))
}

/// A search with its figures.
pub type Searched<'a> = (&'a SearchResult, Figures);

/// Searches as a table, one row each, in the order given.
pub fn searches(results: &[SearchResult]) -> DataFrame {
    let rows: Vec<Searched<'_>> = results.iter().map(|result| (result, Figures::new(result))).collect();
    search_table().frame(&rows)
}

/// The columns of [`searches`].
pub fn search_table<'a>() -> Table<'a, Searched<'a>> {
    type Row<'a> = Searched<'a>;
    let (count, number) = (Column::<u64>::new, Column::<f64>::new);
    Table::new(
        SEARCHES,
        "One row for each search: a falsifier in one town against one policy, one run. Rates within a search are shares of what it tried, \
         not the failure rate of the driver.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.0.key.id.to_string()))
    .columns(search_key(|row: &Row<'_>| &row.0.key))
    .column(run(|row: &Row<'_>| &row.0.key))
    .column(BUDGET.of(|row: &Row<'_>| row.0.budget))
    .column(
        count(
            "used_ticks",
            "",
            "simulator ticks that it used; less than a command is left over, more by `ppo` with several environments, which stops when the \
             first has used its share",
        )
        .of(|row: &Row<'_>| row.0.spent.ticks),
    )
    .column(
        count("episodes", "", "episodes that came to an end, without one that the budget cut off")
            .of(|row: &Row<'_>| row.0.spent.episodes),
    )
    .column(STARTS.of(|row: &Row<'_>| row.0.spent.starts.count()))
    .column(TRIED.of(|row: &Row<'_>| row.0.spent.starts.to_string()))
    .column(FIRST_START.of(|row: &Row<'_>| row.0.spent.first_start.map(|(number, hash)| format!("{number}:{hash:016x}"))))
    .column(count(FAILURE_COUNT, "", "episodes that ended in a collision").of(|row: &Row<'_>| row.1.failures as u64))
    .column(number(FAILURE_RATE, "", "their share of `episodes`").of(|row: &Row<'_>| row.1.failure_rate))
    .column(
        count(
            FAILED_STARTS,
            "",
            "starts from which a collision was found; the fair count between methods that leave a start after a collision (`cem`, `cma_es`, \
             `mcts`) and those that walk once from each",
        )
        .of(|row: &Row<'_>| row.1.failed_starts as u64),
    )
    .column(
        number(FIRST_FAILURE, "", "ticks used when the first was found, its own included; missing if none was found")
            .of(|row: &Row<'_>| row.1.first.map(|ticks| ticks as f64)),
    )
    .column(Column::<bool>::new("censored", "", "whether none was found").of(|row: &Row<'_>| row.1.first.is_none()))
    .column(
        count(
            DISTINCT,
            "",
            "different cells of the failures: see `cell` of `search_failures`",
        )
        .of(|row: &Row<'_>| row.1.distinct as u64),
    )
    .column(count(PREVENTABLE, "", "failures that both careful humans avoid").of(|row: &Row<'_>| row.1.preventable[0] as u64))
    .column(
        count(ATTRIBUTABLE, "", "preventable failures with a foreseeable pedestrian")
            .of(|row: &Row<'_>| row.1.attributable[0] as u64),
    )
    .column(
        number(ATTRIBUTABLE_RATE, "", "share of `episodes` that ended in an attributable failure")
            .of(|row: &Row<'_>| row.1.attributable_rate),
    )
    .column(
        count("attributable_starts", "", "starts from which an attributable failure was found")
            .of(|row: &Row<'_>| row.1.attributable_starts as u64),
    )
    .column(
        number(ATTRIBUTABLE_START_RATE, "", "their share of `starts`; for an exhaustive search the ceiling of all others")
            .of(|row: &Row<'_>| row.1.attributable_start_rate),
    )
    .column(
        count("distinct_preventable", "", "different cells of preventable failures")
            .of(|row: &Row<'_>| row.1.preventable[1] as u64),
    )
    .column(
        count("distinct_attributable", "", "different cells of attributable failures")
            .of(|row: &Row<'_>| row.1.attributable[1] as u64),
    )
    .column(
        number(ATTRIBUTABLE_PER_MILLION, "", "attributable failures in a million of the ticks that the search used")
            .of(|row: &Row<'_>| per_million(row.1.attributable[0], row.1.ticks)),
    )
    .column(
        number(DISTINCT_PER_MILLION, "", "different cells of attributable failures in a million of these ticks")
            .of(|row: &Row<'_>| per_million(row.1.attributable[1], row.1.ticks)),
    )
    .column(
        count(
            "evaluated_episodes",
            "",
            "fresh episodes of the controller that the falsifier ended with, outside the budget; their starts are those of `evaluate`",
        )
        .of(|row: &Row<'_>| row.0.evaluated.len() as u64),
    )
    .column(count("evaluated_collisions", "", "collisions of these").of(|row: &Row<'_>| row.1.evaluated_collisions as u64))
    .column(number(EVALUATED_RATE, "", "their share of `evaluated_episodes`").of(|row: &Row<'_>| row.1.evaluated_rate))
    .column(
        count("evaluated_attributable", "", "attributable collisions of these")
            .of(|row: &Row<'_>| row.1.evaluated_attributable as u64),
    )
    .column(
        number(EVALUATED_ATTRIBUTABLE_RATE, "", "their share of `evaluated_episodes`")
            .of(|row: &Row<'_>| row.1.evaluated_attributable_rate),
    )
    .column(number("evaluated_reward", "", "their mean reward; 0 without a reward").of(|row: &Row<'_>| row.1.evaluated_reward))
}

/// Cells of searches as a table, one row each, in the order given.
pub fn search_cell_table(cells: &[SearchCell]) -> DataFrame {
    search_cell_columns().frame(cells)
}

/// The columns of [`search_cell_table`].
pub fn search_cell_columns() -> Table<'static, SearchCell> {
    let count = Column::<u64>::new;
    let time = "Kaplan and Meier's median of `first_failure_ticks` with Brookmeyer and Crowley's 95 % interval on the log-log scale; \
                what the runs do not show is missing, the high end always with fewer than seven runs";
    Table::new(
        "search_cells",
        "One row for each falsifier, town and policy, over all runs. Runs have different seeds *and* starts.",
    )
    .columns(search_key(|cell: &SearchCell| &cell.key))
    .column(count("runs", "", "number of runs").of(|cell: &SearchCell| cell.runs as u64))
    .column(BUDGET.of(|cell: &SearchCell| cell.budget))
    .column(
        count("censored_runs", "", "number of runs that found nothing").of(|cell: &SearchCell| cell.censored as u64),
    )
    .column(Entry::new::<f64, _>(
        format!("{FIRST_FAILURE}_median").into(),
        "".into(),
        time.into(),
        |cell: &SearchCell| cell.first_failure.median,
    ))
    .columns(
        Interval::new(FIRST_FAILURE, "", time)
            .of_ends(|cell: &SearchCell| cell.first_failure.low, |cell: &SearchCell| cell.first_failure.high),
    )
    .columns(averaged(FAILURE_RATE, |cell| cell.failure_rate))
    .columns(averaged(FAILURE_COUNT, |cell| cell.failures))
    .columns(averaged(FAILED_STARTS, |cell| cell.failed_starts))
    .columns(averaged(DISTINCT, |cell| cell.distinct))
    .columns(averaged(PREVENTABLE, |cell| cell.preventable))
    .columns(averaged(ATTRIBUTABLE, |cell| cell.attributable))
    .columns(averaged(ATTRIBUTABLE_PER_MILLION, |cell| cell.attributable_per_million))
    .columns(averaged(DISTINCT_PER_MILLION, |cell| cell.distinct_attributable_per_million))
    .columns(averaged(EVALUATED_RATE, |cell| cell.evaluated_rate))
    .columns(averaged(EVALUATED_ATTRIBUTABLE_RATE, |cell| cell.evaluated_attributable_rate))
    .columns(averaged(ATTRIBUTABLE_RATE, |cell| cell.attributable_rate))
    .columns(averaged(ATTRIBUTABLE_START_RATE, |cell| cell.attributable_start_rate))
}

/// The mean of a column over runs with its interval.
fn averaged(name: &'static str, value: fn(&SearchCell) -> Average) -> Vec<Entry<'static, SearchCell>> {
    let doc = "mean over `runs` with Student's 95 % interval, cut at 0 and for rates at 1";
    let mut entries = vec![MEAN.of(name, move |cell: &SearchCell| value(cell).0).meaning(doc)];
    entries.extend(Interval::new(name, "", doc).of(move |cell: &SearchCell| value(cell).1));
    entries
}

/// A failure of a search with its number.
pub type Found<'a> = (&'a SearchResult, &'a Failure, u64, Option<Verdict>);

/// The failures of all searches as a table, one row each, in the order in which they were found.
pub fn search_failures<'a>(results: &'a [SearchResult]) -> DataFrame {
    let numbered = |result: &'a SearchResult| {
        let verdict = |number: usize| result.verdicts.get(number).copied().flatten();
        let failures = result.spent.failures.iter().enumerate();
        failures.map(move |(number, each)| (result, each, number as u64, verdict(number)))
    };
    let rows: Vec<Found<'_>> = results.iter().flat_map(numbered).collect();
    failure_table().frame(&rows)
}

/// The columns of [`search_failures`].
pub fn failure_table<'a>() -> Table<'a, Found<'a>> {
    type Row<'a> = Found<'a>;
    Table::new(FAILURES, "One row for each failure that a search found, with the commands that lead to it.")
        .column(RUN_ID.of(|row: &Row<'_>| row.0.key.id.to_string()))
        .columns(search_key(|row: &Row<'_>| &row.0.key))
        .column(run(|row: &Row<'_>| &row.0.key))
        .column(FAILURE.of(|row: &Row<'_>| row.2))
        .column(START.of(|row: &Row<'_>| row.1.start))
        .column(FOUND_AFTER.of(|row: &Row<'_>| row.1.ticks))
        .column(IMPACT.of(|row: &Row<'_>| kind(&row.1.outcome).0.name()))
        .column(MOTION.of(|row: &Row<'_>| if kind(&row.1.outcome).1 { "moving" } else { "standing" }))
        .column(DRIVING_MODE.of(|row: &Row<'_>| kind(&row.1.outcome).2))
        .column(IMPACT_SPEED.of(|row: &Row<'_>| row.1.outcome.impact_speed()))
        .column(CELL.of(|row: &Row<'_>| row.1.cell.to_string()))
        .column(EPISODE_REWARD.of(|row: &Row<'_>| row.1.outcome.reward))
        .column(EPISODE_LENGTH.of(|row: &Row<'_>| row.1.outcome.duration))
        .column(COMMANDS.of(|row: &Row<'_>| commands(row.1)))
        .column(DIGEST.of(|row: &Row<'_>| format!("{:016x}", row.1.outcome.digest)))
        .column(STATE_HASHES.of(|row: &Row<'_>| row.1.outcome.state_hashes.to_string()))
        .columns(verdict_columns(|row: &Row<'_>| row.3))
}

/// Commands as `heading@speed` (rad, m/s), with all digits that are needed to read the same numbers back.
fn commands(failure: &Failure) -> String {
    let each = failure.commands.iter().map(|command| format!("{}@{}", command.heading, command.speed));
    each.collect::<Vec<_>>().join(" ")
}
