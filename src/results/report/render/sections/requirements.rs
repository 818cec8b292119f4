use super::{distinct, place, who};
use crate::record::CellKey;
use crate::report::aggregate::Counted;
use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{Cell, CellRequirement};
use world::judge::NoVerdict;

/// The link to the player of the worst violation of a requirement in a cell; none where it is not played.
pub type ViolationOf<'a> = &'a dyn Fn(&CellKey, &str) -> Option<String>;

/// The rates of violations of a campaign's requirements; none without requirements.
pub fn requirements(cells: &[Cell], found: &[CellRequirement], link: ViolationOf<'_>) -> Option<Section> {
    let mut names: Vec<(&str, Option<NoVerdict>)> = Vec::new();
    for each in found {
        if !names.iter().any(|(name, _)| *name == each.name) {
            names.push((&each.name, each.no_verdict));
        }
    }
    if names.is_empty() {
        return None;
    }
    let mut head = vec![Column::text("driver").key(), Column::text("town").key(), Column::text("controller").key()];
    for (name, no_verdict) in &names {
        head.push(Column::number(*name));
        if no_verdict.is_none() {
            head.push(Column::number("fault"));
        }
    }
    let rate = |cell: &Cell, name: &str, counted: Counted| {
        let found = found.iter().find(|each| each.key == cell.key && each.name == name);
        found.map_or_else(
            || Value::from("–"),
            |each| {
                let ((mean, _), (part, whole)) = (each.rate(counted), each.sums(counted));
                Value::or_count(Value::Estimate(mean, Some(each.interval(counted)), 2), mean, part, whole)
            },
        )
    };
    let row = |cell: &&Cell| {
        let mut row = vec![Value::from(&cell.key.policy), place(cell, cells).into(), who(cell, cells).into()];
        for (name, no_verdict) in &names {
            let shown = rate(cell, name, CellRequirement::ALL);
            row.push(match link(&cell.key, name) {
                Some(place) => Value::Played(Box::new(shown), place),
                None => shown,
            });
            if no_verdict.is_none() {
                row.push(rate(cell, name, CellRequirement::FAULTS));
            }
        }
        row
    };
    let table = Table { head, rows: distinct(cells).iter().map(row).collect(), ..Table::default() };
    let refused =
        names.iter().filter_map(|(name, why)| Some(format!("`{name}` has no verdict: {}.", (*why)?.reason())));
    let notes = [
        "Violations of all episodes, with Wilson's 95 % interval, and beside them those that are *faults*: both careful humans, who take over at the start of the \
         danger, satisfy the requirement, and the pedestrian moved as people do. `falsify failures --requirement NAME` lists them."
            .into(),
    ];
    Some(Section {
        id: "requirements",
        name: "Requirements",
        title: "How often each requirement is violated",
        tables: vec![table],
        notes: notes.into_iter().chain(refused).collect(),
    })
}
