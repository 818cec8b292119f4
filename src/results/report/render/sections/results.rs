use std::collections::BTreeSet;

use super::Scale;
use super::names::{distinct, head, names, place, who};
use crate::report::render::page::results_picture;
use crate::report::render::table::{Column, Place, Section, Table, Value};
use crate::report::{Cell, Findings};

/// How to read the tables.
const READING: &str = "\"±\" is the standard deviation over runs. Each run is a training of its own, or for an untrained controller a seed of its own. \
    The interval is Wilson's over the starts, which the runs share. It does not say what further trainings would show. \
    In a collision the car moves. *With bumps*: share of the episodes in which car and pedestrian touch, also while the car \
    stands; *front*: share of these in the front sector. *Preventable*: share of the episodes that end in a collision that a careful human would have avoided. \
    *Fault*: those of them that count against the driver. The column after it is the fault rate as a share of that of the driver \
    that sees no pedestrians, or of the worst driver, with the same controller in the same town. All controllers of a town and a policy meet the same starts, within one `evaluate` block. \
    An untrained controller walks the same for every reward, so it has one row. \
    *Left out* (if there are any): share of the episodes that are in no rate, since the driver did not reach its start or left the road before it could see a pedestrian.";

/// How often cars are hit, and by which controllers; `None` without an evaluation.
pub fn results(found: &Findings<'_>) -> Option<Section> {
    let cells = &found.cells;
    let scale = Scale::new(&found.drivers, cells, &found.searches);
    (!cells.is_empty()).then(|| Section {
        id: "results",
        name: "Results",
        title: "How often cars are hit",
        lead: errors(cells),
        tables: vec![of_report(cells, scale), of_terminal(cells, scale)],
        picture: Some(results_picture(found)),
        notes: vec![READING.into()],
        ..Section::default()
    })
}

/// The table of cells for the summary. It has the mean reward if any was paid.
fn of_report(cells: &[Cell], scale: Scale<'_>) -> Table {
    let has_errors = cells.iter().any(|cell| cell.errors > 0);
    let has_left_out = cells.iter().any(|cell| cell.left_out > 0);
    let is_paid = cells.iter().any(|cell| cell.reward_sum.value.is_some_and(|reward| reward != 0.0));
    let rewards: BTreeSet<&str> = cells.iter().map(|cell| cell.key.reward.as_str()).collect();
    let mut columns = head();
    columns.push(Column::number("runs × episodes"));
    if has_left_out {
        columns.push(Column::number("left out"));
    }
    if has_errors {
        columns.push(Column::number("errors"));
    }
    // Means with a spread are left-aligned, so that the means are below each other.
    columns.extend(["collision rate", "95 % of episodes", "preventable", "fault"].map(Column::text));
    columns.extend(scale.name().map(|name| Column::number(format!("fault, of {name}'s"))));
    columns.extend(["with bumps", "front"].map(Column::text));
    if is_paid {
        columns.push(Column::text("mean reward"));
    }
    columns.extend(["length (s)", "impact speed (m/s)"].map(Column::text));
    let row = |cell: &&Cell| {
        let mut row = names(cell, cells);
        row.push(Value::Times(cell.runs.into(), u64::from(cell.episodes / cell.runs.max(1))));
        if has_left_out {
            row.push(left_out(cell));
        }
        if has_errors {
            row.push(Value::Count(cell.errors.into()));
        }
        row.extend([
            Value::spread(&cell.collision, cell.collisions, cell.episodes),
            Value::Interval(cell.collision.interval),
            Value::spread(&cell.preventable, cell.preventable_collisions(), cell.episodes),
            Value::spread(&cell.fault, cell.faults, cell.episodes),
        ]);
        row.extend(scale.name().map(|_| Value::Number(scale.share(cell, |cell| &cell.fault), 2)));
        row.extend([Value::from(&cell.touch), (&cell.front).into()]);
        if is_paid {
            // The row of an untrained controller is that of all rewards, which pay it differently.
            let one = cell.key.is_of_reward() || rewards.len() == 1;
            row.push(if one { (&cell.reward_sum).into() } else { Value::Spread(None, None) });
        }
        row.extend([Value::from(&cell.length), (&cell.impact_speed).into()]);
        row
    };
    Table { head: columns, rows: distinct(cells).iter().map(row).collect(), ..Table::default() }
}

