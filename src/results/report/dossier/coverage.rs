use std::collections::BTreeSet;

use super::{NOT_DONE, section};
use crate::jobs::SearchResult;
use crate::record::CellKey;
use crate::record::columns::{PEDESTRIAN, TOWN};
use crate::report::Findings;
use crate::report::grouped::grouped;
use crate::report::render::{Column, Section, Selection, Table, Value};
use crate::tables::metrics::{COLLISION_RATE, COLLISIONS, EPISODES, FAULT_COLLISIONS};
use crate::tables::{APPLIED, Cell, Metric, REQUIREMENT, VIOLATIONS};
use compile::{HERE, NamedTown};
use episode::requirement::NamedRequirement;
use verdict::Blame;
use world::av::DrivingMode;

/// Factors of the operational environment that this simulator does not have.
const NOT_MODELLED: &str = "weather other than friction, darkness other than by the sensors of a driver, slopes, kerbs, traffic beside a cast, animals, cyclists";

/// What the campaign crossed on the four axes of proposed UN guidance on automated driving: operational environment, competency, kind of scenario, rules of
/// the road. Gaps are shown.
pub fn coverage(found: &Findings<'_>) -> Section {
    let campaign = found.campaign;
    let kinds = Selection::new()
        .text("pedestrian", |(name, _): &(String, [u64; 3])| name.clone())
        .number("episodes", |(_, [episodes, ..])| *episodes)
        .number("collisions", |(_, [_, collisions, _])| *collisions)
        .number("faults", |(_, [.., faults])| *faults);
    let kinds = Table { title: "Kinds of scenario".into(), ..kinds.table(&pedestrians(found)) };
    let of_rule = |named: &NamedRequirement, count: &Metric| {
        let own = found.gathered.requirements.iter().filter(|each| each.text(&REQUIREMENT) == *named.name);
        let counts: Vec<u32> = own.map(|each| each.count(count)).collect();
        if counts.is_empty() { "not judged".into() } else { Value::from(counts.iter().sum::<u32>()) }
    };
    let rules = Selection::new()
        .text("requirement", |named: &NamedRequirement| named.name.to_string())
        .number("episodes to which it applied", |named| of_rule(named, &APPLIED))
        .number("violations", |named| of_rule(named, &VIOLATIONS));
    let rules = Table { title: "Rules of the road".into(), ..rules.table(&*campaign.requirements) };
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
    let tables =
        [environment(found), competency(found), kinds, rules].into_iter().filter(|table| !table.rows.is_empty());
    section("coverage", "Coverage", lead, tables.collect())
}

