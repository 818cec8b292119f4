//! Lights, speed signs and limits of maps of other tools, compared with a table that another parser made of their XML.

use std::collections::BTreeMap;

use crate::{gzip, reference, repository};
use needs::needs;
use road::geometry::{Point, Vector};
use road::opendrive::read;
use road::{LaneFilter, LaneKind, SpeedSign, Town};

/// A place of the table: road, lane, and the rest as a text; with its distance along the road (m).
type Place = (String, f64);

/// Where a place is on the nearest driving lane.
fn place(town: &Town, kind: &str, at: Point, value: &str) -> Place {
    let lane = town.nearest_lane(at, LaneFilter::Driving).expect("a driving lane");
    let road = &town.roads[lane.road.0 as usize];
    (format!("{kind} of road {}, lane {}, {value}", road.id, lane.lane), lane.s)
}

fn ours(town: &Town) -> Vec<Place> {
    let kmh = |limit: f64| format!("{:.1}", limit * 3.6);
    let lights = town.traffic_lights.iter().map(|light| place(town, "light", light.stop.position(), &light.signal));
    // The box of a sign ends at it.
    let front = |sign: &SpeedSign| sign.trigger.pose.to_world(Vector::new(sign.trigger.half.x, 0.0));
    let signs = town.speed_signs.iter().map(|sign| place(town, "sign", front(sign), &kmh(sign.limit)));
    let mut count: BTreeMap<String, f64> = BTreeMap::new();
    for section in town.roads.iter().flat_map(|road| &road.sections) {
        let middle = (section.start + section.end) / 2.0;
        for lane in section.lanes.iter().filter(|lane| lane.kind == LaneKind::Driving && lane.id != 0) {
            let limit = lane.limits.iter().rev().find(|(begin, _)| *begin <= middle).and_then(|(_, limit)| *limit);
            limit.into_iter().for_each(|limit| *count.entry(kmh(limit)).or_default() += 1.0);
        }
    }
    let limits = count.into_iter().map(|(limit, count)| (format!("limit of road , lane , {limit}"), count));
    lights.chain(signs).chain(limits).collect()
}

#[needs(reference = "maps/e6mini.xodr")]
#[test]
fn signals_of_other_tools_agree_with_the_reference() {
    let read_table =
        |name: &str| std::fs::read_to_string(repository().join("tests/reference/map_signals").join(name)).unwrap();
    let (table, sizes) = (read_table("signals.csv"), read_table("maps.csv"));
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
        if !sizes.contains(&format!("\n{map},{},", xml.len())) {
            loud!("SKIPPED: {map} is another version");
            continue;
        }
        let mut ours = ours(&Town::new(read(&xml, map).unwrap()));
        let order = |one: &Place, other: &Place| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1));
        ours.sort_by(order);
        theirs.sort_by(order);
        loud!("{map}: {} places", theirs.len());
        let same = |(ours, theirs): (&Place, &Place)| ours.0 == theirs.0 && (ours.1 - theirs.1).abs() < 2.0;
        let all = ours.len() == theirs.len() && ours.iter().zip(&theirs).all(same);
        assert!(all, "{map}: {ours:#?}, not {theirs:#?}");
    }
}
