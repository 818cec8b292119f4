use super::names::{head, names};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellEvidence, Figure};
use base::statistics::LEAST_RUNS;

/// Of 100 campaigns with two, three and four trainings: those whose bootstrap interval contains the true mean.
const HELD: [u32; 3] = [50, 75, 80];

/// The collision rate of each training; none when no controller was trained and each has one run.
pub fn further_trainings(cells: &[Cell], evidence: &[(&Cell, &CellEvidence)]) -> Option<Section> {
    if cells.iter().all(|cell| !cell.key.is_trained() && cell.runs == 1) {
        return None;
    }
    let mut columns = head();
    columns.push(Column::text("collision rate of each run"));
    columns.extend(["middle half", "bootstrap 95 %", "Student 95 %"].map(Column::number));
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let between = found.between(Figure::Collision);
        let few = (2..LEAST_RUNS).contains(&between.by_run.iter().flatten().count());
        let each: Vec<String> = between.by_run.iter().map(|value| Value::Number(*value, 2).to_string()).collect();
        let mut row = names(cell, cells);
        row.extend([
            each.join(" ").into(),
            Value::Number(between.iqm, 2),
            Value::Interval(between.bootstrap.filter(|_| !few)),
            Value::Interval(between.student),
        ]);
        row
    };
    let mut note = String::from(
        "*Middle half* is the mean without the best and the worst quarter of the runs. Both intervals are about further trainings. \
         The bootstrap draws runs and then episodes; Student's interval adds the variance of the common starts to that between trainings. ",
    );
    match cells.iter().filter(|cell| cell.key.is_trained()).map(|cell| cell.runs).min() {
        Some(1) => note.push_str("**With one training the bootstrap is about its episodes only.** "),
        Some(runs @ 2..4) => note.push_str(&format!(
            "**With {runs} trainings there is no interval:** read the single values. A bootstrap would hold the true mean in about {} of 100 \
             campaigns. ",
            HELD[runs as usize - 2]
        )),
        Some(4) => note.push_str(&format!(
            "**With 4 trainings the bootstrap interval is too narrow:** it holds the true mean in about {} of 100 campaigns. Student's \
             holds it in 95, and is wider for that reason. ",
            HELD[2]
        )),
        _ => {}
    }
    note.push_str("`cells.csv` has the same for the other figures.");
    Some(Section {
        id: "further-trainings",
        name: "Further trainings",
        title: "Would other trainings show the same?",
        tables: vec![Table { head: columns, rows: evidence.iter().map(row).collect(), ..Table::default() }],
        notes: vec![note],
    })
}
