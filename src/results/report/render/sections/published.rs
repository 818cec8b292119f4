use crate::report::render::table::{Column, Place, Section, Selection, Table, Value, unique};
use crate::report::{Findings, PublishedComparison};

/// The most cells in a terminal.
const MAX_CELLS: usize = 4;

/// Published figures compared with ours; `None` without any.
pub fn published(found: &Findings<'_>) -> Option<Section> {
    let all = &found.published;
    let first = all.first()?;
    Some(Section {
        id: "published",
        name: "Published",
        title: "Compared with published figures",
        tables: all.chunk_by(|a, b| a.source == b.source).map(table).chain([beside(all)]).collect(),
        notes: vec![format!(
            "The interval of a difference follows from {} trainings here and their starts, and from {} trainings there; fewer than four have none. A few trainings can \
             only show large differences.",
            first.runs, first.published_runs,
        )],
        ..Section::default()
    })
}

/// The published means with ours, for a terminal: a row for each of the first cells, controller by controller.
fn beside(all: &[PublishedComparison<'_>]) -> Table {
    let figures = unique(all.iter().map(|row| row.published.column));
    let several = all.iter().any(|row| row.key.policy != all[0].key.policy);
    let mut cells: Vec<&[PublishedComparison<'_>]> =
        all.chunk_by(|a, b| a.source == b.source && a.key == b.key).collect();
    cells.sort_by_key(|rows| all.iter().position(|first| first.key.controller == rows[0].key.controller));
    let shown = Selection::new()
        .text("pedestrian", |rows: &&[PublishedComparison<'_>]| {
            format!("{} {}", rows[0].key.controller, rows[0].key.reward)
        })
        .text("town", |rows| rows[0].key.town.clone())
        .when(several, |shown| shown.text("driver", |rows| rows[0].key.policy.clone()))
        .each(
            figures,
            |figure| Column::number(figure.trim_end_matches("_rate").replace('_', " ")),
            |figure, rows| {
                let row = rows.iter().find(|row| row.published.column == *figure)?;
                let [theirs, ours] = [Some(row.published.mean), row.ours.value].map(|mean| Value::number(mean, 2));
                Some(Value::Change(Box::new(theirs), Box::new(ours)))
            },
        );
    let left = match cells.len().saturating_sub(MAX_CELLS) {
        0 => String::new(),
        left => format!(" ({left} more in report.html)"),
    };
    Table {
        title: format!("Published → here{left}"),
        place: Place::Terminal,
        ..shown.table(cells.iter().take(MAX_CELLS))
    }
}

fn table(rows: &[PublishedComparison<'_>]) -> Table {
    let shown = Selection::new()
        .text("pedestrian", |row: &PublishedComparison<'_>| row.key.controller.clone())
        .text("reward", |row| row.key.reward.clone())
        .text("town", |row| row.key.town.clone())
        .text("driver", |row| row.key.policy.clone())
        .text("figure", |row| row.published.column.replace('_', " "))
        .number("published", |row| Value::from(&row.theirs()))
        .number("here", |row| Value::from(&row.ours))
        .number("difference, 95 %", |row| Value::difference(row.difference, row.interval));
    Table {
        title: format!("{} ({} trainings)", rows[0].source, rows[0].published_runs),
        notes: if rows[0].docs.is_empty() { Vec::new() } else { vec![rows[0].docs.to_string()] },
        ..shown.table(rows)
    }
}
