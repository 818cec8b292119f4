use crate::jobs::CoverResult;
use crate::report::aggregate::percent_above;
use crate::report::render::page::cover_pictures;
use crate::report::render::table::{Column, Place, Section, Table, Value};
use crate::report::{CoverRow, Findings};

/// What covers show: a row for each driver and town; `None` without a cover.
pub fn covers(found: &Findings<'_>) -> Option<Section> {
    let rows = &found.covers;
    if rows.is_empty() {
        return None;
    }
    let statements = rows.iter().map(|row| {
        let CoverRow { key, .. } = row;
        format!("*{} in {}, box `{}`:* {}.", key.policy, key.town, key.spawn, row.statement())
    });
    let reading = [
        "The *box* are the ranges of the spawn rule; equal parts of it are equally likely. Places on the road, what the pedestrian draws and what drivers draw \
         are chance: a part of the bound, not of the box. A point of the box for which the road has no place counts as passed.",
        "The *picture* is a local regression over the episodes before the check. The *check* runs fresh episodes, uniform in the box, and counts those that fail \
         where the picture says that they pass. The bound is Clopper and Pearson's, one-sided; all checks of a box share the 5 %, so the last one may be \
         believed. *Shown as failing* is the other side: a picture that shows everything as failing is never wrong, and says nothing.",
        "It is about this box, this pedestrian and these towns. It is no statement about other starts, and none about people.",
    ];
    Some(Section {
        id: "covers",
        name: "Covered",
        title: "What was not missed",
        figures: cover_pictures(found.finished.all::<CoverResult>(), rows).into_iter().collect(),
        tables: vec![table(rows)],
        notes: statements.chain(reading.map(String::from)).collect(),
        ..Section::default()
    })
}

fn table(rows: &[CoverRow]) -> Table {
    let head = vec![
        Column::text("driver"),
        Column::text("town"),
        Column::text("box"),
        Column::text("pedestrian").detail(),
        Column::text("counts").page_only(),
        Column::text("not shown: at most"),
        Column::text("worse than shown").page_only(),
        Column::text("better than shown").detail(),
        Column::number("shown as failing"),
        Column::number("failures"),
        Column::number("episodes"),
        Column::number("checks").detail(),
    ];
    let row = |row: &CoverRow| {
        let none = || Value::from("–");
        let bound = row.look.map(|look| percent_above(look.bound));
        let bound = match bound {
            Some(bound) if row.is_covered() => bound.into(),
            Some(bound) => Value::Warning(format!("{bound}, asked {}", percent_above(row.epsilon))),
            None => none(),
        };
        vec![
            Value::from(&row.key.policy),
            Value::from(&row.key.town),
            format!("{}: {}", row.key.spawn, row.parameters.join(", ")).into(),
            Value::from(&row.key.pedestrian),
            Value::from(&row.failure),
            bound,
            row.look.map_or_else(none, |look| Value::Of(look.worse, look.points)),
            row.look.map_or_else(none, |look| Value::Of(look.better, look.points)),
            row.shown.map_or_else(none, Value::Percent),
            Value::Count(row.failures),
            Value::Count(row.episodes),
            Value::Count(row.looks),
        ]
    };
    Table { place: Place::Everywhere, head, rows: rows.iter().map(row).collect(), ..Table::default() }
}
