use polars::prelude::{DataFrame, PolarsResult};

use super::aggregate::{Cell, CellRequirement, Counted};
use super::infer::{CellEvidence, Figure, IMPACT_SPEED_P90, Learning, remaining_rate};
use crate::record::metric::{MEAN, SD};
use crate::record::{CellKey, Column, ColumnReference, Interval, Metric, Table, TableReference, cell_key, metrics};
use base::statistics::{ClusteredCount, wilson};
use world::judge::Reference;

/// The stem of the files of the table of metrics.
pub const METRICS: &str = "metrics";

const TRAININGS_DISAGREE: Column<f64> = Column::new(
    "trainings_disagree",
    "",
    "1 where the trainings of the cell differ by far more than their episodes explain and by more than half of what they gained, else 0; missing for \
     untrained controllers and for a single training",
);

/// What a number of things is counted of: `n` in the table.
#[derive(Debug, Clone, Copy)]
struct Size(&'static str, u64);

/// A metric of a cell.
#[derive(Debug, Clone)]
struct Row<'a> {
    key: &'a CellKey,
    metric: ColumnReference,
    of: Size,
    value: Option<f64>,
    sd: Option<f64>,
    ends: Option<(f64, f64)>,
    /// The name of the interval; empty without one.
    interval: &'static str,
}

/// All that is known of each cell in one long table: a row for each metric, and one more where it has a second interval.
///
/// # Errors
/// Those of polars; none for the table and the evidence of these cells.
pub fn metric_table(
    frame: &DataFrame,
    cells: &[Cell],
    evidence: &[CellEvidence],
    requirements: &[CellRequirement],
) -> PolarsResult<DataFrame> {
    let metrics = metrics();
    let mut rows = Vec::new();
    for (place, (cell, found)) in cells.iter().zip(evidence).enumerate() {
        for metric in &metrics {
            of_metric(metric, frame, place, (cell, found), &mut rows)?;
        }
        of_evidence(cell, found, &mut rows);
        requirements.iter().filter(|each| each.key == cell.key).for_each(|each| of_requirement(cell, each, &mut rows));
    }
    Ok(columns().frame(&rows))
}

/// Adds the rows of a metric of episodes.
fn of_metric<'a>(
    metric: &Metric,
    frame: &DataFrame,
    place: usize,
    (cell, found): (&'a Cell, &CellEvidence),
    rows: &mut Vec<Row<'a>>,
) -> PolarsResult<()> {
    let runs = Size("runs", u64::from(cell.runs));
    let episodes = Size("episodes", u64::from(cell.episodes));
    let reference = metric.reference();
    let name = metric.name();
    let row = |of: Size, value: Option<f64>| Row {
        key: &cell.key,
        metric: reference.clone(),
        of,
        value,
        sd: None,
        ends: None,
        interval: "",
    };
    if let Metric::Count(count) = *metric {
        rows.push(row(episodes, count.read(frame)?.get(place).map(f64::from)));
        return Ok(());
    }
    let value = MEAN.read(name, frame)?.get(place);
    let sd = SD.read(name, frame)?.get(place);
    let across = Figure::ALL.into_iter().find(|figure| figure.name() == name).map(|figure| found.between(figure));
    let student = across.and_then(|across| across.interval);
    if let Metric::Rate(rate) = *metric {
        let whole = u64::from(rate.whole.read(frame)?.get(place).unwrap_or_default());
        let part = u64::from(rate.part.read(frame)?.get(place).unwrap_or_default());
        // The runs of a cell share their starts.
        let of_runs = |count: u64| ClusteredCount::from(count).of_clusters(f64::from(cell.runs));
        let of = Size(if rate.whole.name == "collisions" { "collisions" } else { "episodes" }, whole);
        rows.push(Row { sd, ends: Some(wilson(of_runs(part), of_runs(whole))), interval: "wilson", ..row(of, value) });
        if student.is_some() {
            rows.push(Row { sd, ends: student, interval: "student", ..row(runs, value) });
        }
    } else {
        let interval = if student.is_some() { "student" } else { "" };
        rows.push(Row { sd, ends: student, interval, ..row(runs, value) });
    }
    Ok(())
}

