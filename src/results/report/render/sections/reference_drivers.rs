use super::names::{head, names};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellEvidence};
use base::statistics::{ClusteredCount, wilson};
use world::judge::Reference;

/// Collision rates if reference drivers controlled the brake; none without any collision.
pub fn reference_drivers(cells: &[Cell], evidence: &[(&Cell, &CellEvidence)]) -> Option<Section> {
    if evidence.iter().all(|(_, found)| found.collisions.count() == 0) {
        return None;
    }
    let mut columns = head();
    columns.push(Column::number("collision rate"));
    columns.extend(Reference::ALL.map(|reference| Column::number(reference.name())));
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let rate = |count: ClusteredCount| {
            let share = count.share_of(&found.episodes).unwrap_or_default();
            let estimate = Value::Estimate(Some(share), Some(wilson(count, found.episodes)), 2);
            Value::or_count(estimate, Some(share), count.count() as u32, found.episodes.count() as u32)
        };
        let mut row = names(cell, cells);
        row.push(rate(found.collisions));
        row.extend(Reference::ALL.map(|reference| rate(found.split(reference).1)));
        row
    };
    let rows = evidence.iter().filter(|(_, found)| found.episodes.count() > 0).map(row).collect();
    let remaining = Table { head: columns, rows, ..Table::default() };
    Some(Section {
        id: "reference-drivers",
        name: "Reference drivers",
        title: "How many collisions would remain with other drivers?",
        tables: [Some(remaining), false_alarms(cells)].into_iter().flatten().collect(),
        notes: vec![
            "The collision rate if a reference driver had braked in the same episodes, from the instant at which the danger starts. No driver of that kind \
             avoids what remains. The difference to the driver under test is what that driver could gain. Intervals are Wilson's 95 % over the starts. A collision \
             with a car that has stopped counts as avoided."
                .into(),
            "The second table is the price of these drivers: the share of the episodes *without* a collision in which one brakes needlessly, and in brackets the share in \
             which it brakes to a stop. *For nothing* means that a car which keeps its pace does not touch the pedestrian either. The pedestrians here look for the car; \
             ordinary ones would cause fewer false alarms."
                .into(),
        ],
    })
}

/// How often reference drivers brake needlessly; none without an episode that ended well.
fn false_alarms(cells: &[Cell]) -> Option<Table> {
    let mut columns = head();
    columns.push(Column::number("episodes without a collision"));
    columns.extend(Reference::ALL.map(|reference| Column::number(reference.name())));
    let row = |cell: &Cell| {
        let share = |count: u32| f64::from(count) / f64::from(cell.passed);
        let mut row = names(cell, cells);
        row.push(Value::Of(cell.passed.into(), cell.episodes.into()));
        row.extend(
            cell.false_alarms.map(|[brakes, stops]| Value::from(format!("{:.2} ({:.2})", share(brakes), share(stops)))),
        );
        row
    };
    let rows: Vec<_> = cells.iter().filter(|cell| cell.passed > 0).map(row).collect();
    (!rows.is_empty()).then(|| Table { head: columns, rows, ..Table::default() })
}
