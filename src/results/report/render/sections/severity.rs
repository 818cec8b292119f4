use super::names::{head, names};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellEvidence, Quantiles};

/// Impact speeds and near misses.
pub fn severity(cells: &[Cell], evidence: &[(&Cell, &CellEvidence)]) -> Option<Section> {
    let mut columns = head();
    for quantity in
        ["impact speed: median, P90, P99 (m/s)", "least TTC: P1, P10, median (s)", "PET: P1, P10, median (s)"]
    {
        columns.extend([Column::number(quantity), Column::number("n")]);
    }
    let row = |(cell, found): &(&Cell, &CellEvidence)| {
        let mut row = names(cell, cells);
        for quantiles in [&found.impact_speed, &found.min_ttc, &found.pet] {
            row.extend([three(quantiles), Value::Count(quantiles.n)]);
        }
        row
    };
    (!evidence.is_empty()).then(|| Section {
        id: "severity",
        name: "Severity",
        title: "How hard, and how near?",
        tables: vec![Table { head: columns, rows: evidence.iter().map(row).collect(), ..Table::default() }],
        notes: vec![
            "First the speed of the car at collisions. Then how near the *other* episodes came. TTC is the least time to collision at \
             constant velocities while the car moves. PET is the post-encroachment time: between the instant at which one leaves a place and the instant at \
             which the other enters it. A small value is a near miss. n counts the episodes that have a value."
                .into(),
        ],
    })
}

fn three(quantiles: &Quantiles) -> Value {
    quantiles.at.map(|value| Value::Number(value, 2).to_string()).join(", ").into()
}
