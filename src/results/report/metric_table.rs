use std::collections::BTreeMap;

use polars::prelude::DataFrame;

use super::Findings;
use super::aggregate::SearchCell;
use super::infer::{CellEvidence, IMPACT_SPEED_P90, Learning, reference_rates};
use crate::record::{CellKey, Column, ColumnReference, Role, Table, TableReference, cell_key, entries};
use crate::tables::metrics::{EPISODE_REWARD, EPISODES, MEAN};
use crate::tables::{
    self, APPLIED, Cell, JUDGED, Metric, NO_VERDICT, REQUIREMENT, REQUIREMENT_METRICS, WITHOUT_VERDICT,
};
use base::statistics::wilson;
use compile::SearchKey;
use verdict::Reference;

/// The stem of the files of the table of metrics.
pub const METRICS: &str = "metrics";

pub const TRAININGS_DISAGREE: Column<f64> = Column::new(
    "trainings_disagree",
    "",
    "1 where the trainings of the cell differ by far more than their episodes explain and by more than half of what they gained, else 0; missing for \
     untrained pedestrians and for a single training",
);

/// A metric of a cell.
#[derive(Debug, Clone)]
struct Row<'a> {
    key: &'a CellKey,
    metric: ColumnReference,
    of: u64,
    value: Option<f64>,
    /// The values of the runs that have one, in their order.
    by_run: Vec<f64>,
    ends: Option<(f64, f64)>,
    /// The name of the interval; empty without one.
    interval: &'static str,
}

impl<'a> Row<'a> {
    /// A value without an interval.
    fn new(key: &'a CellKey, metric: ColumnReference, of: u64, value: Option<f64>) -> Self {
        Self { key, metric, of, value, by_run: Vec::new(), ends: None, interval: "" }
    }
}

/// All that is known of each cell in one long table: a row for each metric, and one more where it has a second interval. Those of searches follow.
pub fn metric_table(found: &Findings<'_>) -> DataFrame {
    let Findings { cells, gathered, searches, .. } = found;
    let mut requirements: BTreeMap<&CellKey, Vec<&Cell>> = BTreeMap::new();
    gathered.requirements.iter().for_each(|each| requirements.entry(&each.key).or_default().push(each));
    let keys: Vec<CellKey> = searches.iter().map(|cell| cell_of(&cell.key)).collect();
    let mut rows = Vec::new();
    for cell in cells.iter() {
        let evidence = found.evidence(cell);
        tables::METRICS.iter().for_each(|metric| of_metric(metric, cell, evidence, &mut rows));
        if let Some(found) = evidence {
            of_evidence(cell, found, &mut rows);
        }
        requirements.get(&cell.key).into_iter().flatten().for_each(|each| of_requirement(each, &mut rows));
    }
    // An untrained pedestrian has a mean reward for each reward of the campaign, and all else once.
    for cell in gathered.copies.iter() {
        of_metric(&EPISODE_REWARD, cell, found.evidence(cell), &mut rows);
    }
    of_searches(searches, &keys, &mut rows);
    columns().frame(&rows)
}

/// A search as a cell: the falsifier is the controller.
fn cell_of(key: &SearchKey) -> CellKey {
    let SearchKey { falsifier, reward, town, policy, block, .. } = key.clone();
    CellKey { controller: falsifier, reward, town, policy, block, ..CellKey::default() }
}

/// The metrics of searches, each with its column in the table that gates judge.
fn search_metrics() -> Vec<(ColumnReference, String)> {
    let is_end = |column: &ColumnReference| matches!(column.role, Role::LowerBound | Role::UpperBound);
    let metric = |column: ColumnReference| {
        let mean = column.name.strip_suffix(&MEAN.name(""));
        let is_figure = mean.is_some_and(|mean| mean == column.figure);
        let name = if is_figure { column.figure.clone() } else { column.name.clone() };
        (ColumnReference { name, ..column.clone() }, column.name.into_owned())
    };
    tables::search_cell_columns().into_iter().filter(|column| !is_end(column)).map(metric).collect()
}

/// Adds the rows of searches over their runs.
fn of_searches<'a>(searches: &[SearchCell], keys: &'a [CellKey], rows: &mut Vec<Row<'a>>) {
    for (cell, key) in searches.iter().zip(keys) {
        for (metric, column) in search_metrics() {
            let ends = cell.rate(&metric.name).interval;
            let interval = if ends.is_some() { "student" } else { "" };
            let row = Row::new(key, metric, cell.runs()[0], cell.number(&column));
            rows.push(Row { ends, interval, ..row });
        }
    }
}

/// Adds the rows of a metric of episodes.
fn of_metric<'a>(metric: &Metric, cell: &'a Cell, evidence: Option<&CellEvidence>, rows: &mut Vec<Row<'a>>) {
    let row = |of: u32, value: Option<f64>| Row::new(&cell.key, metric.reference(), of.into(), value);
    if metric.is_count() {
        return rows.push(row(cell.count(&EPISODES), Some(f64::from(cell.count(metric)))));
    }
    let average = cell.rate(metric);
    let across = evidence.and_then(|found| found.between(metric)?.interval);
    let student = across.filter(|_| !cell.is_fixed_cases());
    let of_runs = Row { by_run: average.by_run, ..row(cell.runs(), average.value) };
    if metric.is_share() {
        let (of, ends) = (cell.whole(metric).into(), average.interval);
        rows.push(Row { of, ends, interval: wilson_of(ends), ..of_runs.clone() });
    }
    if student.is_some() {
        rows.push(Row { ends: student, interval: "student", ..of_runs });
    } else if !metric.is_share() {
        rows.push(of_runs);
    }
}

