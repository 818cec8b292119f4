//! Lights, speed signs and limits of maps of other tools, compared with a table that another parser made of their XML.

use std::collections::BTreeMap;

use crate::{gzip, reference, repository};
use world::geometry::Pose;
use world::road::opendrive::read;
use world::road::{LaneFilter, LaneKind, Town};

/// A place of the table: road, lane, and the rest as a text; with its distance along the road (m).
type Place = (String, f64);

/// Where a pose is on the nearest driving lane.
fn place(town: &Town, kind: &str, pose: Pose, value: &str) -> Place {
    let lane = town.nearest_lane(pose.position(), LaneFilter::Driving).expect("a driving lane");
    let road = &town.roads[lane.road.0 as usize];
    (format!("{kind} of road {}, lane {}, {value}", road.id, lane.lane), lane.s)
}

fn ours(town: &Town) -> Vec<Place> {
    let kmh = |limit: f64| format!("{:.1}", limit * 3.6);
    let lights = town.traffic_lights.iter().map(|light| place(town, "light", light.stop, &light.signal));
    let signs = town.speed_signs.iter().map(|sign| place(town, "sign", sign.trigger.pose, &kmh(sign.limit)));
    let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| &section.lanes);
    let limits = lanes.filter(|lane| lane.kind == LaneKind::Driving).flat_map(|lane| &lane.limits);
    let mut count: BTreeMap<String, f64> = BTreeMap::new();
    limits.filter_map(|(_, limit)| *limit).for_each(|limit| *count.entry(kmh(limit)).or_default() += 1.0);
    let limits = count.into_iter().map(|(limit, count)| (format!("limit of road , lane , {limit}"), count));
    lights.chain(signs).chain(limits).collect()
}

#[test]
fn signals_of_other_tools_agree_with_the_reference() {
    let table = std::fs::read_to_string(repository().join("tests/reference/map_signals/signals.csv")).unwrap();
    let mut wanted: BTreeMap<&str, Vec<Place>> = BTreeMap::new();
    for row in table.lines().skip(1) {
        let [map, kind, road, lane, s, value] = row.split(',').collect::<Vec<_>>()[..] else { panic!("{row}") };
        let places = wanted.entry(map).or_default();
        if kind != "none" {
            places.push((format!("{kind} of road {road}, lane {lane}, {value}"), s.parse().unwrap()));
        }
    }
    for (map, mut theirs) in wanted {
        let folders = ["maps", "more/maps"].map(|folder| reference::folder().join(folder));
        let Some(xml) = folders.iter().find_map(|folder| gzip::read_text(&folder.join(format!("{map}.xodr")))) else {
            loud!("SKIPPED: no map {map}");
            continue;
        };
        let mut ours = ours(&Town::new(read(&xml, map).unwrap()));
        let order = |one: &Place, other: &Place| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1));
        ours.sort_by(order);
        theirs.sort_by(order);
        loud!("{map}: {} places", theirs.len());
        assert_eq!(ours.len(), theirs.len(), "{map}");
        for (ours, theirs) in ours.iter().zip(&theirs) {
            // The box of a sign begins a little before it.
            assert!(ours.0 == theirs.0 && (ours.1 - theirs.1).abs() < 2.0, "{map}: {ours:?}, not {theirs:?}");
        }
    }
}
