use super::names::{place, who};
use super::{FAULT, Scale};
use crate::report::render::table::{Column, Place, Section, Table, Value};
use crate::report::{DriverResult, Findings};
use crate::tables::metrics::{AVOIDABLE_INJURY, COLLISION_RATE, EPISODES, FAULT_RATE, PREVENTABLE_RATE};
use crate::tables::{Cell, Cells, Metric};

/// How to read the table.
const READING: &str = "Own drivers lead, baselines come last; then the order is that of *avoidable injury*: severe injuries in their faults that a careful human would have spared, for 1,000 \
    episodes; without evaluations the mean over searches. Rates are those of the worst pedestrian and town, *where that is*, chosen afterwards, so slightly too high: compare drivers by their common starts. Intervals are Wilson's 95 % over starts.";

/// What was found about each driver: those under test, and below them those that see no pedestrians. `None` without a driver.
pub fn drivers(found: &Findings<'_>) -> Option<Section> {
    let (results, cells) = (&found.drivers, &found.cells);
    let (blind, tested): (Vec<&DriverResult>, Vec<&DriverResult>) =
        results.iter().partition(|result| result.driver.sees_no_pedestrians());
    let parts = [("", tested), ("Baseline: drivers that ignore pedestrians", blind)];
    let scale = Scale::new(results, cells, &found.searches);
    let tables: Vec<Table> = parts
        .into_iter()
        .filter(|(_, of)| !of.is_empty())
        .map(|(title, of)| Table { title: title.into(), ..table(&of, cells, &scale) })
        .collect();
    (!tables.is_empty()).then(|| Section {
        id: "drivers",
        name: "Drivers",
        title: "What was found about each driver",
        tables,
        notes: vec![format!("{READING} {FAULT}")],
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

fn table(results: &[&DriverResult], cells: &Cells, scale: &Scale<'_>) -> Table {
    let evaluated = results.iter().any(|result| result.cell.is_some());
    let searched = results.iter().any(|result| result.searched.is_some());
    let injured = results.iter().any(|result| injury(result, cells).is_some());
    let injuries = std::iter::once("avoidable injury / 1,000".into()).chain(scale.head()).filter(|_| injured);
    let mut head = vec![Column::text("driver"), Column::text("worst failure"), Column::text("episode").page_only()];
    if evaluated {
        // A terminal has no room for what is the same everywhere.
        let settings =
            |result: &&DriverResult| cells.iter().filter(|cell| cell.key.policy == result.driver.name).count();
        let setting = Column::text("where that is");
        let setting = if results.iter().any(|result| settings(result) > 1) { setting } else { setting.page_only() };
        head.push(Column::number("n").page_only());
        head.extend(injuries.clone().map(|name| Column::number(name).page_only()));
        head.push(Column::number("fault (95 %)"));
        head.push(setting);
        head.push(Column::number("preventable (95 %)").page_only());
        // The setting is that of the most avoidable injury, and others may have more collisions: the page says so beside it.
        head.push(Column::number("collision (95 %)").page_only());
    }
    if searched {
        // A terminal shows the searches in a table of their own.
        let found = Column::text("found by searches");
        if !evaluated {
            head.extend(injuries.map(Column::number));
        }
        head.push(if evaluated { found.page_only() } else { found });
    }
    let of_injury = |result: &DriverResult| {
        let share = scale.head().map(|_| Value::number(scale.injury_of(result), 2));
        [Value::number(injury(result, cells), 2)].into_iter().chain(share).filter(|_| injured)
    };
    let row = |result: &&DriverResult| {
        let mut row = vec![
            Value::from(&result.driver.name),
            result.worst_in_words().into(),
            result.worst.as_ref().map_or_else(|| "–".into(), |worst| Value::failure(worst.name())),
        ];
        let cell = result.cell.map(|cell| &cells[cell]);
        if evaluated {
            row.push(cell.map_or(Value::none(), |cell| Value::Count(cell.count(&EPISODES).into())));
            row.extend(of_injury(result));
            row.extend([
                share(cell, &FAULT_RATE),
                cell.map_or(Value::text("–"), |cell| {
                    format!("{} in {}", who(cell, cells), place(cell, cells)).into()
                }),
                share(cell, &PREVENTABLE_RATE),
                share(cell, &COLLISION_RATE),
            ]);
        }
        if searched {
            if !evaluated {
                row.extend(of_injury(result));
            }
            row.push(match result.searched {
                Some(found) if found.episodes == 0 => "nothing: not one episode".into(),
                Some(found) => {
                    let (fault, preventable) = (found.fault, found.preventable);
                    let faults = if fault == 1 { "1 fault".into() } else { format!("{fault} faults") };
                    format!("{} failures: {preventable} preventable, {faults}", found.all).into()
                }
                None => Value::text("–"),
            });
        }
        row
    };
    Table { place: Place::Everywhere, head, rows: results.iter().map(row).collect(), ..Table::default() }
}

/// A share of a cell with its interval.
fn share(cell: Option<&Cell>, metric: &Metric) -> Value {
    cell.map_or(Value::estimate(None, None, 2), |cell| Value::share(cell, metric))
}
