use super::names::{place, who};
use crate::report::Findings;
use crate::report::grouped::grouped;
use crate::report::render::page::results_picture;
use crate::report::render::table::{Column, Depth, Place, Section, Selection, Table, Value};
use crate::tables::metrics::{
    ALL_EPISODES, COLLISION_RATE, EPISODES, ERRORS, FAULT_COLLISIONS, FAULT_RATE, LEFT_OUT_EPISODES,
};
use crate::tables::{Cell, Cells};

/// How to read the table.
const READING: &str = "Rates are means over the runs: trainings of a trained pedestrian, seeds of another one. Intervals are Wilson's over the starts, which the runs share; they do \
    not say what further trainings would show. In a collision the car moves. All pedestrians of a town and a driver meet the same starts. *Left out* (if there are any): share of the episodes that are in no rate, since the driver did not reach its \
    start or left the road before it could see a pedestrian. `metrics.csv` has all rates, with their spread over runs.";

/// How often collisions and faults happen, with which pedestrians; `None` without an evaluation.
pub fn results(found: &Findings<'_>) -> Option<Section> {
    let cells = &found.cells;
    (!cells.is_empty()).then(|| Section {
        id: "results",
        name: "Results",
        title: "How often collisions and faults happen",
        lead: errors(cells),
        depth: Depth::Summary,
        tables: vec![table(cells)],
        lines: pedestrians(found),
        picture: Some(results_picture(found)),
        notes: vec![READING.into()],
        ..Section::default()
    })
}

/// The share of a cell's episodes that are in no rate.
fn left_out(cell: &Cell) -> Value {
    Value::Percent(f64::from(cell.count(&LEFT_OUT_EPISODES)) / f64::from(cell.count(&ALL_EPISODES).max(1)))
}

/// The rates of the cells, narrow enough for a terminal of 80 columns: a heading for each town and driver, and below it a row for each pedestrian.
fn table(cells: &Cells) -> Table {
    let has_errors = cells.iter().any(|cell| cell.count(&ERRORS) > 0);
    let has_left_out = cells.iter().any(|cell| cell.count(&LEFT_OUT_EPISODES) > 0);
    let shown = Selection::new()
        .text("pedestrian", |cell| format!("  {}", who(cell, cells)))
        .number("runs × episodes", |cell: &Cell| {
            Value::Times(cell.runs().into(), u64::from(cell.count(&EPISODES) / cell.runs().max(1)))
        })
        .when(has_left_out, |shown| shown.number("left out", left_out))
        .when(has_errors, |shown| shown.metric(Column::number("errors"), &ERRORS))
        .metric(Column::text("collision (95 %)"), &COLLISION_RATE)
        .metric(Column::text("fault (95 %)"), &FAULT_RATE);
    Table { place: Place::Everywhere, ..shown.grouped(by_place(cells)) }
}

/// The cells of each town and driver, with the name of the two, in their order.
fn by_place(cells: &Cells) -> Vec<(String, Vec<&Cell>)> {
    let name = |cell: &&Cell| format!("{} · {}", place(cell, cells), cell.key.policy);
    grouped(cells.iter(), name).into_iter().map(|members| (name(&members[0]), members)).collect()
}

/// Of each driver under test the fault rates of the pedestrians, where the worst of them is.
fn pedestrians(found: &Findings<'_>) -> Vec<String> {
    let tested = found.drivers.iter().filter(|result| !result.driver.sees_no_pedestrians());
    let worst = tested.filter_map(|result| Some(&found.cells[result.cell?]));
    let line = |cell: &Cell| {
        let (name, mut members) =
            by_place(&found.cells).into_iter().find(|(_, all)| all.iter().any(|each| each.key == cell.key))?;
        let fault_rate = |cell: &Cell| cell.value(&FAULT_RATE).unwrap_or(0.0);
        members.sort_by(|a, b| fault_rate(b).total_cmp(&fault_rate(a)));
        let fault = |cell: &Cell| Value::spread(cell, &FAULT_RATE);
        let rate = |cell: &&Cell| format!("{} {}", who(cell, &found.cells), fault(cell));
        let rates: Vec<String> = members.iter().filter(|cell| cell.count(&FAULT_COLLISIONS) > 0).map(rate).collect();
        let of = if rates.iter().any(|rate| rate.contains('±')) { " (± over trainings)" } else { "" };
        // One pedestrian with faults is in the drivers' table.
        (rates.len() > 1).then(|| format!("faults in {name}: {}{of}", rates.join("; ")))
    };
    let mut lines: Vec<String> = worst.filter_map(line).collect();
    let is_named = |name: &str| {
        lines.iter().any(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name))
    };
    let declared = found.campaign.words.iter().filter(|word| word.form == "pedestrian" && is_named(&word.name));
    let told: Vec<String> = declared.map(|word| format!("{}: {}", word.name, word.first_sentence())).collect();
    lines.extend(told);
    lines
}

/// The number of episodes in which a driver or a pedestrian failed as a program, in Markdown; empty without any.
fn errors(cells: &Cells) -> Vec<String> {
    let failed: u32 = cells.iter().map(|cell| cell.count(&ERRORS)).sum();
    if failed == 0 {
        return Vec::new();
    }
    let line = |cell: &Cell| {
        let (place, errors) = (place(cell, cells), cell.count(&ERRORS));
        let all = cell.count(&EPISODES) + errors;
        format!("- {} in {place} against {}: {errors} of {all}", cell.key.controller, cell.key.policy)
    };
    let lines: Vec<String> = cells.iter().filter(|cell| cell.count(&ERRORS) > 0).map(line).collect();
    vec![
        format!(
            "**In {failed} more episodes the driver or the pedestrian failed as a program, or the episode was not run.** They count neither as passed nor as \
             failed, and no number includes them. The column `error` of `episodes.csv` has the cause of each:"
        ),
        lines.join("\n"),
    ]
}
