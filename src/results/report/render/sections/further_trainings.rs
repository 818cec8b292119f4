use super::names::{head, names};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellEvidence, Figure};

/// The collision rate of each training; none when no controller was trained and each has one run.
pub fn further_trainings(cells: &[Cell], evidence: &[(&Cell, &CellEvidence)]) -> Option<Section> {
    if cells.iter().all(|cell| !cell.key.is_trained() && cell.runs == 1) {
        return None;
    }
    let mut columns = head();
    columns.push(Column::text("collision rate of each run"));
    columns.extend(["mean", "95 %"].map(Column::number));
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let between = found.between(Figure::Collision);
        let each: Vec<String> = between.by_run.iter().map(|value| Value::Number(*value, 2).to_string()).collect();
        let mut row = names(cell, cells);
        row.extend([each.join(" ").into(), Value::Number(cell.collision.mean, 2), Value::Interval(between.interval)]);
        row
    };
    let mut note = String::from(
        "The interval is Student's and about further trainings: it adds the variance of the common starts to that between trainings. ",
    );
    match cells.iter().filter(|cell| cell.key.is_trained()).map(|cell| cell.runs).min() {
        Some(1) => note.push_str("**One training says nothing about further ones.** "),
        Some(runs @ 2..4) => {
            note.push_str(&format!("**With {runs} trainings there is no interval:** read the single values. "));
        }
        _ => {}
    }
    note.push_str("`metrics.csv` has the same for the other figures, `runs.csv` the values of each run.");
    Some(Section {
        id: "further-trainings",
        name: "Further trainings",
        title: "Would other trainings show the same?",
        tables: vec![Table { head: columns, rows: evidence.iter().map(row).collect(), ..Table::default() }],
        notes: vec![note],
    })
}
