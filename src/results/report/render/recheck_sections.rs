//! What a recheck found.

use super::change_report::{ChangeReport, ChangeSection};
use super::comparison_sections::{Compared, at_most, p};
use polars::prelude::DataFrame;

use super::table::{Column, Table, Value};
use crate::record::in_world;
use crate::report::compare::drivers;
use crate::report::{NOT_MET, Recheck, RecheckNote, RecheckedFailures, crossed_table, rechecked_table};

/// The result of a recheck.
pub fn recheck_report(recheck: &Recheck) -> ChangeReport {
    let files: Vec<String> = recheck.files.iter().map(|file| file.display().to_string()).collect();
    let mut met = ChangeSection {
        heading: "failures of the report, met again by the new driver".into(),
        changes: recheck.failures.iter().flat_map(RecheckedFailures::changes).collect(),
        ..ChangeSection::default()
    };
    match recheck.failures.as_slice() {
        [] if recheck.notes.iter().any(RecheckNote::is_stop) => met.paragraphs.push("none was met yet".into()),
        [] => met.paragraphs.push("the report has none of these drivers".into()),
        rows => met.tables.push(failures(rows)),
    }
    let list = crossed_table(&recheck.crossings);
    let crossed = recheck.crossings.iter().enumerate().map(|(place, row)| ChangeSection {
        heading: format!(
            "{}: {} episodes from each of {} starts",
            row.title(),
            row.crossings,
            number(&list, place, "starts").unwrap_or_default()
        ),
        paragraphs: verdict(&list, place),
        tables: vec![crossings(&list, place)],
        is_unchanged: false,
        changes: row.changes(),
    });
    ChangeReport {
        sides: [
            recheck.report.display().to_string(),
            if files.is_empty() { "the files as they are now".into() } else { files.join(" ") },
        ],
        subject: String::new(),
        notes: recheck.notes.iter().map(ToString::to_string).collect(),
        lead: answer(recheck, &list).into_iter().chain([counted(recheck, &list)]).collect(),
        sections: std::iter::once(met).chain(crossed).collect(),
    }
}

/// Whether the new driver is better, by its starts with a fault on the fixed list; `None` without a list.
fn answer(recheck: &Recheck, list: &DataFrame) -> Option<String> {
    let names: Vec<[&str; 2]> =
        recheck.crossings.iter().map(|row| row.policies.each_ref().map(|name| &**name)).collect();
    let shown = |better: bool| {
        let side = |row: usize| number(list, row, "fault_starts_new") < number(list, row, "fault_starts_fixed");
        let rows = (0..list.height()).filter(|row| side(*row) == better);
        rows.filter_map(|row| number(list, row, "p_holm")).filter(|p| *p < 0.05).reduce(f64::min)
    };
    let found = [true, false].map(shown);
    let least = found.iter().flatten().copied().reduce(f64::min);
    (list.height() > 0).then(|| match least {
        Some(least) => {
            let verdict = Compared::of(&names).verdict(found.map(|p| p.is_some()), false);
            format!("{verdict}: starts of the fixed list with a fault (p {}).", at_most(least))
        }
        None => "No difference in faults is shown on the fixed list.".into(),
    })
}

/// The counts over all rows: of failures that were met again, and of faults of the fixed list.
fn counted(recheck: &Recheck, list: &DataFrame) -> String {
    let met = rechecked_table(&recheck.failures);
    let sum =
        |table: &DataFrame, column: &str| (0..table.height()).filter_map(|row| number(table, row, column)).sum::<f64>();
    let [failures, faults, still, turned, gone] =
        ["failures", "old_faults", "still_faults", "turned_faults", "gone"].map(|column| sum(&met, column));
    let [new, fixed, same] = ["faults_new", "faults_fixed", "faults_same"].map(|column| sum(list, column));
    let listed = match list.height() {
        0 => String::new(),
        _ => format!(" Faults of the fixed list: new {new}, fixed {fixed}, same {same}."),
    };
    format!(
        "Failures met again: {failures}, gone {gone}; faults {faults}, still {still}, and {turned} more that were none.{listed}"
    )
}

