use std::collections::BTreeSet;

use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use super::survival::{MedianTime, median_time};
use crate::analysis::Impact;
use crate::campaign::SearchResult;
use crate::compile::SearchKey;
use crate::env::{Ending, Outcome};
use crate::falsifier::Failure;
use crate::statistics::mean_interval;

/// A search in figures.
#[derive(Debug, Clone, PartialEq)]
struct Figures {
    failures: usize,
    failed_beginnings: usize,
    failure_rate: Option<f64>,
    first: Option<u64>,
    distinct: usize,
    tried_collisions: usize,
    tried_rate: Option<f64>,
}

impl Figures {
    fn new(result: &SearchResult) -> Self {
        let spent = &result.spent;
        let share = |part: usize, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        let kinds: BTreeSet<_> = spent.failures.iter().map(|failure| kind(&failure.outcome)).collect();
        let tried_collisions = result.tried.iter().filter(|outcome| outcome.is_collision()).count();
        Self {
            failures: spent.failures.len(),
            failed_beginnings: spent.failures.iter().map(|failure| failure.beginning).collect::<BTreeSet<_>>().len(),
            failure_rate: share(spent.failures.len(), spent.episodes),
            first: spent.failures.first().map(|failure| failure.ticks),
            distinct: kinds.len(),
            tried_collisions,
            tried_rate: share(tried_collisions, result.tried.len() as u64),
        }
    }
}

/// What tells failures apart: where the car was hit, whether it moved, what its driver was doing.
fn kind(outcome: &Outcome) -> (Impact, bool, &'static str) {
    match outcome.ending {
        Ending::Collision { front, moving, bearing, .. } => {
            (Impact::new(front, bearing), moving, outcome.last_mode.name())
        }
        _ => unreachable!("a failure is a collision"),
    }
}

/// All runs of a falsifier in one town against one policy, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchCell {
    /// Which falsifier, town and policy; the run is the first.
    pub key: SearchKey,
    /// Simulator ticks that each run might use.
    pub budget: u64,
    /// How many runs.
    pub runs: usize,
    /// How many of them found nothing.
    pub censored: usize,
    /// Ticks to the first failure.
    pub first_failure: MedianTime,
    /// Share of the episodes that failed; as all of these, mean over runs and interval.
    pub failure_rate: Average,
    /// Failures.
    pub failures: Average,
    /// Beginnings from which a failure was found.
    pub failed_beginnings: Average,
    /// Kinds of failures.
    pub distinct: Average,
    /// Collision rate of the pedestrian it ended up with.
    pub tried_rate: Average,
}

/// A mean over runs with Student's 95 % interval; the mean is none without a value, the interval with fewer than two.
pub type Average = (Option<f64>, Option<(f64, f64)>);

fn average(values: impl Iterator<Item = Option<f64>>) -> Average {
    let values: Vec<f64> = values.flatten().collect();
    if values.is_empty() {
        return (None, None);
    }
    let (mean, interval) = mean_interval(&values);
    // Nothing that is averaged here can be below zero.
    (Some(mean), interval.map(|(low, high)| (low.max(0.0), high)))
}

/// Gathers runs to cells, in the order of first appearance.
pub fn search_cells(results: &[SearchResult]) -> Vec<SearchCell> {
    let mut cells: Vec<Vec<&SearchResult>> = Vec::new();
    for result in results {
        let same = |other: &SearchResult| {
            let (a, b) = (&result.key, &other.key);
            (&a.falsifier, &a.town, &a.policy, a.block) == (&b.falsifier, &b.town, &b.policy, b.block)
        };
        match cells.iter_mut().find(|cell| same(cell[0])) {
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
        failed_beginnings: over(&|figures| Some(figures.failed_beginnings as f64)),
        distinct: over(&|figures| Some(figures.distinct as f64)),
        tried_rate: share(over(&|figures| figures.tried_rate)),
    }
}

/// Cuts the interval of a share at 1.
fn share((mean, interval): Average) -> Average {
    (mean, interval.map(|(low, high)| (low, high.min(1.0))))
}

/// The columns of a table, over rows of any kind.
struct Columns<'a, T> {
    rows: &'a [T],
    columns: Vec<Column>,
}

impl<'a, T> Columns<'a, T> {
    fn new(rows: &'a [T]) -> Self {
        Self { rows, columns: Vec::new() }
    }

