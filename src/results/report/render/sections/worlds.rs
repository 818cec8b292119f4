use std::collections::BTreeMap;

use crate::record::CellKey;
use crate::report::render::table::{Column, Place, Section, Selection, Table, Value, unique};
use crate::report::{DriverResult, Findings};
use crate::tables::Cell;
use crate::tables::metrics::{EPISODES, FAULT_COLLISIONS};
use base::statistics::{ClusteredCount, wilson};

/// The faults of each driver in each simulator side by side; `None` if no driver drives in two.
pub fn worlds(found: &Findings<'_>) -> Option<Section> {
    let names = unique(found.cells.iter().map(|cell| cell.key.simulator()));
    let common = |result: &DriverResult| {
        let driver = result.driver.name.clone();
        let own = || found.cells.iter().filter(|cell| cell.key.policy == driver && cell.count(&EPISODES) > 0);
        let elsewhere = |cell: &Cell, world: &str| CellKey { world: world.into(), ..cell.key.clone() };
        let has = |cell: &Cell, world: &str| own().any(|other| other.key == elsewhere(cell, world));
        let driven: Vec<&str> =
            names.iter().copied().filter(|world| own().any(|cell| cell.key.simulator() == *world)).collect();
        // What is met in one of them alone says nothing about the other ones.
        let common: Vec<&Cell> = own().filter(|cell| driven.iter().all(|world| has(cell, world))).collect();
        let is_compared = driven.len() > 1 && !common.is_empty();
        is_compared.then_some((driver, common))
    };
    let rows: Vec<(String, Vec<&Cell>)> = found.drivers.iter().filter_map(common).collect();
    if rows.is_empty() {
        return None;
    }
    let shown = Selection::new().text("driver", |(driver, _): &(String, Vec<&Cell>)| driver.clone()).each(
        names,
        |name| Column::number(format!("fault, {name} (95 %)")),
        |name, (_, cells)| rate(cells.iter().copied().filter(|cell| cell.key.simulator() == *name)),
    );
    Some(Section {
        id: "worlds",
        name: "Simulators",
        title: "Do faults survive in another simulator?",
        tables: vec![Table { place: Place::Everywhere, ..shown.table(&rows) }],
        notes: vec![
            "Faults of all episodes with the pedestrians, towns and starts that all simulators have. Intervals are Wilson's 95 % over starts; `falsify recheck` meets the same faults again."
                .into(),
        ],
        ..Section::default()
    })
}

/// The faults of all episodes of some cells. Those in a town share their starts.
fn rate<'a>(cells: impl Iterator<Item = &'a Cell>) -> Value {
    let mut towns: BTreeMap<&str, (ClusteredCount, ClusteredCount, u32)> = BTreeMap::new();
    let mut is_fixed_cases = false;
    for cell in cells {
        let (faults, episodes, runs) = towns.entry(&cell.key.town).or_default();
        *faults += u64::from(cell.count(&FAULT_COLLISIONS)).into();
        *episodes += u64::from(cell.count(&EPISODES)).into();
        *runs += cell.runs();
        is_fixed_cases |= cell.is_fixed_cases();
    }
    let clustered = |of: fn(&(ClusteredCount, ClusteredCount, u32)) -> ClusteredCount| -> ClusteredCount {
        towns.values().map(|town| of(town).of_clusters(town.2.into())).sum()
    };
    let (faults, episodes) = (clustered(|town| town.0), clustered(|town| town.1));
    let share = faults.share_of(&episodes);
    let estimate = Value::estimate(share, (!is_fixed_cases && share.is_some()).then(|| wilson(faults, episodes)), 2);
    Value::or_count(estimate, share, faults.count() as u32, episodes.count() as u32)
}
