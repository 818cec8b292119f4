use super::names::{head, names};
use crate::report::render::table::{Column, Depth, Section, Table, Value};
use crate::report::{CellEvidence, Findings};
use crate::tables::Cell;
use base::statistics::{ClusteredCount, wilson};
use verdict::Reference;

/// Collision rates if reference drivers controlled the brake; `None` without a collision.
pub fn reference_drivers(found: &Findings<'_>) -> Option<Section> {
    let cells = &found.cells;
    let with_evidence = |cell| Some((cell, found.evidence(cell)?));
    let evidence: Vec<(&Cell, &CellEvidence)> = cells.iter().filter_map(with_evidence).collect();
    if evidence.iter().all(|(_, found)| found.collisions.count() == 0) {
        return None;
    }
    let mut columns = head();
    columns.push(Column::number("collision rate"));
    columns.extend(Reference::ALL.map(|reference| Column::number(reference.name())));
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let rate = |count: ClusteredCount| {
            let share = count.share_of(&found.episodes).unwrap_or_default();
            let interval = (!cell.is_fixed_cases()).then(|| wilson(count, found.episodes));
            let estimate = Value::estimate(Some(share), interval, 2);
            Value::or_count(estimate, Some(share), count.count() as u32, found.episodes.count() as u32)
        };
        let mut row = names(cell, cells);
        row.push(rate(found.collisions));
        row.extend(Reference::ALL.map(|reference| rate(found.remaining(reference))));
        row
    };
    let rows = evidence.iter().filter(|(_, found)| found.episodes.count() > 0).map(row).collect();
    Some(Section {
        id: "reference-drivers",
        name: "Reference drivers",
        title: "How many collisions would remain with other drivers?",
        depth: Depth::Page,
        tables: vec![Table { head: columns, rows, ..Table::default() }],
        notes: vec![
            "The collision rate if a reference driver had braked in the same episodes, from the instant at which the danger starts. No driver of that kind \
             avoids what remains. The difference to the driver under test is what that driver could gain. Intervals are Wilson's 95 % over the starts. A collision \
             with a car that has stopped counts as avoided."
                .into(),
        ],
        ..Section::default()
    })
}
