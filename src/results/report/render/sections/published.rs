use crate::report::render::table::{Column, Place, Section, Table, Value};
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
    let mut figures: Vec<&str> = Vec::new();
    for row in all {
        if !figures.contains(&row.published.column) {
            figures.push(row.published.column);
        }
    }
    let several = all.iter().any(|row| row.key.policy != all[0].key.policy);
    let names = ["pedestrian", "town"].into_iter().chain(several.then_some("driver"));
    let mut head: Vec<Column> = names.map(Column::text).collect();
    head.extend(figures.iter().map(|figure| Column::number(figure.trim_end_matches("_rate").replace('_', " "))));
    let mut cells: Vec<&[PublishedComparison<'_>]> =
        all.chunk_by(|a, b| a.source == b.source && a.key == b.key).collect();
    cells.sort_by_key(|rows| all.iter().position(|first| first.key.controller == rows[0].key.controller));
    let row = |rows: &&[PublishedComparison<'_>]| {
        let key = &rows[0].key;
        let mut row: Vec<Value> = vec![format!("{} {}", key.controller, key.reward).into(), (&key.town).into()];
        row.extend(several.then(|| Value::from(&key.policy)));
        row.extend(figures.iter().map(|figure| {
            let found = rows.iter().find(|row| row.published.column == *figure);
            found.map_or(Value::none(), |row| {
                let [theirs, ours] = [Some(row.published.mean), row.ours.value].map(|mean| Value::number(mean, 2));
                Value::Change(Box::new(theirs), Box::new(ours))
            })
        }));
        row
    };
    let left = match cells.len().saturating_sub(MAX_CELLS) {
        0 => String::new(),
        left => format!(" ({left} more in report.html)"),
    };
    Table {
        title: format!("Published → here{left}"),
        head,
        rows: cells.iter().take(MAX_CELLS).map(row).collect(),
        place: Place::Terminal,
        ..Table::default()
    }
}

fn table(rows: &[PublishedComparison<'_>]) -> Table {
    let mut head: Vec<Column> = ["pedestrian", "reward", "town", "driver", "figure"].map(Column::text).into();
    head.extend(["published", "here", "difference, 95 %"].map(Column::number));
    let row = |row: &PublishedComparison<'_>| {
        vec![
            Value::from(&row.key.controller),
            Value::from(&row.key.reward),
            Value::from(&row.key.town),
            Value::from(&row.key.policy),
            row.published.column.replace('_', " ").into(),
            (&row.theirs()).into(),
            (&row.ours).into(),
            Value::difference(row.difference, row.interval),
        ]
    };
    Table {
        title: format!("{} ({} trainings)", rows[0].source, rows[0].published_runs),
        head,
        rows: rows.iter().map(row).collect(),
        notes: if rows[0].docs.is_empty() { Vec::new() } else { vec![rows[0].docs.to_string()] },
        ..Table::default()
    }
}