/// Adds the rows of a requirement.
fn of_requirement<'a>(cell: &'a Cell, found: &CellRequirement, rows: &mut Vec<Row<'a>>) {
    for (words, counted, needs_verdict) in OF_VIOLATIONS {
        if needs_verdict && !found.is_judged() {
            continue;
        }
        let [count, rate] = violation_metrics(words, &found.name);
        let ((part, all), rate_of_runs) = (found.sums(counted), found.rate(counted));
        let row = Row {
            key: &cell.key,
            metric: count,
            of: Size("episodes", u64::from(all)),
            value: Some(f64::from(part)),
            sd: None,
            ends: None,
            interval: "",
        };
        rows.push(row.clone());
        rows.push(Row {
            metric: rate,
            value: rate_of_runs.value,
            sd: rate_of_runs.sd,
            ends: rate_of_runs.interval,
            interval: "wilson",
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
            ("violations", "number of episodes that violate that requirement of the campaign"),
            ("violation_rate", "episodes that violate that requirement of all *episodes*"),
        ],
        CellRequirement::ALL,
        false,
    ),
    (
        [
            ("preventable_violations", "number of these that both careful humans avoid"),
            ("preventable_rate", "episodes with such a violation of all *episodes*"),
        ],
        CellRequirement::PREVENTABLE,
        true,
    ),
    (
        [
            ("fault_violations", "number of these that count against the driver"),
            ("fault_rate", "episodes with such a violation of all *episodes*"),
        ],
        CellRequirement::FAULTS,
        true,
    ),
];

/// The metrics of a requirement: a number and a rate of its violations.
fn violation_metrics(words: Words, requirement: &str) -> [ColumnReference; 2] {
    words.map(|(name, doc)| ColumnReference {
        name: format!("{name}({requirement})").into(),
        unit: "".into(),
        doc: doc.into(),
        holds: polars::prelude::DataType::Float64,
    })
}

/// Adds the rows of impact speeds, of the reference drivers, and of what trainings say of each other.
fn of_evidence<'a>(cell: &'a Cell, found: &CellEvidence, rows: &mut Vec<Row<'a>>) {
    let row = |metric: ColumnReference, of: Size, value: Option<f64>| Row {
        key: &cell.key,
        metric,
        of,
        value,
        sd: None,
        ends: None,
        interval: "",
    };
    let (p90, collisions) = found.impact_speed_p90;
    rows.push(row(IMPACT_SPEED_P90.reference(), Size("collisions", collisions), p90));
    let disagree = found.learning.as_ref().and_then(Learning::disagree);
    let trainings = Size("runs", u64::from(cell.runs));
    rows.extend(
        disagree.map(|disagree| row(TRAININGS_DISAGREE.reference(), trainings, Some(f64::from(u8::from(disagree))))),
    );
    for reference in Reference::ALL {
        let rest = found.remaining(reference);
        let of = Size("episodes", found.episodes.count());
        let ends = Some(wilson(rest, found.episodes));
        let rate = row(remaining_rate(reference), of, rest.share_of(&found.episodes));
        rows.push(Row { ends, interval: "wilson", ..rate });
    }
}

fn columns<'a>() -> Table<'a, Row<'a>> {
    let (text, number) = (Column::<String>::new, Column::<f64>::new);
    Table::new(
        METRICS,
        "One row for each metric of each cell: a pedestrian, a town and a driver, over all runs. `results` has the few that lead the page.",
    )
    .columns(cell_key(|row: &Row<'a>| row.key))
    .column(text("metric", "", "its name, see below").of(|row: &Row<'a>| row.metric.name.to_string()))
    .column(text("unit", "", "its unit; empty without one").of(|row: &Row<'a>| row.metric.unit.to_string()))
    .column(
        text("of", "", "what `n` counts: `episodes`, `collisions` or `runs`").of(|row: &Row<'a>| row.of.0.to_string()),
    )
    .column(Column::<u64>::new("n", "", "how many of these the value is made of").of(|row: &Row<'a>| row.of.1))
    .column(number("value", "as the metric", "of a count the sum over runs, of a rate or a mean the mean over runs").of(|row: &Row<'a>| row.value))
    .column(number("sd", "as the metric", "sample standard deviation over runs; missing for a single one").of(|row: &Row<'a>| row.sd))
    .columns(
        Interval::new("", "as the metric", "its 95 % interval, see [above](#which-interval-answers-which-question)")
            .of(|row: &Row<'a>| row.ends)
            .into_iter()
            .zip(["low", "high"])
            .map(|(entry, name)| entry.named(name)),
    )
    .column(
        text(
            "interval",
            "",
            "`wilson`: over the starts, which all runs share; `student`: about further trainings, for four or more runs; empty without one",
        )
        .of(|row: &Row<'a>| row.interval),
    )
}

/// The documentation of the table.
pub fn metric_table_reference() -> TableReference {
    columns().reference()
}

/// The metrics that the table has, by name.
pub fn metric_references() -> Vec<ColumnReference> {
    let mut all: Vec<ColumnReference> = metrics().iter().map(Metric::reference).collect();
    all.push(IMPACT_SPEED_P90.reference());
    all.push(TRAININGS_DISAGREE.reference());
    all.extend(Reference::ALL.into_iter().map(remaining_rate));
    all.extend(OF_VIOLATIONS.into_iter().flat_map(|(words, _, _)| violation_metrics(words, "REQUIREMENT")));
    all
}
