use super::names::{place, who};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, DriverResult, FoundFailure};

/// How to read the table.
const READING: [&str; 2] = [
    "The worst failure is the one that counts most against the driver: an *attributable* one if there is any (a careful human would have avoided \
     it, and the pedestrian moved as people do), else a *preventable* one; of these the one with the fastest car.",
    "The rates are those of the controller and town named beside them, where the attributable rate is highest, then the preventable rate, then the \
     rate with a moving car. They are shares of its n episodes. The intervals are Wilson's 95 % over these episodes. The highest of several rates is chosen after \
     the fact, so it is a little too high; compare drivers by their common starts.",
];

/// What was found about each driver: those under test, and below them those that see no pedestrians. None without any driver.
///
/// `link` gives the place of a failure's player, if it has one.
pub fn drivers(
    results: &[DriverResult],
    cells: &[Cell],
    link: impl Fn(&FoundFailure) -> Option<String>,
) -> Option<Section> {
    let (blind, tested): (Vec<&DriverResult>, Vec<&DriverResult>) =
        results.iter().partition(|result| result.driver.sees_no_pedestrians());
    let parts = [("", tested), ("Drivers that see no pedestrians: they show what can be hit", blind)];
    let tables: Vec<Table> = parts
        .into_iter()
        .filter(|(_, of)| !of.is_empty())
        .map(|(title, of)| Table { title: title.into(), ..table(&of, cells, &link) })
        .collect();
    (!tables.is_empty()).then(|| Section {
        id: "drivers",
        name: "Drivers",
        title: "What was found about each driver",
        tables,
        notes: READING.map(String::from).into(),
    })
}

fn table(results: &[&DriverResult], cells: &[Cell], link: &impl Fn(&FoundFailure) -> Option<String>) -> Table {
    let evaluated = results.iter().any(|result| result.cell.is_some());
    let searched = results.iter().any(|result| result.searched.is_some());
    let mut head = vec![Column::text("driver"), Column::text("worst failure"), Column::text("episode").page_only()];
    if evaluated {
        head.extend([Column::text("highest rates").page_only(), Column::number("n").page_only()]);
        head.extend(["attributable (95 %)", "preventable (95 %)", "moving (95 %)"].map(Column::number));
        head.push(Column::number("collision").page_only());
    }
    if searched {
        // A terminal shows the searches in a table of their own.
        let found = Column::text("found by searches");
        head.push(if evaluated { found.page_only() } else { found });
    }
    let row = |result: &&DriverResult| {
        let mut row =
            vec![Value::from(&result.driver.name), worst(result).into(), episode(result.worst.as_ref(), link)];
        let cell = result.cell.map(|cell| &cells[cell]);
        if evaluated {
            row.extend([
                cell.map_or(Value::Text("–".into()), |cell| {
                    format!("{} in {}", who(cell, cells), place(cell, cells)).into()
                }),
                cell.map_or(Value::Number(None, 0), |cell| Value::Count(cell.episodes.into())),
                Value::Estimate(
                    cell.and_then(|cell| cell.attributable.mean),
                    cell.map(|cell| cell.attributable_interval),
                    2,
                ),
                Value::Estimate(
                    cell.and_then(|cell| cell.preventable.mean),
                    cell.map(|cell| cell.preventable_interval),
                    2,
                ),
                Value::Estimate(cell.and_then(|cell| cell.moving.mean), cell.map(|cell| cell.moving_interval), 2),
                Value::Number(cell.and_then(|cell| cell.collision.mean), 2),
            ]);
        }
        if searched {
            row.push(match result.searched {
                Some(found) => {
                    let (attributable, preventable) = (found.attributable, found.preventable);
                    format!("{} failures: {preventable} preventable, {attributable} attributable", found.all).into()
                }
                None => Value::Text("–".into()),
            });
        }
        row
    };
    Table { head, rows: results.iter().map(row).collect(), ..Table::default() }
}

/// The worst failure in words.
fn worst(result: &DriverResult) -> String {
    match &result.worst {
        None => "no collision".into(),
        Some(found) => format!("{}, {:.1} m/s", found.class.name(), found.impact_speed),
    }
}

fn episode(worst: Option<&FoundFailure>, link: &impl Fn(&FoundFailure) -> Option<String>) -> Value {
    match worst {
        None => Value::Text("–".into()),
        Some(found) => match link(found) {
            Some(target) => Value::Link(format!("play {}", found.name()), target),
            None => Value::Code(found.name()),
        },
    }
}