    fn text(&mut self, name: &str, value: impl Fn(&T) -> String) {
        let values: Vec<String> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn count(&mut self, name: &str, value: impl Fn(&T) -> u64) {
        let values: Vec<u64> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn number(&mut self, name: &str, value: impl Fn(&T) -> Option<f64>) {
        let values: Vec<Option<f64>> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn average(&mut self, name: &str, value: impl Fn(&T) -> Average) {
        self.number(&format!("{name}_mean"), |row| value(row).0);
        self.number(&format!("{name}_low"), |row| value(row).1.map(|(low, _)| low));
        self.number(&format!("{name}_high"), |row| value(row).1.map(|(_, high)| high));
    }

    /// What tells searches apart, but for the run.
    fn key(&mut self, key: impl Fn(&T) -> &SearchKey) {
        self.text("falsifier", |row| key(row).falsifier.clone());
        self.text("method", |row| key(row).method.into());
        self.text("reward", |row| key(row).reward.clone());
        self.text("town", |row| key(row).town.clone());
        self.text("policy", |row| key(row).policy.clone());
        self.count("block", |row| key(row).block.into());
    }

    fn table(self) -> DataFrame {
        DataFrame::new(self.rows.len(), self.columns).expect("all columns have a value for every row")
    }
}

/// Searches as a table, one row each, in the order given. The columns are explained in `reports/README.md`.
pub fn searches(results: &[SearchResult]) -> DataFrame {
    let rows: Vec<(&SearchResult, Figures)> = results.iter().map(|result| (result, Figures::new(result))).collect();
    let mut columns = Columns::new(&rows);
    columns.text("run_id", |row| row.0.key.id.to_string());
    columns.key(|row| &row.0.key);
    columns.count("run", |row| row.0.key.run.into());
    columns.count("budget_ticks", |row| row.0.budget);
    columns.count("used_ticks", |row| row.0.spent.ticks);
    columns.count("episodes", |row| row.0.spent.episodes);
    columns.count("beginnings", |row| row.0.spent.beginnings);
    columns.count("failures", |row| row.1.failures as u64);
    columns.number("failure_rate", |row| row.1.failure_rate);
    columns.count("failed_beginnings", |row| row.1.failed_beginnings as u64);
    columns.number("first_failure_ticks", |row| row.1.first.map(|ticks| ticks as f64));
    let censored: Vec<bool> = rows.iter().map(|row| row.1.first.is_none()).collect();
    columns.columns.push(Series::new("censored".into(), censored).into());
    columns.count("distinct_failures", |row| row.1.distinct as u64);
    columns.count("tried_episodes", |row| row.0.tried.len() as u64);
    columns.count("tried_collisions", |row| row.1.tried_collisions as u64);
    columns.number("tried_rate", |row| row.1.tried_rate);
    columns.table()
}

/// Cells of searches as a table, one row each, in the order given.
pub fn search_cell_table(cells: &[SearchCell]) -> DataFrame {
    let mut columns = Columns::new(cells);
    columns.key(|cell| &cell.key);
    columns.count("runs", |cell| cell.runs as u64);
    columns.count("budget_ticks", |cell| cell.budget);
    columns.count("censored_runs", |cell| cell.censored as u64);
    columns.number("first_failure_ticks_median", |cell| cell.first_failure.median);
    columns.number("first_failure_ticks_low", |cell| cell.first_failure.low);
    columns.number("first_failure_ticks_high", |cell| cell.first_failure.high);
    columns.average("failure_rate", |cell| cell.failure_rate);
    columns.average("failures", |cell| cell.failures);
    columns.average("failed_beginnings", |cell| cell.failed_beginnings);
    columns.average("distinct_failures", |cell| cell.distinct);
    columns.average("tried_rate", |cell| cell.tried_rate);
    columns.table()
}

/// The failures of all searches as a table, one row each, in the order in which they were found.
pub fn search_failures<'a>(results: &'a [SearchResult]) -> DataFrame {
    let numbered = |result: &'a SearchResult| (0..).zip(&result.spent.failures).map(move |(k, each)| (result, each, k));
    let rows: Vec<(&SearchResult, &Failure, u64)> = results.iter().flat_map(numbered).collect();
    let mut columns = Columns::new(&rows);
    columns.text("run_id", |row| row.0.key.id.to_string());
    columns.key(|row| &row.0.key);
    columns.count("run", |row| row.0.key.run.into());
    columns.count("failure", |row| row.2);
    columns.count("beginning", |row| row.1.beginning);
    columns.count("found_after_ticks", |row| row.1.ticks);
    columns.text("impact", |row| kind(&row.1.outcome).0.name().into());
    columns.text("motion", |row| if kind(&row.1.outcome).1 { "moving" } else { "standing" }.into());
    columns.text("driving_mode", |row| kind(&row.1.outcome).2.into());
    columns.number("impact_speed_mps", |row| row.1.outcome.impact_speed());
    columns.number("episode_reward", |row| Some(row.1.outcome.reward));
    columns.number("episode_length_s", |row| Some(row.1.outcome.duration));
    columns.text("commands", |row| commands(row.1));
    columns.text("digest", |row| format!("{:016x}", row.1.outcome.digest));
    columns.text("trail", |row| row.1.outcome.state_hashes.to_string());
    columns.table()
}

/// Commands as `heading@speed` (rad, m/s), with all the digits that it takes to read the same numbers back.
fn commands(failure: &Failure) -> String {
    let each = failure.commands.iter().map(|command| format!("{}@{}", command.heading, command.speed));
    each.collect::<Vec<_>>().join(" ")
}
