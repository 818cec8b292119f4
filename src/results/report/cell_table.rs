//! What gates know of a cell: the table of cells, and beside it the evidence, its test and its requirements.

use polars::prelude::{
    DataFrame, Expr, IntoLazy, JoinArgs, JoinType, MaintainOrderJoin, NULL, PolarsResult, col, lit, when,
};

use super::Findings;
use super::aggregate::{ProtocolCell, passed_share, score};
use super::infer::{BEATS_UNTRAINED, CellEvidence, IMPACT_SPEED_P90, reference_rates};
use super::metric_table::TRAININGS_DISAGREE;
use crate::campaign::Finished;
use crate::jobs::{NEEDLESS, PROGRESS, SPARED, price_columns};
use crate::record::columns::{DRIVER, TOWN};
use crate::record::{CellKey, Column, ColumnReference, Entry, Role, Table, cell_key, interval};
use crate::tables::metrics::{IMPACT_SPEED, inferred};
use crate::tables::{
    APPLIED, Cell, FAULT_VIOLATION_RATE, IS_FIXED_CASES, NO_VERDICT, REQUIREMENT, VIOLATION_RATE, cell_columns,
    key_columns,
};
use base::statistics::wilson;
use verdict::Reference;

/// The columns of a cell's test: the mean of its colours' shares of the points, the share of its cases that are passed, and the number of cases without a
/// result at the test speed.
pub const SCORE: &str = "score";
pub const PASSED: &str = "passed";
pub const NOT_TESTED: &str = "not_tested";

/// A cell with its results in the tests of a protocol.
type Tested = (CellKey, Vec<ProtocolCell>);

/// The columns that gates may name, with the rates of these requirements.
pub fn gate_columns(requirements: &[&str]) -> Vec<ColumnReference> {
    let keys = key_columns().len();
    let more = |columns: Vec<ColumnReference>| columns.into_iter().skip(keys);
    let mut all = cell_columns();
    all.extend(more(evidence_table().reference().columns));
    all.extend(more(test_table().reference().columns));
    all.extend(price_figures());
    for name in requirements {
        all.extend(more(requirement_columns(name).reference().columns));
    }
    all
}

/// The table that gates judge: a row for each cell, all runs that differ in their number alone. There is at least one cell.
///
/// # Errors
/// Those of polars; none.
pub fn gate_table(found: &Findings<'_>, requirements: &[&str]) -> PolarsResult<DataFrame> {
    let gathered = &found.gathered;
    let evidence = evidence_table().frame(&gathered.evidence.cells);
    let mut table = beside(found.cells.table().clone(), evidence)?;
    // The cases of a test are no sample.
    let ends = evidence_table().reference().columns.into_iter();
    let ends = ends.filter(|column| matches!(column.role, Role::LowerBound | Role::UpperBound));
    let of_samples = |column: ColumnReference| -> Expr {
        let name = column.name.into_owned();
        when(col(IS_FIXED_CASES.name).not()).then(col(&name)).otherwise(lit(NULL)).alias(&name)
    };
    table = table.lazy().with_columns(ends.map(of_samples).collect::<Vec<_>>()).collect()?;
    table = beside(table, test_table().frame(&gathered.tests))?;
    table = table.lazy().with_column(col(NOT_TESTED).fill_null(lit(0.0))).collect()?;
    table = beside_prices(table, found.finished)?;
    for name in requirements {
        let own: Vec<Cell> =
            gathered.requirements.iter().filter(|each| each.text(&REQUIREMENT) == *name).cloned().collect();
        table = beside(table, requirement_columns(name).frame(&own))?;
    }
    Ok(table)
}

/// The figures of a driver's price in a town.
fn price_figures() -> impl Iterator<Item = ColumnReference> {
    let figures = [PROGRESS.name, NEEDLESS, SPARED.name];
    price_columns().reference().columns.into_iter().filter(move |column| figures.contains(&&*column.figure))
}

