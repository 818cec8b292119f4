use std::collections::BTreeSet;

use super::{NOT_DONE, section};
use crate::jobs::SearchResult;
use crate::record::CellKey;
use crate::report::Findings;
use crate::report::render::{Column, Section, Table, Value};
use crate::tables::metrics::{COLLISION_RATE, COLLISIONS, EPISODES, FAULT_COLLISIONS};
use crate::tables::{APPLIED, Cell, REQUIREMENT, VIOLATIONS};
use compile::{HERE, NamedTown};
use verdict::Blame;
use world::av::DrivingMode;

/// Factors of the operational environment that this simulator does not have.
const NOT_MODELLED: &str = "weather other than friction, darkness other than by the sensors of a driver, slopes, kerbs, traffic beside a cast, animals, cyclists";

/// What the campaign crossed on the four axes of proposed UN guidance on automated driving: operational environment, competency, kind of scenario, rules of
/// the road. Gaps are shown.
pub fn coverage(found: &Findings<'_>) -> Section {
    let campaign = found.campaign;
    let towns = Table {
        title: "Operational environment".into(),
        head: head(
            ["town", "km of lanes", "limits, km/h", "lights", "crosswalks", "obstacles"],
            ["episodes", "faults"],
        ),
        rows: campaign.towns.iter().map(|town| environment(town, found)).collect(),
        notes: vec![format!("Not modelled: {NOT_MODELLED}.")],
        ..Table::default()
    };
    let kinds = Table {
        title: "Kinds of scenario".into(),
        head: head(["pedestrian"], ["episodes", "collisions", "faults"]),
        rows: pedestrians(found),
        ..Table::default()
    };
    let rules = campaign.requirements.iter().map(|named| {
        let of_rule = || found.gathered.requirements.iter().filter(|each| each.text(&REQUIREMENT) == *named.name);
        if of_rule().next().is_none() {
            return vec![Value::from(&*named.name), "not judged".into(), "not judged".into()];
        }
        let sum = |metric| Value::Count(of_rule().map(|each| u64::from(each.count(metric))).sum());
        vec![Value::from(&*named.name), sum(&APPLIED), sum(&VIOLATIONS)]
    });
    let rules = Table {
        title: "Rules of the road".into(),
        head: head(["requirement"], ["episodes to which it applied", "violations"]),
        rows: rules.collect(),
        ..Table::default()
    };
    let mut lead = Vec::new();
    if rules.rows.is_empty() {
        let is_protocol = !found.gathered.protocol.is_empty() || !found.layers.is_empty();
        let beside = if is_protocol { " beside the limits of the protocol's tests" } else { "" };
        lead.push(format!("No rule of the road was required{beside}: a collision is the only failure that is listed."));
    }
    let holes = holes(found);
    lead.push(match holes.as_slice() {
        [] => "Every driver met every pedestrian, and every search if there were any, in every town.".into(),
        [..] => format!("**Gaps:** not run were {}.", holes.join("; ")),
    });
    let tables = [towns, competency(found), kinds, rules].into_iter().filter(|table| !table.rows.is_empty());
    section("coverage", "Coverage", lead, tables.collect())
}

fn head<const W: usize, const N: usize>(words: [&str; W], numbers: [&str; N]) -> Vec<Column> {
    words.map(Column::text).into_iter().chain(numbers.map(Column::number)).collect()
}

/// Episodes that counted and faults of the cells of a kind.
fn sums<'a>(cells: impl Iterator<Item = &'a Cell>) -> [u64; 3] {
    cells.fold([0; 3], |[episodes, collisions, faults], cell| {
        let count = |metric| u64::from(cell.count(metric));
        [episodes + count(&EPISODES), collisions + count(&COLLISIONS), faults + count(&FAULT_COLLISIONS)]
    })
}

fn environment(named: &NamedTown, found: &Findings<'_>) -> Vec<Value> {
    let NamedTown { name, town } = named;
    let length: f64 = town.driving_lanes().iter().map(|lane| lane.length).sum();
    let signs = town.speed_signs.iter().map(|sign| sign.limit);
    let lanes = town.driving_lanes().iter().filter_map(|lane| town.limit(town.along(lane, 0.0)));
    let limits: BTreeSet<u32> = signs.chain(lanes).map(|limit| (limit * 3.6).round() as u32).collect();
    let limits: Vec<String> = limits.iter().map(u32::to_string).collect();
    let [episodes, _, faults] = sums(found.cells.iter().filter(|cell| cell.key.town == *name));
    let there = found.finished.all::<SearchResult>().iter().filter(|search| search.key.town == *name);
    let (searched, found_there) = there.fold((0, 0), |(episodes, faults), search| {
        let finds = search.failures().filter(|find| find.is(Blame::Fault));
        (episodes + search.spent.episodes, faults + finds.count() as u64)
    });
    vec![
        Value::from(name),
        Value::number(Some(length / 1000.0), 1),
        if limits.is_empty() { "none".into() } else { limits.join(", ").into() },
        Value::Count(town.traffic_lights.len() as u64),
        Value::Count(town.crosswalks.len() as u64),
        Value::Count(town.obstacles.len() as u64),
        Value::Count(episodes + searched),
        Value::Count(faults + found_there),
    ]
}

