use super::names::names;
use crate::report::render::table::{Column, Depth, Section, Value};
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
    let rate = |(cell, found): &(&Cell, &CellEvidence), count: ClusteredCount| {
        let share = count.share_of(&found.episodes).unwrap_or_default();
        let interval = (!cell.is_fixed_cases()).then(|| wilson(count, found.episodes));
        let estimate = Value::estimate(Some(share), interval, 2);
        Value::or_count(estimate, Some(share), count.count() as u32, found.episodes.count() as u32)
    };
    let shown = names(cells)
        .of(|row: &(&Cell, &CellEvidence)| row.0)
        .number("collision rate", |row| rate(row, row.1.collisions))
        .each(
            Reference::ALL,
            |reference| Column::number(reference.name()),
            |reference, row| rate(row, row.1.remaining(*reference)),
        );
    let rows = evidence.iter().filter(|(_, found)| found.episodes.count() > 0);
    Some(Section {
        id: "reference-drivers",
        name: "Reference drivers",
        title: "How many collisions would remain with other drivers?",
        depth: Depth::Page,
        tables: vec![shown.table(rows)],
        notes: vec![
            "The collision rate if a reference driver had braked in the same episodes, from the instant at which the danger starts. No driver of that kind \
             avoids what remains. The difference to the driver under test is what that driver could gain. Intervals are Wilson's 95 % over the starts. A collision \
             with a car that has stopped counts as avoided."
                .into(),
        ],
        ..Section::default()
    })
}