/// The name of an interval; empty if there is none.
fn wilson_of(interval: Option<(f64, f64)>) -> &'static str {
    if interval.is_some() { "wilson" } else { "" }
}

/// Adds the rows of a requirement: those of verdicts only where its violations have one.
fn of_requirement<'a>(cell: &'a Cell, rows: &mut Vec<Row<'a>>) {
    let (name, applied) = (cell.text(&REQUIREMENT), cell.count(&APPLIED));
    let shown = if cell.text(&NO_VERDICT).is_empty() { REQUIREMENT_METRICS.len() } else { WITHOUT_VERDICT };
    for metric in &REQUIREMENT_METRICS[1..shown] {
        let row = |of: u32, value| Row::new(&cell.key, of_name(metric, &name), of.into(), value);
        let count = f64::from(cell.count(metric));
        let rate = cell.rate(metric);
        rows.push(match metric.is_count() {
            true if **metric == APPLIED => row(cell.count(&JUDGED), Some(count)),
            true => row(applied, (applied > 0).then_some(count)),
            false => Row {
                by_run: rate.by_run,
                ends: rate.interval,
                interval: wilson_of(rate.interval),
                ..row(applied, rate.value)
            },
        });
    }
}

fn of_name(metric: &Metric, requirement: &str) -> ColumnReference {
    ColumnReference { name: format!("{}({requirement})", metric.name).into(), ..metric.reference() }
}

/// Adds the rows of impact speeds, of the reference drivers, and of what trainings say of each other.
fn of_evidence<'a>(cell: &'a Cell, found: &CellEvidence, rows: &mut Vec<Row<'a>>) {
    let row = |metric: ColumnReference, of: u64, value: Option<f64>| Row::new(&cell.key, metric, of, value);
    let (p90, collisions) = found.impact_speed_p90;
    rows.push(row(IMPACT_SPEED_P90.reference(), collisions, p90));
    let disagree = found.learning.as_ref().and_then(Learning::disagree);
    let trainings = u64::from(cell.runs());
    rows.extend(
        disagree.map(|disagree| row(TRAININGS_DISAGREE.reference(), trainings, Some(f64::from(u8::from(disagree))))),
    );
    for (metric, part) in Reference::ALL.into_iter().flat_map(|reference| found.rates_of(reference)) {
        let of = found.episodes.count();
        let ends = (!cell.is_fixed_cases()).then(|| wilson(part, found.episodes));
        rows.push(Row { ends, interval: wilson_of(ends), ..row(metric, of, part.share_of(&found.episodes)) });
    }
}

fn columns<'a>() -> Table<'a, Row<'a>> {
    Table::new(
        METRICS,
        "One row for each metric of each cell (a pedestrian, a town and a driver, over all runs) and `interval`: from four runs on a rate has two, `wilson` and `student`. Rows of searches follow: a search, a town and a driver, \
         over all runs, which have different seeds *and* starts.",
    )
    .columns(cell_key(|row: &Row<'a>| row.key))
    .columns(entries! { row: &Row<'_>;
        /// its name, see below
        metric: String = row.metric.name.to_string();
        /// how many episodes, collisions or runs the value is made of
        n: u64 = row.of;
        /// of a count the sum over runs, of a rate or a mean the mean over runs
        value: f64 ["as the metric"] = row.value;
        /// values of the runs of a rate or a mean, in their order, with a blank between two; those without a value are left out
        by_run: String = row.by_run.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        /// its 95 % interval, see [above](#which-interval-answers-which-question)
        low: f64 ["as the metric"] as LowerBound = Some(row.ends?.0);
        /// its 95 % interval, see [above](#which-interval-answers-which-question)
        high: f64 ["as the metric"] as UpperBound = Some(row.ends?.1);
        /// `wilson` over the starts, which all runs share, or `student` about further trainings, for four or more runs; empty without one
        interval: String = row.interval;
    })
}

/// The documentation of the table.
pub fn metric_table_reference() -> TableReference {
    columns().reference()
}

/// The metrics that the table has, by name.
pub fn metric_references() -> Vec<ColumnReference> {
    let mut all: Vec<ColumnReference> = tables::METRICS.into_iter().map(Metric::reference).collect();
    all.push(IMPACT_SPEED_P90.reference());
    all.push(TRAININGS_DISAGREE.reference());
    all.extend((0..2).flat_map(|rate| Reference::ALL.map(|reference| reference_rates(reference)[rate].clone())));
    let [_, applied, violations @ ..] = REQUIREMENT_METRICS.map(|metric| of_name(metric, "REQUIREMENT"));
    all.push(applied);
    all.extend(search_metrics().into_iter().map(|(metric, _)| metric));
    all.extend(violations);
    all
}
