use crate::report::ListedFailure;
use crate::report::render::table::{Selection, Value};

/// Failures with the folders of their reports as text for a terminal. When all are of one report, rows have names without its folder.
pub fn failures_for_terminal(failures: &[ListedFailure], width: u16) -> String {
    let one = failures.iter().all(|each| each.report == failures[0].report);
    let is_merged = failures.iter().any(|each| each.merged.is_some());
    let has_needs = failures.iter().any(|each| each.failure.needs.is_some());
    let has_worlds = failures.iter().any(|each| each.failure.key.cell.is_elsewhere());
    let table = Selection::new()
        .text("failure", |each: &ListedFailure| {
            let name = each.failure.name();
            Value::code(if one { name } else { each.report.join(name).display().to_string() })
        })
        .text("verdict", |each| each.failure.word())
        .number("m/s", |ListedFailure { failure, .. }| {
            Value::number(Some(failure.impact_speed).filter(|_| failure.violation.is_none()), 1)
        })
        .text("driver", |each| each.failure.key.cell.policy.clone())
        .text("found by", |each| each.failure.finder())
        .text("town", |each| each.failure.key.cell.town.clone())
        .text("kind", |each| each.failure.kind())
        .when(has_worlds, |shown| shown.text("world", |each| each.failure.key.cell.simulator().to_owned()))
        .when(is_merged, |shown| shown.number("merged", |each| each.merged))
        .when(has_needs, |shown| shown.text("needs", |each| each.failure.needs.clone().unwrap_or_default()))
        .table(failures);
    table.to_terminal(width)
}
