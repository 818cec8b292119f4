//! What gates know of a cell: its metrics, the evidence on them, and its violations.

use super::aggregate::{Cell, CellRequirement, GATED, ProtocolCell, Rate, passed_share, score};
use super::infer::{BEATS_UNTRAINED, CellEvidence, Figure, IMPACT_SPEED_P90, reference_rates};
use super::metric_table::TRAININGS_DISAGREE;
use crate::record::metric::{IMPACT_SPEED, MEAN, RUNS};
use crate::record::{CellKey, Column, ColumnReference, Entry, Metric, Role, Table, cell_key, metrics};
use base::statistics::wilson;
use world::judge::Reference;

/// A cell with all that is known of it.
#[derive(Clone, Copy)]
pub struct KnownCell<'a> {
    pub cell: &'a Cell,
    pub evidence: &'a CellEvidence,
    /// The violations in all cells.
    pub requirements: &'a [CellRequirement],
    /// The results in the tests of a protocol, of all cells.
    pub tests: &'a [(CellKey, Vec<ProtocolCell>)],
}

impl KnownCell<'_> {
    /// The results in its test; empty if it is of no protocol.
    fn test(&self) -> &[ProtocolCell] {
        self.tests.iter().find(|(key, _)| *key == self.cell.key).map_or(&[], |(_, cells)| cells)
    }
}

/// The columns of a cell's test: the mean of its colours' shares of the points, the share of its cases that are passed, and the number of cases without a
/// result at the test speed.
pub const SCORE: &str = "score";
pub const PASSED: &str = "passed";
pub const NOT_TESTED: &str = "not_tested";

/// The columns that gates may name, with the rates of these requirements.
pub fn cell_table<'a>(requirements: &[&str]) -> Table<'a, KnownCell<'a>> {
    type Row<'a> = KnownCell<'a>;
    let mut table = Table::new("cells", "One row for each cell: all runs that differ in their number alone.")
        .columns(cell_key(|row: &Row<'a>| &row.cell.key))
        .column(Metric::Count(RUNS).entry(|row: &Row<'a>| Some(f64::from(row.cell.runs))));
    let metrics = metrics();
    for metric in &metrics {
        if let Metric::Count(count) = *metric {
            table = table.column(metric.entry(move |row: &Row<'a>| Some(f64::from(row.cell.count(count)))));
        }
    }
    for metric in metrics.iter().filter(|metric| !matches!(metric, Metric::Count(_))) {
        let name = metric.name();
        let of = move |row: &Row<'a>| row.cell.average(name);
        table = table
            .column(MEAN.of(name, move |row: &Row<'a>| of(row)?.value).of_figure(name, metric.reference().role))
            .column(number(format!("{name}_sd"), move |row| of(row)?.sd).of_figure(name, Role::Deviation));
        if matches!(*metric, Metric::Rate(_)) {
            table = table.columns(interval(name, "wilson", move |row| of(row)?.interval));
        }
    }
    for figure in Figure::ALL {
        table = table.columns(interval(figure.name(), "student", move |row| {
            row.evidence.between(figure).interval.filter(|_| !row.cell.is_of_cases)
        }));
    }
    let p90 = IMPACT_SPEED_P90.of(|row: &Row<'a>| row.evidence.impact_speed_p90.0);
    table = table.column(p90.of_figure(IMPACT_SPEED.name, Role::Plain));
    for reference in Reference::ALL {
        for (place, ColumnReference { name, .. }) in reference_rates(reference).into_iter().enumerate() {
            let part = move |row: &Row<'a>| row.evidence.rates_of(reference)[place].1;
            let rate = move |row: &Row<'a>| part(row).share_of(&row.evidence.episodes);
            let ends = move |row: &Row<'a>| (!row.cell.is_of_cases).then(|| wilson(part(row), row.evidence.episodes));
            table = table.column(share(&name, rate)).columns(interval(&name, "wilson", ends));
        }
    }
    let learning = |row: &Row<'a>| row.evidence.learning.clone();
    let disagree = move |row: &Row<'a>| Some(if learning(row)?.disagree()? { "yes" } else { "no" });
    table = table
        .column(
            BEATS_UNTRAINED.of(move |row: &Row<'a>| learning(row).map(|learning| learning.beats_untrained().name())),
        )
        .column(Column::<String>::new(TRAININGS_DISAGREE.name, "", "").of(disagree));
    let not_tested = |row: &Row<'a>| row.test().iter().filter(|cell| !cell.is_tested()).count();
    table = table.column(share(SCORE, |row| score(row.test().iter())));
    table = table.column(share(PASSED, |row| passed_share(row.test())));
    table = table.column(number(NOT_TESTED.into(), move |row| Some(not_tested(row) as f64)));
    for name in requirements {
        let named = String::from(*name);
        let applied = move |row: &Row<'a>| {
            let mut own = row.requirements.iter().filter(|each| each.key == row.cell.key);
            Some(own.find(|each| each.name == named)?.sums(CellRequirement::ALL).1.into())
        };
        table = table.column(number(applied_to(name), applied));
    }
    for (requirement, (word, counted, needs_verdict)) in
        requirements.iter().flat_map(|name| GATED.map(|gated| (String::from(*name), gated)))
    {
        let name = format!("{word}({requirement})");
        let rate = move |row: &Row<'a>| -> Option<Rate> {
            let mut own = row.requirements.iter().filter(|each| each.key == row.cell.key);
            let found = own.find(|each| each.name == requirement)?;
            (!needs_verdict || found.is_judged()).then(|| found.rate(counted))
        };
        let ends = rate.clone();
        table =
            table
                .column(share(&name, move |row| rate(row)?.value))
                .columns(interval(&name, "wilson", move |row| ends(row)?.interval));
    }
    table
}

/// The column of the number of episodes in which a requirement applied.
pub fn applied_to(requirement: &str) -> String {
    format!("applied({requirement})")
}

fn number<'a>(name: String, value: impl Fn(&KnownCell<'a>) -> Option<f64> + 'a) -> Entry<'a, KnownCell<'a>> {
    Entry::new::<f64, _>(name.into(), "".into(), "".into(), value)
}

fn share<'a>(name: &str, value: impl Fn(&KnownCell<'a>) -> Option<f64> + 'a) -> Entry<'a, KnownCell<'a>> {
    number(name.to_owned(), value).of_figure(name.to_owned(), Role::Share)
}

/// Both ends of an interval of a figure.
fn interval<'a>(
    figure: &str,
    method: &str,
    ends: impl Fn(&KnownCell<'a>) -> Option<(f64, f64)> + Clone + 'a,
) -> [Entry<'a, KnownCell<'a>>; 2] {
    let low = ends.clone();
    [
        number(format!("{figure}_{method}_low"), move |row| Some(low(row)?.0))
            .of_figure(figure.to_owned(), Role::LowerBound),
        number(format!("{figure}_{method}_high"), move |row| Some(ends(row)?.1))
            .of_figure(figure.to_owned(), Role::UpperBound),
    ]
}
