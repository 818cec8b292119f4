use std::collections::BTreeMap;

use super::names::{place, who};
use crate::record::CellKey;
use crate::report::Findings;
use crate::report::grouped::grouped;
use crate::report::render::table::{Column, Place, Section, Selection, Table, Value};
use crate::tables::{Cell, FAULT_VIOLATION_RATE, JUDGED, Metric, NO_VERDICT, REQUIREMENT, VIOLATION_RATE};
use verdict::NoVerdict;

/// The rates of violations of a campaign's requirements; `None` without requirements.
pub fn requirements(all: &Findings<'_>) -> Option<Section> {
    let (cells, found) = (&all.cells, &all.gathered.requirements);
    let by_cell: BTreeMap<(&CellKey, String), &Cell> =
        found.iter().map(|each| ((&each.key, each.text(&REQUIREMENT)), each)).collect();
    let names = grouped(found.iter(), |each| each.text(&REQUIREMENT));
    let first = |members: &Vec<&Cell>| (members[0].text(&REQUIREMENT), NoVerdict::named(&members[0].text(&NO_VERDICT)));
    let names: Vec<(String, Option<NoVerdict>)> = names.iter().map(first).collect();
    if names.is_empty() {
        return None;
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
    let columns = names.iter().flat_map(|(name, no_verdict)| {
        std::iter::once((name, false)).chain(no_verdict.is_none().then_some((name, true)))
    });
    let shown = Selection::new()
        .column(Column::text("driver").key(), |cell: &Cell| cell.key.policy.clone())
        .column(Column::text("town").key(), |cell| place(cell, cells))
        .column(Column::text("pedestrian").key(), |cell| who(cell, cells))
        .each(
            columns,
            |(name, of_faults)| Column::number(if *of_faults { "breach" } else { name.as_str() }),
            |(name, of_faults), cell| {
                if *of_faults {
                    return rate(cell, name, &FAULT_VIOLATION_RATE);
                }
                let shown = rate(cell, name, &VIOLATION_RATE);
                match all.gathered.failures.worst_of(&cell.key, Some(name)) {
                    Some(failure) => Value::Played(Box::new(shown), failure.name()),
                    None => shown,
                }
            },
        );
    let of_report = shown.table(cells.iter());
    let title = "violations of requirements".into();
    let of_terminal = Table { place: Place::Terminal, title, ..of_report.clone() };
    let refused =
        names.iter().filter_map(|(name, why)| Some(format!("`{name}` has no verdict: {}.", (*why)?.reason())));
    let notes = [
        "A requirement *never applied* where nothing that stands before its `implies` ever held, as at a crosswalk in a town without one. Violations are of the episodes in which it applied, with Wilson's 95 % interval, and beside them *breaches*, those that count against the driver: all careful drivers, who take over at the start of the \
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