fn environment(found: &Findings<'_>) -> Table {
    let lanes = |named: &NamedTown| named.town.driving_lanes().iter().map(|lane| lane.length).sum::<f64>() / 1000.0;
    let limits = |NamedTown { town, .. }: &NamedTown| {
        let signs = town.speed_signs.iter().map(|sign| sign.limit);
        let lanes = town.driving_lanes().iter().filter_map(|lane| town.limit(town.along(lane, 0.0)));
        let limits: BTreeSet<u32> = signs.chain(lanes).map(|limit| (limit * 3.6).round() as u32).collect();
        let limits: Vec<String> = limits.iter().map(u32::to_string).collect();
        if limits.is_empty() { "none".to_owned() } else { limits.join(", ") }
    };
    let evaluated = found.cells.sums(&[TOWN], &[&EPISODES, &FAULT_COLLISIONS]);
    let evaluated = |named: &NamedTown, count: &Metric| {
        let own = evaluated.iter().find(|row| row.text(&TOWN) == named.name);
        own.map_or(0, |row| row.whole_number(count.name))
    };
    let searches = found.finished.all::<SearchResult>();
    let there = |named: &NamedTown| -> Vec<&SearchResult> {
        searches.iter().filter(|search| search.key.town == named.name).collect()
    };
    let shown = Selection::new()
        .text("town", |named: &NamedTown| named.name.clone())
        .text("km of lanes", move |named| Value::number(Some(lanes(named)), 1))
        .text("limits, km/h", limits)
        .text("lights", |named| named.town.traffic_lights.len())
        .text("crosswalks", |named| named.town.crosswalks.len())
        .text("obstacles", |named| named.town.obstacles.len())
        .number("episodes", |named| {
            evaluated(named, &EPISODES) + there(named).iter().map(|search| search.spent.episodes).sum::<u64>()
        })
        .number("faults", |named| {
            let found =
                there(named).into_iter().flat_map(SearchResult::failures).filter(|failure| failure.is(Blame::Fault));
            evaluated(named, &FAULT_COLLISIONS) + found.count() as u64
        });
    Table {
        title: "Operational environment".into(),
        notes: vec![format!("Not modelled: {NOT_MODELLED}.")],
        ..shown.table(&found.campaign.towns)
    }
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
    let name = |mode: &DrivingMode| mode.shown().replace('_', " ");
    let (failed, others): (Vec<_>, Vec<_>) = counted.into_iter().partition(|(_, all, _)| *all > 0);
    let others = others.iter().filter(|(mode, ..)| *mode != DrivingMode::Unknown);
    let others: Vec<String> = others.map(|(mode, ..)| name(mode)).collect();
    let others = if others.is_empty() { "none".to_owned() } else { others.join(", ") };
    let shown = Selection::new()
        .text("manoeuvre", |(mode, ..): &(DrivingMode, u64, u64)| name(mode))
        .number("listed failures", |(_, all, _)| *all)
        .number("faults", |(.., faults)| *faults);
    Table {
        title: "Competency: what the driver did when it failed".into(),
        notes: vec![format!(
            "The worst failure of each start, at most 100 a driver. No listed failure ended in one of these: {others}. The column `driving_mode` of `episodes` has that in which \
             each evaluated episode ended; one that is not in it was not met there. Of searches it is known of failures alone."
        )],
        ..shown.table(&failed)
    }
}

/// Episodes, collisions and faults with each pedestrian, and of each search.
fn pedestrians(found: &Findings<'_>) -> Vec<(String, [u64; 3])> {
    let counts = [&EPISODES, &COLLISIONS, &FAULT_COLLISIONS];
    let evaluated = found.cells.sums(&[PEDESTRIAN], &counts);
    let evaluated =
        evaluated.iter().map(|row| (row.text(&PEDESTRIAN), counts.map(|count| row.whole_number(count.name))));
    let mut searches = grouped(found.finished.all::<SearchResult>(), |search| &search.key.falsifier);
    searches.sort_by_key(|members| &members[0].key.falsifier);
    let searched = searches.iter().map(|members| {
        let failures = || members.iter().flat_map(|search| search.failures());
        let collisions = failures().filter(|found| found.failure.outcome.is_collision()).count() as u64;
        let faults = failures().filter(|found| found.is(Blame::Fault)).count() as u64;
        let episodes = members.iter().map(|search| search.spent.episodes).sum();
        (format!("search: {}", members[0].key.falsifier), [episodes, collisions, faults])
    });
    evaluated.chain(searched).collect()
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
    let home = |cell: &Cell| {
        let key = CellKey { world: HERE.into(), ..cell.key.clone() };
        found.cells.iter().find(|other| other.key == key)
    };
    let shown = Selection::new()
        .text("driver", |cell: &Cell| cell.key.policy.clone())
        .text("town", |cell| cell.key.town.clone())
        .text("pedestrian", |cell| cell.key.controller.clone())
        .text("other simulator", |cell| cell.key.world.clone())
        .number("collisions here", |cell| {
            home(cell).map_or("not run".into(), |home| Value::metric(home, &COLLISION_RATE))
        })
        .metric(Column::number("collisions there"), &COLLISION_RATE);
    let table = shown.table(found.cells.iter().filter(elsewhere));
    if table.rows.is_empty() {
        let lead = format!(
            "{NOT_DONE} All its episodes ran in this program's own simulator; `worlds` in a block `evaluate` names others. A recheck in another one (`falsify recheck --world`) has a page of its own."
        );
        return section("worlds", "Agreement with other simulators", vec![lead], Vec::new());
    }
    section("worlds", "Agreement with other simulators", Vec::new(), vec![table])
}
