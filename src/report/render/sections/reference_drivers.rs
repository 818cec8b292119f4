use super::names::{head, names};
use crate::judge::Reference;
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellEvidence};
use crate::statistics::{Weighted, wilson};

/// Collision rates if reference drivers controlled the brake; none without any collision.
pub fn reference_drivers(cells: &[Cell], evidence: &[(&Cell, &CellEvidence)]) -> Option<Section> {
    if evidence.iter().all(|(_, found)| found.collisions.count() == 0) {
        return None;
    }
    let mut columns = head();
    columns.push(Column::number("collision rate"));
    columns.extend(Reference::ALL.map(|reference| Column::number(reference.name())));
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let rate = |count: Weighted| {
            let share = count.share_of(&found.episodes).unwrap_or_default();
            Value::Estimate(Some(share), Some(wilson(count, found.episodes)), 2)
        };
        let mut row = names(cell, cells);
        row.push(rate(found.collisions));
        row.extend(Reference::ALL.map(|reference| rate(found.split(reference).1)));
        row
    };
    let rows = evidence.iter().filter(|(_, found)| found.episodes.count() > 0).map(row).collect();
    Some(Section {
        id: "reference-drivers",
        name: "Reference drivers",
        title: "How many collisions would remain with other drivers?",
        tables: vec![Table { head: columns, rows, ..Table::default() }],
        notes: vec![
            "The collision rate if a reference driver had braked in the same episodes, from the instant at which the danger starts. No driver of that kind \
             avoids what remains. The difference to the driver under test is what that driver could gain. Intervals are Wilson's 95 % over all episodes. A collision \
             with a car that has stopped counts as avoided."
                .into(),
        ],
    })
}