/// The cells, each with the price of its driver in its town.
fn beside_prices(cells: DataFrame, finished: &Finished) -> PolarsResult<DataFrame> {
    let keys = [TOWN.name, DRIVER.name].map(col);
    let prices = price_columns().frame(&finished.found().collect::<Vec<_>>());
    let figures = keys.iter().cloned().chain(price_figures().map(|column| col(&*column.name)));
    let prices = prices.lazy().select(figures.collect::<Vec<_>>());
    let arguments = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Left) };
    cells.lazy().join(prices, keys.clone(), keys, arguments).collect()
}

/// The columns of a table beside those of another one, by the key of the cell.
fn beside(left: DataFrame, right: DataFrame) -> PolarsResult<DataFrame> {
    let keys: Vec<Expr> = key_columns().iter().map(col).collect();
    let arguments = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Left) };
    left.lazy().join(right.lazy(), keys.clone(), keys, arguments).collect()
}

/// What further trainings and the reference drivers say of a cell.
fn evidence_table<'a>() -> Table<'a, CellEvidence> {
    type Row = CellEvidence;
    let mut table = Table::new("evidence", "").columns(cell_key(|row: &Row| &row.key));
    for metric in inferred() {
        table = table.columns(interval(&format!("{}_student", metric.name), metric.name, "", move |row: &Row| {
            row.between(metric)?.interval
        }));
    }
    let p90 = IMPACT_SPEED_P90.of(|row: &Row| row.impact_speed_p90.0);
    table = table.column(p90.of_figure(IMPACT_SPEED.name, Role::Plain));
    for reference in Reference::ALL {
        for (place, ColumnReference { name, .. }) in reference_rates(reference).into_iter().enumerate() {
            let part = move |row: &Row| row.rates_of(reference)[place].1;
            let rate = move |row: &Row| part(row).share_of(&row.episodes);
            let ends = move |row: &Row| Some(wilson(part(row), row.episodes));
            table = table.column(share(&name, rate)).columns(interval(&format!("{name}_wilson"), &name, "", ends));
        }
    }
    let beats = |row: &Row| row.learning.as_ref().map(|learning| learning.beats_untrained().name());
    let disagree = |row: &Row| Some(if row.learning.as_ref()?.disagree()? { "yes" } else { "no" });
    table.column(BEATS_UNTRAINED.of(beats)).column(Column::<String>::new(TRAININGS_DISAGREE.name, "", "").of(disagree))
}

/// The results in a test.
fn test_table<'a>() -> Table<'a, Tested> {
    let not_tested = |row: &Tested| row.1.iter().filter(|cell| !cell.is_tested()).count();
    Table::new("tests", "")
        .columns(cell_key(|row: &Tested| &row.0))
        .column(share(SCORE, |row: &Tested| score(row.1.iter())))
        .column(share(PASSED, |row: &Tested| passed_share(&row.1)))
        .column(number(NOT_TESTED.into(), move |row| Some(not_tested(row) as f64)))
}

/// The number of episodes in which a requirement applied, and the rates of its violations and of its faults.
fn requirement_columns<'a>(name: &str) -> Table<'a, Cell> {
    let mut table = Table::new("requirements", "")
        .columns(cell_key(|row: &Cell| &row.key))
        .column(number(applied_to(name), |row: &Cell| Some(row.count(&APPLIED).into())));
    for metric in [&VIOLATION_RATE, &FAULT_VIOLATION_RATE] {
        let name = format!("{}({name})", metric.name);
        let is_known = move |row: &Cell| *metric == VIOLATION_RATE || row.text(&NO_VERDICT).is_empty();
        let rate = move |row: &Cell| is_known(row).then(|| row.rate(metric));
        let ends = interval(&format!("{name}_wilson"), &name, "", move |row| rate(row)?.interval);
        table = table.column(share(&name, move |row| rate(row)?.value)).columns(ends);
    }
    table
}

/// The column of the number of episodes in which a requirement applied.
pub fn applied_to(requirement: &str) -> String {
    format!("applied({requirement})")
}

fn number<'a, R>(name: String, value: impl Fn(&R) -> Option<f64> + 'a) -> Entry<'a, R> {
    Entry::new::<f64, _>(name.into(), "".into(), "".into(), value)
}

fn share<'a, R>(name: &str, value: impl Fn(&R) -> Option<f64> + 'a) -> Entry<'a, R> {
    number(name.to_owned(), value).of_figure(name.to_owned(), Role::Share)
}
