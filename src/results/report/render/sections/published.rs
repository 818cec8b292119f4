use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Agreement, PublishedComparison};

/// Published figures compared with ours; none without any.
pub fn published_section(all: &[PublishedComparison<'_>]) -> Option<Section> {
    let first = all.first()?;
    let count = |agreement| all.iter().filter(|row| row.agreement() == agreement).count();
    Some(Section {
        id: "published",
        name: "Published",
        title: "Compared with published figures",
        tables: all.chunk_by(|a, b| a.source == b.source).map(table).collect(),
        notes: vec![format!(
            "Of {} figures {} are equivalent to the published ones, {} differ, {} are inconclusive and {} underpowered. *Equivalent*: two one-sided tests at \
             5 % show that the difference is below the margin, which the file states. *Differs*: a test at 5 % shows a difference; of equal figures one \
             in twenty would differ, too. *Inconclusive*: neither is shown, which is no evidence of agreement. *Underpowered*: neither is shown, and \
             there are too few runs to show equivalence of equal figures in 80 of 100 campaigns. Tests follow from {} trainings here and their \
             starts, and from {} trainings there; fewer than four have no interval. A few trainings can only show large differences.",
            all.len(),
            count(Agreement::Equivalent),
            count(Agreement::Differs),
            count(Agreement::Inconclusive),
            count(Agreement::Underpowered),
            first.runs,
            first.published_runs,
        )],
    })
}

fn table(rows: &[PublishedComparison<'_>]) -> Table {
    let mut head: Vec<Column> = ["controller", "reward", "town", "policy", "figure"].map(Column::text).into();
    head.extend(["published", "here", "difference, 95 %"].map(Column::number));
    head.push(Column::number("margin"));
    head.push(Column::text("agreement"));
    let row = |row: &PublishedComparison<'_>| {
        let agreement = row.agreement();
        let differs = agreement == Agreement::Differs;
        let name = agreement.name().to_string();
        vec![
            Value::from(&row.key.controller),
            Value::from(&row.key.reward),
            Value::from(&row.key.town),
            Value::from(&row.key.policy),
            row.published.column.replace('_', " ").into(),
            row.theirs().into(),
            row.ours.into(),
            Value::Difference(row.difference, row.interval()),
            Value::Number(row.published.margin, 2),
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