fn failures(rows: &[RecheckedFailures]) -> Table {
    let mut head: Vec<Column> = ["driver", "town", "found in", "by"].map(|name| Column::text(name).key()).into();
    head.extend(
        ["failures", "faults", "still faults", "turned faults", "still collisions", "of them worse", "better"]
            .map(Column::number),
    );
    head.extend(["gone", "not met", "errors", "avoidable injuries"].map(Column::number));
    let counts = rechecked_table(rows);
    let row = |(place, row): (usize, &RecheckedFailures)| {
        let mut values: Vec<Value> = vec![
            drivers(&row.policies).into(),
            in_world(&row.town, &row.world).into(),
            row.found_in.name().to_owned().into(),
            row.walked_by.name().to_owned().into(),
        ];
        values.extend(COUNTED.map(|name| count(&counts, place, name)));
        let injuries = ["before", "after"]
            .map(|side| number(&counts, place, &format!("avoidable_injuries_{side}")).unwrap_or_default());
        values.push(format!("{:.3} → {:.3}", injuries[0], injuries[1]).into());
        values
    };
    Table { head, rows: rows.iter().enumerate().map(row).collect(), ..Table::default() }
}

/// The counts of failures that were met again, in the order of the head.
const COUNTED: [&str; 10] = [
    "failures",
    "old_faults",
    "still_faults",
    "turned_faults",
    "still_collisions",
    "still_collisions_worse",
    "still_collisions_better",
    "gone",
    NOT_MET,
    "failed_encounters",
];

/// A number of a row; `None` if it is missing.
fn number(table: &DataFrame, row: usize, column: &str) -> Option<f64> {
    table.column(column).ok()?.get(row).ok()?.extract()
}

fn count(table: &DataFrame, row: usize, column: &str) -> Value {
    number(table, row, column).map_or("–".into(), |count| Value::Count(count as u64))
}

fn crossings(list: &DataFrame, row: usize) -> Table {
    let mut head = vec![Column::text("")];
    head.extend(["before", "after", "new", "fixed", "same", "p"].map(Column::number));
    let none = || Value::text("");
    let counts = |name: &'static str, of: &str, last: Value| {
        let counts = ["before", "after", "new", "fixed", "same"].map(|part| count(list, row, &format!("{of}_{part}")));
        std::iter::once(name.into()).chain(counts).chain([last]).collect::<Vec<Value>>()
    };
    let p = |column: &str| Value::text(number(list, row, column).map_or("–".into(), p));
    let value = |column: &str| Value::number(number(list, row, column), 2);
    let injuries = vec![
        "avoidable severe injuries in 1,000 episodes".into(),
        value("avoidable_injury_before"),
        value("avoidable_injury_after"),
        none(),
        none(),
        none(),
        p("p_starts"),
    ];
    // All collisions, also those that nobody avoids: the first to show that a driver is worse.
    let mut all_injuries = vec!["severe injuries in all collisions, after less before".into(), none()];
    all_injuries.push(value("injury_difference"));
    all_injuries.extend(std::iter::repeat_with(none).take(4));
    let (faults, starts) =
        (counts("faults", "faults", none()), counts("starts with a fault", "fault_starts", p("p_holm")));
    Table { head, rows: vec![faults, starts, injuries, all_injuries], ..Table::default() }
}

/// What the fixed list says, in sentences.
fn verdict(list: &DataFrame, row: usize) -> Vec<String> {
    let count = |column: &str| number(list, row, column).map(|count| count as u64);
    let is_idle = ["faults_before", "faults_after"].map(count) == [Some(0); 2];
    let said = count("starts_worse").zip(count("starts_better")).map(|counts| match counts {
        (0, 0) if is_idle => {
            "no episode is a fault of either driver, so the list says nothing about faults; --starts N looks at more"
                .into()
        }
        (0, 0) => "from every start the new driver's faults weigh as much as those of the old one".into(),
        (worse, better) => format!("the new driver's faults weigh more from {worse} starts, and less from {better}"),
    });
    let errors = count("failed_encounters").filter(|errors| *errors > 0);
    let errors = errors.map(|errors| format!("a driver failed as a program in {errors} episodes, which are left out"));
    said.into_iter().chain(errors).collect()
}
