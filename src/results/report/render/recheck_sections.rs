//! What a recheck found.

use super::change_report::{ChangeReport, ChangeSection};
use super::comparison_sections::p;
use super::table::{Column, Table, Value};
use crate::record::in_world;
use crate::report::compare::drivers;
use crate::report::recheck::is_better;
use crate::report::{
    CrossedStarts, Recheck, RecheckNote, RecheckedFailures, RerunOutcome, StartFaults, is_gone, is_not_met,
};

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
    let crossed = recheck.crossings.iter().map(|row| ChangeSection {
        heading: format!("{}: {} episodes from each of {} starts", row.title(), row.crossings, row.starts().len()),
        paragraphs: verdict(row),
        tables: vec![crossings(row)],
        is_unchanged: false,
        changes: row.changes(),
    });
    ChangeReport {
        sides: [
            recheck.report.display().to_string(),
            if files.is_empty() { "the files as they are now".into() } else { files.join(" ") },
        ],
        notes: recheck.notes.iter().map(ToString::to_string).collect(),
        lead: Vec::new(),
        sections: std::iter::once(met).chain(crossed).collect(),
    }
}

fn failures(rows: &[RecheckedFailures]) -> Table {
    let mut head: Vec<Column> = ["driver", "town", "found in", "by"].map(|name| Column::text(name).key()).into();
    head.extend(
        ["failures", "faults", "still faults", "turned faults", "still collisions", "of them worse", "better"]
            .map(Column::number),
    );
    head.extend(["gone", "not met", "errors", "avoidable injuries"].map(Column::number));
    let row = |row: &RecheckedFailures| {
        let count =
            |is: fn(&RerunOutcome, &RerunOutcome) -> bool| Value::Count(row.encounters.count(is).unwrap_or_default());
        let injuries = |of: fn((RerunOutcome, RerunOutcome)) -> RerunOutcome| -> f64 {
            row.encounters.ends().map(|ends| of(ends).avoidable_injury()).sum::<f64>() + 0.0
        };
        vec![
            drivers(&row.policies).into(),
            in_world(&row.town, &row.world).into(),
            row.found_in.name().to_owned().into(),
            row.walked_by.name().to_owned().into(),
            count(|_, _| true),
            count(|before, _| before.fault),
            count(|before, after| before.fault && after.fault),
            count(|before, after| !before.fault && after.fault),
            count(|_, after| after.is_collision()),
            count(|before, after| after.is_worse_than(before)),
            count(is_better),
            count(is_gone),
            count(is_not_met),
            Value::Count(row.encounters.errors()),
            format!("{:.3} → {:.3}", injuries(|(before, _)| before), injuries(|(_, after)| after)).into(),
        ]
    };
    Table { head, rows: rows.iter().map(row).collect(), ..Table::default() }
}

fn crossings(row: &CrossedStarts) -> Table {
    let mut head = vec![Column::text("")];
    head.extend(["before", "after", "new", "fixed", "same", "p"].map(Column::number));
    let count = |count: Option<u64>| count.map_or(Value::Text("–".into()), Value::Count);
    let p = |value: Option<f64>| Value::Text(value.map_or("–".into(), p));
    let none = || Value::Text(String::new());
    let faults = vec![
        "faults".to_owned().into(),
        count(row.encounters.count(|before, _| before.fault)),
        Value::Count(row.encounters.valid().filter(|encounter| encounter.after.fault).count() as u64),
        count(row.encounters.count(|before, after| !before.fault && after.fault)),
        count(row.encounters.count(|before, after| before.fault && !after.fault)),
        count(row.encounters.count(|before, after| before.fault && after.fault)),
        none(),
    ];
    let starts = vec![
        "starts with a fault".to_owned().into(),
        count(row.count_starts(|faults| faults.before > 0)),
        Value::Count(row.fault_starts_after()),
        count(row.count_starts(|faults| faults.is_new())),
        count(row.count_starts(|faults| faults.is_fixed())),
        count(row.count_starts(|faults| faults.before > 0 && faults.after > 0)),
        p(row.holm),
    ];
    let injury = |value: Option<f64>| Value::Number(value, 2);
    let injuries = vec![
        "avoidable severe injuries in 1,000 episodes".to_owned().into(),
        injury(row.avoidable_injury_before()),
        injury(row.avoidable_injury_after()),
        none(),
        none(),
        none(),
        p(row.p_starts()),
    ];
    // All collisions, also those that nobody avoids: the first to show that a driver is worse.
    let all_injuries = vec![
        "severe injuries in all collisions, after less before".to_owned().into(),
        none(),
        injury(row.injury_difference()),
        none(),
        none(),
        none(),
        none(),
    ];
    Table { head, rows: vec![faults, starts, injuries, all_injuries], ..Table::default() }
}

/// What the fixed list says, in sentences.
fn verdict(row: &CrossedStarts) -> Vec<String> {
    let counts = row.count_starts(StartFaults::is_worse).zip(row.count_starts(StartFaults::is_better));
    let is_idle = row.encounters.count(|before, after| before.fault || after.fault) == Some(0);
    let said = counts.map(|counts| match counts {
        (0, 0) if is_idle => {
            "no episode is a fault of either driver, so the list says nothing about faults; --starts N looks at more"
                .into()
        }
        (0, 0) => "from every start the new driver's faults weigh as much as those of the old one".into(),
        (worse, better) => format!("the new driver's faults weigh more from {worse} starts, and less from {better}"),
    });
    let errors = Some(row.encounters.errors()).filter(|errors| *errors > 0);
    let errors = errors.map(|errors| format!("a driver failed as a program in {errors} episodes, which are left out"));
    said.into_iter().chain(errors).collect()
}
