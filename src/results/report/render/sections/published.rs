use crate::report::render::table::{Column, Depth, Section, Table, Value};
use crate::report::{Findings, PublishedComparison};

/// Published figures compared with ours; `None` without any.
pub fn published(found: &Findings<'_>) -> Option<Section> {
    let all = &found.published;
    let first = all.first()?;
    Some(Section {
        id: "published",
        name: "Published",
        title: "Compared with published figures",
        depth: Depth::Summary,
        tables: all.chunk_by(|a, b| a.source == b.source).map(table).collect(),
        notes: vec![format!(
            "The interval of a difference follows from {} trainings here and their starts, and from {} trainings there; fewer than four have none. A few trainings can \
             only show large differences.",
            first.runs, first.published_runs,
        )],
        ..Section::default()
    })
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
            Value::Difference(row.difference, row.interval),
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
