use super::{distinct, place, who};
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellRequirement};

/// The rates of violations of a campaign's requirements; none without requirements.
pub fn requirements(cells: &[Cell], found: &[CellRequirement]) -> Option<Section> {
    let mut names: Vec<&str> = Vec::new();
    for each in found {
        if !names.contains(&each.name.as_str()) {
            names.push(&each.name);
        }
    }
    if names.is_empty() {
        return None;
    }
    let mut head = vec![Column::text("driver").key(), Column::text("town").key(), Column::text("controller").key()];
    head.extend(names.iter().map(|name| Column::number(*name)));
    let rate = |cell: &Cell, name: &str| {
        let found = found.iter().find(|each| each.key == cell.key && each.name == name);
        found.map_or_else(
            || Value::from("–"),
            |each| {
                let ((mean, _), (part, whole)) = (each.rate(), each.sums());
                Value::or_count(Value::Estimate(mean, Some(each.interval()), 2), mean, part, whole)
            },
        )
    };
    let row = |cell: &&Cell| {
        let mut row = vec![Value::from(&cell.key.policy), place(cell, cells).into(), who(cell, cells).into()];
        row.extend(names.iter().map(|name| rate(cell, name)));
        row
    };
    let table = Table { head, rows: distinct(cells).iter().map(row).collect(), ..Table::default() };
    Some(Section {
        id: "requirements",
        name: "Requirements",
        title: "How often each requirement is violated",
        tables: vec![table],
        notes: vec![
            "Violations of all episodes, with Wilson's 95 % interval. `falsify failures --requirement NAME` lists them. A violation that is no collision has \
             no verdict: whether a careful human would have satisfied the requirement is not known."
                .into(),
        ],
    })
}
