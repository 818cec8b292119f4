use std::fmt::Write;

use super::names::{head, names, place};
use crate::report::Cell;
use crate::report::render::table::{Column, Table, Value};

/// The table of cells.
pub fn results(cells: &[Cell]) -> Table {
    let has_errors = cells.iter().any(|cell| cell.errors > 0);
    let mut columns = head();
    columns.push(Column::number("runs × episodes"));
    if has_errors {
        columns.push(Column::number("errors"));
    }
    // Means with a spread are left-aligned, so that the means are below each other.
    columns.extend([
        Column::text("collision rate"),
        Column::text("95 % of episodes").detail(),
        Column::text("front").detail(),
        Column::text("moving"),
        Column::text("preventable"),
        Column::text("attributable"),
        Column::text("mean reward"),
        Column::text("length (s)").detail(),
        Column::text("impact speed (m/s)").detail(),
    ]);
    let row = |cell: &Cell| {
        let mut row = names(cell, cells);
        row.push(Value::Times(cell.runs.into(), u64::from(cell.episodes / cell.runs.max(1))));
        if has_errors {
            row.push(Value::Count(cell.errors.into()));
        }
        row.extend([
            Value::from(cell.collision),
            Value::Interval(Some(cell.interval)),
            cell.front.into(),
            cell.moving.into(),
            cell.preventable.into(),
            cell.attributable.into(),
            cell.reward_sum.into(),
            cell.length.into(),
            cell.impact_speed.into(),
        ]);
        row
    };
    Table {
        head: columns,
        rows: cells.iter().map(row).collect(),
        notes: vec![
            "\"±\" is the standard deviation over runs. Each run is a training of its own, or for an untrained controller a seed of its own. \
             The interval is Wilson's over the episodes of all runs. It does not say what further trainings would show. \
             *Front*: share of the collisions that are in the front sector. *Moving*: share of the episodes that end in a collision \
             with a moving car. *Preventable*: share of the episodes that end in a collision that a careful human would have avoided. \
             *Attributable*: those of them in which the pedestrian moved as people do. All controllers of a town and a policy meet the same starts, within one `evaluate` block."
                .into(),
        ],
        ..Table::default()
    }
}

/// The number of episodes in which a driver failed as a program, in Markdown; empty without any.
pub fn errors(cells: &[Cell]) -> String {
    let failed: u32 = cells.iter().map(|cell| cell.errors).sum();
    if failed == 0 {
        return String::new();
    }
    let mut page = format!(
        "\n**In {failed} more episodes the driver failed as a program, or the episode was not run.** They count neither as passed nor as failed, \
         and no number above includes them. The column `error` of `episodes.csv` has the cause of each:\n\n"
    );
    for cell in cells.iter().filter(|cell| cell.errors > 0) {
        let (errors, all) = (cell.errors, cell.episodes + cell.errors);
        let _ = writeln!(
            page,
            "- {} in {} against {}: {errors} of {all}",
            cell.key.controller,
            place(cell, cells),
            cell.key.policy
        );
    }
    page
}
