use super::FAULT;
use super::front::front;
use super::names::{place, who};
use crate::report::render::table::{Column, Place, Section, Selection, Table, Value};
use crate::report::{DriverResult, Findings, SearchFailures};
use crate::tables::metrics::{AVOIDABLE_INJURY, COLLISION_RATE, EPISODES, FAULT_RATE, PREVENTABLE_RATE};
use crate::tables::{Cell, Cells};

/// How to read the table.
const READING: &str = "Own drivers lead, baselines come last. All figures of a row but the failure, the price and the searches are of one place, *where that is*: the pedestrian and town with the driver's highest fault rate, \
    which orders the rows, too; without evaluations the share of starts from which searches found a fault does. The highest is chosen afterwards, so it is slightly too high, and another driver may have met another pedestrian: \
    compare drivers by their common starts. *Avoidable injury* are the severe injuries in faults that a careful human would have spared, for 1,000 episodes. Intervals are Wilson's 95 % over starts.";

/// What was found about each driver: those under test, and below them those that see no pedestrians. `None` without a driver.
pub fn drivers(found: &Findings<'_>) -> Option<Section> {
    let (results, cells) = (&found.drivers, &found.cells);
    let (blind, tested): (Vec<&DriverResult>, Vec<&DriverResult>) =
        results.iter().partition(|result| result.driver.sees_no_pedestrians());
    let parts = [("", tested), ("Baseline: drivers that ignore pedestrians", blind)];
    let tables: Vec<Table> = parts
        .into_iter()
        .filter(|(_, of)| !of.is_empty())
        .map(|(title, of)| Table { title: title.into(), ..table(&of, cells) })
        .collect();
    (!tables.is_empty()).then(|| Section {
        id: "drivers",
        name: "Drivers",
        title: "What was found about each driver",
        tables,
        figures: Vec::from_iter(front(found, &FAULT_RATE)),
        notes: vec![READING.into(), FAULT.into()],
        ..Section::default()
    })
}

/// The avoidable injury of a driver for 1,000 episodes, in its worst cell; without any evaluation, of its searches. `None` of the cases of a test, which are
/// no sample of episodes.
pub fn injury(result: &DriverResult, cells: &[Cell]) -> Option<f64> {
    match result.cell.map(|cell| &cells[cell]) {
        Some(cell) => cell.value(&AVOIDABLE_INJURY).filter(|_| !cell.is_fixed_cases()).map(|injury| injury * 1000.0),
        None => result.searched.and_then(|found| found.injury_per_thousand),
    }
}

fn table(results: &[&DriverResult], cells: &Cells) -> Table {
    let evaluated = results.iter().any(|result| result.cell.is_some());
    let searched = results.iter().any(|result| result.searched.is_some());
    let injured = results.iter().any(|result| injury(result, cells).is_some());
    // A terminal has no room for what is the same everywhere, nor beside evaluations for more; it shows the searches in a table of their own.
    let settings = |result: &&DriverResult| cells.iter().filter(|cell| cell.key.policy == result.driver.name).count();
    let setting = Column::text("where that is");
    let priced = results.iter().any(|result| result.price.is_some());
    let setting = if results.iter().any(|result| settings(result) > 1) { setting } else { setting.page_only() };
    let beside = |column: Column| if evaluated { column.page_only() } else { column };
    let cell = |result: &DriverResult| result.cell.map(|cell| &cells[cell]);
    let share = |metric| move |result: &DriverResult| cell(result).map(|cell| Value::share(cell, metric));
    let shown = Selection::new()
        .text("driver", |result: &DriverResult| result.driver.name.clone())
        .text("worst failure", DriverResult::worst_in_words)
        .column(Column::text("episode").page_only(), |result| {
            result.worst.as_ref().map(|worst| Value::failure(worst.name()))
        })
        // The answer has the progress in a terminal.
        .when(priced, |shown| {
            let price = |result: &DriverResult| result.price;
            shown
                .column(Column::number("progress (95 %)").page_only(), move |result| {
                    price(result).map(|price| Value::estimate(Some(price.progress), price.ends(), 2))
                })
                .column(Column::number("braked needlessly (95 %)").detail(), move |result| {
                    price(result)?.needless().map(|(share, ends)| Value::estimate(Some(share), Some(ends), 2))
                })
        })
        .when(evaluated, |shown| {
            shown.column(Column::number("n").detail(), |result| cell(result).map(|cell| cell.count(&EPISODES)))
        })
        .when(injured, |shown| {
            let injuries = Column::number("avoidable injury / 1,000");
            shown.column(beside(injuries), |result| Value::number(injury(result, cells), 2))
        })
        .when(evaluated, |shown| {
            let place = |cell| format!("{} in {}", who(cell, cells), place(cell, cells));
            shown
                .number("fault (95 %)", share(&FAULT_RATE))
                .column(setting, move |result| cell(result).map(place))
                .column(Column::number("preventable (95 %)").page_only(), share(&PREVENTABLE_RATE))
                .column(Column::number("collision (95 %)").page_only(), share(&COLLISION_RATE))
        })
        .when(searched, |shown| {
            shown.column(beside(Column::text("found by searches")), |result| result.searched.map(found_by_searches))
        });
    Table { place: Place::Everywhere, ..shown.table(results.iter().copied()) }
}

fn found_by_searches(found: SearchFailures) -> String {
    let SearchFailures { episodes, all, preventable, fault, fault_starts, breaches, .. } = found;
    let breaches = match breaches {
        0 => String::new(),
        1 => ", 1 breach".into(),
        _ => format!(", {breaches} breaches"),
    };
    let failures = if all == 1 { "failure" } else { "failures" };
    let some = format!("{all} {failures}: {preventable} preventable{breaches}");
    match (episodes, fault, fault_starts) {
        (0, ..) => "nothing: not one episode".into(),
        (_, 1, _) => format!("{some}, 1 fault"),
        (_, _, 1) => format!("{some}, {fault} faults, all from one start"),
        _ => format!("{some}, {fault} faults"),
    }
}