/// The share of a cell's episodes that are in no rate.
fn left_out(cell: &Cell) -> Value {
    Value::Percent(f64::from(cell.left_out) / f64::from(cell.all.max(1)))
}

/// The rates of the cells for a terminal of 80 columns: a heading for each town and driver, and below it a row for each controller. The fault rate has its
/// scale in place of its spread.
fn of_terminal(cells: &[Cell], scale: Scale<'_>) -> Table {
    let has_errors = cells.iter().any(|cell| cell.errors > 0);
    let has_left_out = cells.iter().any(|cell| cell.left_out > 0);
    let mut columns = vec![Column::text("controller"), Column::number("n")];
    if has_left_out {
        columns.push(Column::number("left out"));
    }
    if has_errors {
        columns.push(Column::number("errors"));
    }
    columns.extend(["collision", "preventable"].map(Column::text));
    columns.push(Column::text(scale.name().map_or("fault".into(), |name| format!("fault\n(of {name})"))));
    let distinct = distinct(cells);
    let heading = |cell: &Cell| format!("{} · {}", place(cell, cells), cell.key.policy);
    let mut headings: Vec<String> = Vec::new();
    for cell in &distinct {
        let name = heading(cell);
        if !headings.contains(&name) {
            headings.push(name);
        }
    }
    let mut rows = Vec::new();
    for name in headings {
        let members: Vec<&&Cell> = distinct.iter().filter(|cell| heading(cell) == name).collect();
        let mut row = vec![Value::Text(name)];
        row.resize(columns.len(), Value::Text(String::new()));
        rows.push(row);
        for cell in members {
            let mut row = vec![Value::Text(format!("  {}", who(cell, cells))), Value::Count(cell.episodes.into())];
            if has_left_out {
                row.push(left_out(cell));
            }
            if has_errors {
                row.push(Value::Count(cell.errors.into()));
            }
            let fault = match (cell.fault.value, scale.share(cell, |cell| &cell.fault)) {
                (Some(mean), Some(share)) => format!("{mean:.2} ({share:.2})").into(),
                _ => Value::from(&cell.fault),
            };
            row.extend([
                Value::spread(&cell.collision, cell.collisions, cell.episodes),
                Value::spread(&cell.preventable, cell.preventable_collisions(), cell.episodes),
                Value::or_count(fault, cell.fault.value, cell.faults, cell.episodes),
            ]);
            rows.push(row);
        }
    }
    Table { place: Place::Terminal, head: columns, rows, ..Table::default() }
}

/// The number of episodes in which a driver or a controller failed as a program, in Markdown; empty without any.
fn errors(cells: &[Cell]) -> Vec<String> {
    let failed: u32 = cells.iter().map(|cell| cell.errors).sum();
    if failed == 0 {
        return Vec::new();
    }
    let line = |cell: &Cell| {
        let Cell { key, errors, episodes, .. } = cell;
        let place = place(cell, cells);
        format!("- {} in {place} against {}: {errors} of {}", key.controller, key.policy, episodes + errors)
    };
    let lines: Vec<String> = distinct(cells).into_iter().filter(|cell| cell.errors > 0).map(line).collect();
    vec![
        format!(
            "**In {failed} more episodes the driver or the controller failed as a program, or the episode was not run.** They count neither as passed nor as \
             failed, and no number includes them. The column `error` of `episodes.csv` has the cause of each:"
        ),
        lines.join("\n"),
    ]
}