/// What drivers did at the end of listed failures, by their own word for it.
fn competency(found: &Findings<'_>) -> Table {
    let mut counted: Vec<(DrivingMode, u64, u64)> = DrivingMode::ALL.iter().map(|mode| (*mode, 0, 0)).collect();
    for driver in &found.drivers {
        for failure in found.gathered.failures.of(&driver.driver.name) {
            let mode = failure.driving_mode.unwrap_or(DrivingMode::Unknown);
            if let Some((_, all, faults)) = counted.iter_mut().find(|(known, ..)| *known == mode) {
                *all += 1;
                *faults += u64::from(failure.fault);
            }
        }
    }
    let name = |mode: &DrivingMode| mode.name().replace('_', " ");
    let row = |(mode, all, faults): &(DrivingMode, u64, u64)| {
        vec![Value::from(name(mode)), Value::Count(*all), Value::Count(*faults)]
    };
    let (failed, others): (Vec<_>, Vec<_>) = counted.into_iter().partition(|(_, all, _)| *all > 0);
    let others: Vec<String> = others.iter().map(|(mode, ..)| name(mode)).collect();
    let others = if others.is_empty() { "none".to_owned() } else { others.join(", ") };
    Table {
        title: "Competency: what the driver did when it failed".into(),
        head: head(["manoeuvre"], ["listed failures", "faults"]),
        rows: failed.iter().map(row).collect(),
        notes: vec![format!(
            "The worst failure of each start, at most 100 a driver. No listed failure ended in one of these: {others}. The column `driving_mode` of `episodes` has that in which \
             each evaluated episode ended; one that is not in it was not met there. Of searches it is known of failures alone."
        )],
        ..Table::default()
    }
}

fn pedestrians(found: &Findings<'_>) -> Vec<Vec<Value>> {
    let mut rows = Vec::new();
    let controllers: BTreeSet<&str> = found.cells.iter().map(|cell| cell.key.controller.as_str()).collect();
    for name in controllers {
        let [episodes, collisions, faults] = sums(found.cells.iter().filter(|cell| cell.key.controller == name));
        rows.push(vec![Value::from(name), Value::Count(episodes), Value::Count(collisions), Value::Count(faults)]);
    }
    let searches = found.finished.all::<SearchResult>();
    let falsifiers: BTreeSet<&str> = searches.iter().map(|search| search.key.falsifier.as_str()).collect();
    for name in falsifiers {
        let own = || searches.iter().filter(|search| search.key.falsifier == name);
        let finds = || own().flat_map(SearchResult::failures);
        rows.push(vec![
            format!("search: {name}").into(),
            Value::Count(own().map(|search| search.spent.episodes).sum()),
            Value::Count(finds().filter(|find| find.failure.outcome.is_collision()).count() as u64),
            Value::Count(finds().filter(|find| find.is(Blame::Fault)).count() as u64),
        ]);
    }
    rows
}

/// The combinations of driver, town and pedestrian or search that ran no episode that counts.
fn holes(found: &Findings<'_>) -> Vec<String> {
    let cells = found
        .cells
        .iter()
        .map(|cell| (cell.key.controller.as_str(), &cell.key.policy, &cell.key.town, u64::from(cell.count(&EPISODES))));
    let searches = found.finished.all::<SearchResult>().iter();
    let searches = searches
        .map(|search| (search.key.falsifier.as_str(), &search.key.policy, &search.key.town, search.spent.episodes));
    let all: Vec<_> = cells.chain(searches).collect();
    let ran: BTreeSet<_> = all.iter().filter(|each| each.3 > 0).map(|each| (each.0, each.1, each.2)).collect();
    let walkers: BTreeSet<&str> = all.iter().map(|each| each.0).collect();
    let mut holes = Vec::new();
    for walker in walkers {
        for driver in &found.campaign.drivers {
            let is_hole = |town: &&NamedTown| !ran.contains(&(walker, &driver.name, &town.name));
            let towns: Vec<&str> = found.campaign.towns.iter().filter(is_hole).map(|town| town.name.as_str()).collect();
            if !towns.is_empty() {
                holes.push(format!("`{walker}` against `{}` in {}", driver.name, towns.join(" and ")));
            }
        }
    }
    holes
}

/// Whether other simulators agree.
pub fn worlds(found: &Findings<'_>) -> Section {
    let elsewhere = |cell: &&Cell| cell.key.is_elsewhere();
    let row = |cell: &Cell| {
        let home = CellKey { world: HERE.into(), ..cell.key.clone() };
        let home = found.cells.iter().find(|other| other.key == home);
        let rate = |cell: &Cell| Value::share(cell, &COLLISION_RATE);
        vec![
            Value::from(&cell.key.policy),
            Value::from(&cell.key.town),
            Value::from(&cell.key.controller),
            Value::from(&cell.key.world),
            home.map_or_else(|| Value::from("not run"), rate),
            rate(cell),
        ]
    };
    let table = Table {
        head: head(["driver", "town", "pedestrian", "other simulator"], ["collisions here", "collisions there"]),
        rows: found.cells.iter().filter(elsewhere).map(row).collect(),
        ..Table::default()
    };
    if table.rows.is_empty() {
        let lead = format!(
            "{NOT_DONE} All its episodes ran in this program's own simulator; `worlds` in a block `evaluate` names others. A recheck in another one (`falsify recheck --world`) has a page of its own."
        );
        return section("worlds", "Agreement with other simulators", vec![lead], Vec::new());
    }
    section("worlds", "Agreement with other simulators", Vec::new(), vec![table])
}
