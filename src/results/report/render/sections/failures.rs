use crate::report::ListedFailure;
use crate::report::render::table::{Column, Table, Value};

/// Failures with the folders of their reports as text for a terminal. When all are of one report, rows have names without its folder.
pub fn failures_for_terminal(failures: &[ListedFailure], width: u16) -> String {
    let one = failures.iter().all(|each| each.report == failures[0].report);
    let is_merged = failures.iter().any(|each| each.merged.is_some());
    let has_needs = failures.iter().any(|each| each.failure.needs.is_some());
    let has_worlds = failures.iter().any(|each| each.failure.key.cell.is_elsewhere());
    let row = |ListedFailure { report, failure, merged, .. }: &ListedFailure| {
        let name = failure.name();
        let mut row = vec![
            Value::code(if one { name } else { report.join(name).display().to_string() }),
            failure.word().into(),
            Value::number(Some(failure.impact_speed).filter(|_| failure.violation.is_none()), 1),
            failure.key.cell.policy.clone().into(),
            failure.finder().into(),
            failure.key.cell.town.clone().into(),
            failure.kind().into(),
        ];
        row.extend(has_worlds.then(|| failure.key.cell.simulator().to_owned().into()));
        row.extend(merged.filter(|_| is_merged).map(Value::Count));
        row.extend(has_needs.then(|| Value::text(failure.needs.clone().unwrap_or_default())));
        row
    };
    let mut head = vec![
        Column::text("failure"),
        Column::text("verdict"),
        Column::number("m/s"),
        Column::text("driver"),
        Column::text("found by"),
        Column::text("town"),
        Column::text("kind"),
    ];
    head.extend(has_worlds.then(|| Column::text("world")));
    head.extend(is_merged.then(|| Column::number("merged")));
    head.extend(has_needs.then(|| Column::text("needs")));
    Table { head, rows: failures.iter().map(row).collect(), ..Table::default() }.to_terminal(width)
}
