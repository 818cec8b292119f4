use std::collections::BTreeMap;

use super::names::{place, who};
use crate::record::CellKey;
use crate::report::Findings;
use crate::report::render::table::{Column, Place, Section, Table, Value};
use crate::tables::{Cell, FAULT_VIOLATION_RATE, JUDGED, Metric, NO_VERDICT, REQUIREMENT, VIOLATION_RATE};
use verdict::NoVerdict;

/// The rates of violations of a campaign's requirements; `None` without requirements.
pub fn requirements(all: &Findings<'_>) -> Option<Section> {
    let (cells, found) = (&all.cells, &all.gathered.requirements);
    let by_cell: BTreeMap<(&CellKey, String), &Cell> =
        found.iter().map(|each| ((&each.key, each.text(&REQUIREMENT)), each)).collect();
    let mut names: Vec<(String, Option<NoVerdict>)> = Vec::new();
    for each in found.iter() {
        let name = each.text(&REQUIREMENT);
        if !names.iter().any(|(known, _)| *known == name) {
            names.push((name, NoVerdict::named(&each.text(&NO_VERDICT))));
        }
    }
    if names.is_empty() {
        return None;
    }
    let mut head = vec![Column::text("driver").key(), Column::text("town").key(), Column::text("pedestrian").key()];
    for (name, no_verdict) in &names {
        head.push(Column::number(name.as_str()));
        if no_verdict.is_none() {
            head.push(Column::number("fault"));
        }
    }
    let rate = |cell: &Cell, name: &str, metric: &Metric| {
        by_cell.get(&(&cell.key, name.to_owned())).map_or_else(
            || Value::from("–"),
            |each| match (each.count(&JUDGED), each.whole(metric)) {
                (0, _) => "not run".into(),
                (episodes, 0) => format!("never applied (0 of {episodes})").into(),
                _ => Value::share(each, metric),
            },
        )
    };
    let row = |cell: &Cell| {
        let mut row = vec![Value::from(&cell.key.policy), place(cell, cells).into(), who(cell, cells).into()];
        for (name, no_verdict) in &names {
            let shown = rate(cell, name, &VIOLATION_RATE);
            row.push(match all.gathered.failures.worst_of(&cell.key, Some(name)) {
                Some(failure) => Value::Played(Box::new(shown), failure.name()),
                None => shown,
            });
            if no_verdict.is_none() {
                row.push(rate(cell, name, &FAULT_VIOLATION_RATE));
            }
        }
        row
    };
    let rows: Vec<Vec<Value>> = cells.iter().map(row).collect();
    let of_report = Table { head: head.clone(), rows: rows.clone(), ..Table::default() };
    let title = "violations of requirements".into();
    let of_terminal = Table { place: Place::Terminal, title, head, rows, ..Table::default() };
    let refused =
        names.iter().filter_map(|(name, why)| Some(format!("`{name}` has no verdict: {}.", (*why)?.reason())));
    let notes = [
        "A requirement *never applied* where nothing that stands before its `implies` ever held, as at a crosswalk in a town without one. Violations are of the episodes in which it applied, with Wilson's 95 % interval, and beside them those that are *faults*: both careful humans, who take over at the start of the \
         danger, satisfy the requirement, and the pedestrian moved as people do."
            .into(),
    ];
    Some(Section {
        id: "requirements",
        name: "Requirements",
        title: "How often each requirement is violated",
        tables: vec![of_report, of_terminal],
        notes: notes.into_iter().chain(refused).collect(),
        ..Section::default()
    })
}
