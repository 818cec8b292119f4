use std::path::PathBuf;

use crate::failure::Failure;
use crate::report::render::table::{Column, Table, Value};

/// Failures with the folders of their reports as text for a terminal. When all are of one report, rows have names without its folder.
pub fn failures_for_terminal(failures: &[(PathBuf, Failure)], width: u16) -> String {
    let one = failures.iter().all(|(report, _)| *report == failures[0].0);
    let row = |(report, failure): &(PathBuf, Failure)| {
        let name = failure.name();
        vec![
            Value::Code(if one { name } else { report.join(name).display().to_string() }),
            failure.word().into(),
            Value::Number(Some(failure.impact_speed).filter(|_| failure.violation.is_none()), 1),
            failure.key.cell.policy.clone().into(),
            Value::Text(controller(failure)),
            failure.key.cell.town.clone().into(),
            failure.kind().into(),
        ]
    };
    let head = vec![
        Column::text("failure"),
        Column::text("verdict"),
        Column::number("m/s"),
        Column::text("driver"),
        Column::text("controller"),
        Column::text("town"),
        Column::text("kind"),
    ];
    Table { head, rows: failures.iter().map(row).collect(), ..Table::default() }.to_terminal(width)
}

/// The controller, with its reward if it was trained for one.
fn controller(failure: &Failure) -> String {
    let trained = failure.key.cell.is_trained() || (failure.is_of_search() && !failure.key.cell.reward.is_empty());
    if trained {
        format!("{} {}", failure.key.cell.controller, failure.key.cell.reward)
    } else {
        failure.key.cell.controller.clone()
    }
}
