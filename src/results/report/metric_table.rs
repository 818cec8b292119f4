use std::collections::BTreeMap;

use polars::prelude::DataFrame;

use super::Findings;
use super::aggregate::{CellRequirement, Counted, SearchCell, search_cell_table};
use super::cell_table::applied_to;
use super::infer::{CellEvidence, IMPACT_SPEED_P90, Learning, reference_rates};
use crate::record::{CellKey, Column, ColumnReference, Interval, Role, Table, TableReference, cell_key};
use crate::tables::metrics::{EPISODE_REWARD, EPISODES, MEAN, RUNS};
use crate::tables::{self, Cell, Metric};
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
    let mut requirements: BTreeMap<&CellKey, Vec<&CellRequirement>> = BTreeMap::new();
    gathered.requirements.iter().for_each(|each| requirements.entry(&each.key).or_default().push(each));
    let keys: Vec<CellKey> = searches.iter().map(|cell| cell_of(&cell.key)).collect();
    let mut rows = Vec::new();
    for cell in cells.iter() {
        let evidence = found.evidence(cell);
        tables::METRICS.iter().for_each(|metric| of_metric(metric, cell, evidence, &mut rows));
        if let Some(found) = evidence {
            of_evidence(cell, found, &mut rows);
        }
        requirements.get(&cell.key).into_iter().flatten().for_each(|each| of_requirement(cell, each, &mut rows));
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
    let columns = search_cell_table().reference().columns.into_iter().skip_while(|column| column.name != RUNS.name);
    let is_end = |column: &ColumnReference| matches!(column.role, Role::LowerBound | Role::UpperBound);
    let values = columns.skip(1).filter(|column| !is_end(column));
    let metric = |column: ColumnReference| {
        let mean = column.name.strip_suffix(&MEAN.name(""));
        let is_figure = mean.is_some_and(|mean| mean == column.figure);
        let name = if is_figure { column.figure.clone() } else { column.name.clone() };
        (ColumnReference { name, ..column.clone() }, column.name.into_owned())
    };
    values.map(metric).collect()
}

/// Adds the rows of searches over their runs.
fn of_searches<'a>(searches: &[SearchCell], keys: &'a [CellKey], rows: &mut Vec<Row<'a>>) {
    let table = search_cell_table().frame(searches);
    for (place, (cell, key)) in searches.iter().zip(keys).enumerate() {
        let number = |column: &str| table.column(column).ok()?.get(place).ok()?.extract::<f64>();
        for (metric, column) in search_metrics() {
            let ends = number(&format!("{}_low", metric.name)).zip(number(&format!("{}_high", metric.name)));
            let interval = if ends.is_some() { "student" } else { "" };
            let row = Row::new(key, metric, cell.runs as u64, number(&column));
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

/// Adds the rows of a requirement.
fn of_requirement<'a>(cell: &'a Cell, found: &CellRequirement, rows: &mut Vec<Row<'a>>) {
    let applied = found.sums(CellRequirement::ALL).1;
    rows.push(Row::new(&cell.key, applied_metric(&found.name), found.episodes().into(), Some(f64::from(applied))));
    for (words, counted, needs_verdict) in OF_VIOLATIONS {
        if needs_verdict && !found.is_judged() {
            continue;
        }
        let [count, rate] = violation_metrics(words, &found.name);
        let ((part, applied), rate_of_runs) = (found.sums(counted), found.rate(counted));
        let row = Row::new(&cell.key, count, applied.into(), (applied > 0).then_some(f64::from(part)));
        rows.push(row.clone());
        rows.push(Row {
            metric: rate,
            value: rate_of_runs.value,
            by_run: rate_of_runs.by_run,
            ends: rate_of_runs.interval,
            interval: wilson_of(rate_of_runs.interval),
            ..row
        });
    }
}

/// Names of a number and of its rate, and what they mean of a requirement.
type Words = [(&'static str, &'static str); 2];

/// The metrics of a requirement, what they count, and whether they need a verdict.
const OF_VIOLATIONS: [(Words, Counted, bool); 3] = [
    (
        [
            (
                "violations",
                "number of episodes that violate that requirement of the campaign; missing if it never applied",
            ),
            ("violation_rate", "their share of *applied*"),
        ],
        CellRequirement::ALL,
        false,
    ),
    (
        [
            ("preventable_violations", "number of these that both careful humans avoid"),
            ("preventable_rate", "their share of *applied*"),
        ],
        CellRequirement::PREVENTABLE,
        true,
    ),
    (
        [
            ("fault_violations", "number of these that count against the driver"),
            ("fault_rate", "their share of *applied*"),
        ],
        CellRequirement::FAULTS,
        true,
    ),
];

/// The number of episodes in which a requirement applied.
fn applied_metric(requirement: &str) -> ColumnReference {
    let doc = "number of episodes in which the antecedent of an `implies` of that requirement held; 0: nothing is known of its violations";
    let name = applied_to(requirement);
    ColumnReference { name: name.clone().into(), doc: doc.into(), figure: name.into(), ..RUNS.reference() }
}

/// The metrics of a requirement: a number and a rate of its violations.
fn violation_metrics(words: Words, requirement: &str) -> [ColumnReference; 2] {
    words.map(|(name, doc)| ColumnReference {
        name: format!("{name}({requirement})").into(),
        unit: "".into(),
        doc: doc.into(),
        holds: polars::prelude::DataType::Float64,
        role: Role::Plain,
        figure: name.into(),
    })
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
    .text("metric", "its name, see below", |row| row.metric.name.to_string())
    .count("n", "how many episodes, collisions or runs the value is made of", |row| row.of)
    .measure(
        "value",
        "as the metric",
        "of a count the sum over runs, of a rate or a mean the mean over runs",
        |row| row.value,
    )
    .text("by_run", "values of the runs of a rate or a mean, in their order, with a blank between two; those without a value are left out", |row| {
        row.by_run.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
    })
    .columns(
        Interval::new("", "as the metric", "its 95 % interval, see [above](#which-interval-answers-which-question)")
            .of(|row: &Row<'a>| row.ends)
            .into_iter()
            .zip(["low", "high"])
            .map(|(entry, name)| entry.named(name)),
    )
    .text(
        "interval",
        "`wilson` over the starts, which all runs share, or `student` about further trainings, for four or more runs; \
         empty without one",
        |row| row.interval,
    )
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
    all.push(applied_metric("REQUIREMENT"));
    all.extend(search_metrics().into_iter().map(|(metric, _)| metric));
    all.extend(OF_VIOLATIONS.into_iter().flat_map(|(words, _, _)| violation_metrics(words, "REQUIREMENT")));
    all
}
