use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Agreement, PublishedComparison};

/// Published figures compared with ours; none without any.
pub fn published_section(all: &[PublishedComparison<'_>]) -> Option<Section> {
    let first = all.first()?;
    let within = all.iter().filter(|row| row.agreement() == Agreement::Within).count();
    let indistinct = all.iter().filter(|row| row.agreement() == Agreement::Indistinct).count();
    Some(Section {
        id: "published",
        name: "Published",
        title: "Compared with published figures",
        tables: all.chunk_by(|a, b| a.source == b.source).map(table).collect(),
        notes: vec![format!(
            "{within} of {} are within the published spread, and {indistinct} more cannot be told apart from it. *Within its spread*: \
             no farther from the published mean than its standard deviation. *Indistinct*: farther, but Welch's 95 % interval of \
             the difference holds 0. It follows from the spreads between {} trainings here and {} there. A few trainings can only show large differences.",
            all.len(),
            first.cell.runs,
            first.published_runs,
        )],
    })
}

fn table(rows: &[PublishedComparison<'_>]) -> Table {
    let mut head: Vec<Column> = ["controller", "reward", "town", "policy", "figure"].map(Column::text).into();
    head.extend(["published", "here", "difference, 95 %"].map(Column::number));
    head.push(Column::text("agreement"));
    let row = |row: &PublishedComparison<'_>| {
        let agreement = row.agreement();
        let differs = agreement == Agreement::Differs;
        let name = agreement.name().to_string();
        vec![
            Value::from(&row.cell.key.controller),
            Value::from(&row.cell.key.reward),
            Value::from(&row.cell.key.town),
            Value::from(&row.cell.key.policy),
            row.published.column.replace('_', " ").into(),
            row.theirs().into(),
            row.ours.into(),
            Value::Difference(row.difference, row.interval),
            if differs { Value::Warning(name) } else { Value::Text(name) },
        ]
    };
    Table {
        title: format!("{} ({} trainings)", rows[0].source, rows[0].published_runs),
        head,
        rows: rows.iter().map(row).collect(),
        notes: if rows[0].docs.is_empty() { Vec::new() } else { vec![rows[0].docs.to_string()] },
    }
}
