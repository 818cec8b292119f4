//! Streets with several lanes in a direction, and one-way streets.

use proptest::prelude::*;

use super::{bend, check_links, crossing, design, faults, name, node, street, t_junction};
use road::design::{Carriageway, DesignError, Street, TownDesign};
use road::geometry::Point;
use road::{Connection, LaneFilter, LaneKind, Road, RoadLink, Town, TownParts};

/// Checks that every driving lane that ends at a junction has a way through it.
fn check_ways(town: &TownParts) {
    for (index, road) in town.roads.iter().enumerate().filter(|(_, road)| road.junction.is_none()) {
        for lane in road.sections[0].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving) {
            let Some(RoadLink::Junction(junction)) = (if lane.id < 0 { road.successor } else { road.predecessor })
            else {
                continue;
            };
            let ways = &town.junctions[junction.0 as usize].connections;
            let own = ways.iter().filter(|way| way.incoming.0 as usize == index);
            let links: Vec<_> = own.flat_map(|way| &way.lane_links).filter(|link| link.0 == lane.id).collect();
            assert!(!links.is_empty(), "{} {}: {ways:?}", road.name, lane.id);
        }
    }
}

fn lanes(forward: u32, backward: u32) -> Carriageway {
    Carriageway { forward, backward }
}

/// The places of the driving lanes of a road across its middle, from left to right.
fn places(road: &Road) -> Vec<f64> {
    let driving = road.sections[0].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving);
    driving.map(|lane| road.lane_centre(0, lane.id, 0.0).unwrap().0).collect()
}

#[test]
fn streets_with_many_lanes_and_one_way_streets_are_continuous() {
    let mut design = crossing();
    (design.streets[0].carriageway, design.streets[1].carriageway) = (lanes(2, 2), lanes(3, 0));
    let town = design.build().unwrap();
    check_links(&town, 1e-9);
    check_ways(&town);
    assert_eq!(places(&town.roads[0]), [6.0, 2.0, -2.0, -6.0]);
    assert_eq!(places(&town.roads[2]), [4.0, 0.0, -4.0], "the points of a one-way street are its middle");
    // From the west two lanes lead straight on, and the right one turns right; there is no way against the one-way street.
    let from = |road: u32, lane: i32| {
        let ways = &town.junctions[0].connections;
        let own = ways.iter().filter(move |way| way.incoming.0 == road && way.lane_links[0] == (lane, -1));
        let leads_to = |way: &Connection| match town.roads[way.connecting.0 as usize].successor {
            Some(RoadLink::Road(to, _)) => to.0,
            link => panic!("{link:?}"),
        };
        own.map(leads_to).collect::<Vec<_>>()
    };
    assert_eq!((from(0, -1), from(0, -2)), (vec![1], vec![3, 1]));
    // From the north the middle lane leads straight on only, the outer lanes turn, too.
    assert_eq!((from(2, -1), from(2, -2), from(2, -3)), (vec![3, 1], vec![3], vec![0, 3]));
    // Sidewalks lead around all four corners, those without a lane included.
    let around = town.roads.iter().filter(|road| {
        road.junction.is_some() && road.sections[0].lanes.iter().any(|lane| lane.kind == LaneKind::Sidewalk)
    });
    assert_eq!(around.count(), 4);
}

#[test]
fn a_one_way_ring_bends_in_its_direction() {
    let corners = [("a", 0.0, 0.0), ("b", 100.0, 0.0), ("c", 100.0, 90.0), ("d", 0.0, 90.0)];
    let mut design = design(&corners, &[("first", &[0, 1, 2]), ("second", &[2, 3, 0])]);
    for street in &mut design.streets {
        street.carriageway = lanes(2, 0);
    }
    let town = Town::new(design.build().unwrap());
    check_links(&design.build().unwrap(), 1e-9);
    let start = town.nearest_lane(Point::new(50.0, 2.0), LaneFilter::Driving).unwrap();
    let (mut here, mut length) = (start, 0.0);
    loop {
        let mut next = Vec::new();
        town.next(here, 1.0, &mut next);
        let [only] = next[..] else { panic!("{next:?}") };
        (here, length) = (only, length + 1.0);
        if here.is_on_lane_of(&start) && length > 100.0 {
            break;
        }
    }
    assert!((300.0..380.0).contains(&length), "{length}");
}

#[test]
fn every_lane_has_its_sign_and_its_light() {
    let mut design = t_junction();
    design.nodes[1].lights = true;
    (design.streets[0].carriageway, design.streets[1].carriageway) = (lanes(2, 2), lanes(2, 0));
    design.streets[1].speed_limit = Some(10.0);
    let town = design.build().unwrap();
    let signs: Vec<(f64, f64)> =
        town.speed_signs.iter().map(|sign| (sign.trigger.pose.x, sign.trigger.pose.y)).collect();
    assert!(signs.iter().zip([2.0, -2.0]).all(|(sign, x)| (sign.0 - x).abs() < 1e-9 && sign.1 == 89.0), "{signs:?}");
    assert_eq!(signs.len(), 2);
    let turns: Vec<u32> = town.traffic_lights.iter().map(|light| light.turn).collect();
    assert_eq!(turns, [0, 0, 1, 1, 2, 2]);
    // Traffic that only leaves a junction needs no light and takes no turn.
    design.streets[1].nodes.reverse();
    let turns: Vec<(u32, u32)> =
        design.build().unwrap().traffic_lights.iter().map(|light| (light.turn, light.turns)).collect();
    assert_eq!(turns, [(0, 2), (0, 2), (1, 2), (1, 2)]);
}

#[test]
fn lanes_that_lead_nowhere_are_faults() {
    let against = |nodes: &[usize]| {
        let mut town =
            design(&[("a", 0.0, 0.0), ("b", 60.0, 0.0), ("c", 130.0, 0.0)], &[("one", &[0, 1]), ("two", nodes)]);
        for street in &mut town.streets {
            street.carriageway = lanes(1, 0);
        }
        town.build()
    };
    assert!(against(&[1, 2]).is_ok());
    assert_eq!(
        against(&[2, 1]).unwrap_err(),
        [DesignError::OneWayAgainst { node: name("b"), first: name("two"), second: name("one") }]
    );
    let unequal = faults(|town| {
        town.nodes.push(node("far", 200.0, 0.0));
        town.streets.push(Street { carriageway: lanes(2, 2), ..street("wide", &[2, 4]) });
    });
    assert_eq!(
        unequal,
        [DesignError::UnequalLanes { node: name("east"), first: name("wide"), second: name("High Street") }]
    );
    let stuck = |nodes: &[usize]| {
        faults(|town| {
            for street in &mut town.streets {
                street.carriageway = lanes(1, 0);
            }
            town.streets[0].nodes = vec![0, 1];
            town.streets.push(Street { carriageway: lanes(1, 0), ..street("east", nodes) });
        })
    };
    let found = stuck(&[2, 1]);
    assert!(matches!(&found[..], [DesignError::NoWay { node, stuck: true, .. }] if node == "middle"), "{found:?}");
    let mut away = t_junction();
    for street in &mut away.streets {
        street.carriageway = lanes(1, 0);
    }
    (away.streets[0].nodes, away.streets[1].nodes) = (vec![1, 0], vec![1, 3]);
    away.streets.push(Street { carriageway: lanes(1, 0), ..street("east", &[1, 2]) });
    let found = away.build().unwrap_err();
    assert!(matches!(&found[..], [DesignError::NoWay { node, stuck: false, .. }] if node == "middle"), "{found:?}");
}

#[test]
fn a_wide_street_needs_a_wide_bend() {
    let wide = |radius: f64| {
        let mut town = bend();
        town.bend_radius = radius;
        for street in &mut town.streets {
            street.carriageway = lanes(3, 3);
        }
        town.build()
    };
    check_links(&wide(16.9).unwrap(), 1e-9);
    let found = wide(16.0).unwrap_err();
    assert!(matches!(found[0], DesignError::TightBend { radius: 16.0, needed, .. } if (needed - 16.8).abs() < 1e-9));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_grid_with_lanes_is_continuous(
        shifts in prop::collection::vec((-10.0..10.0f64, -10.0..10.0f64), 9),
        carriageways in prop::collection::vec((1..=3u32, 0..=3u32), 6),
    ) {
        let mut town = TownDesign { bend_radius: 20.0, ..TownDesign::default() };
        for (place, (x, y)) in shifts.iter().enumerate() {
            let (column, row) = ((place % 3) as f64, (place / 3) as f64);
            town.nodes.push(node(&format!("n{place}"), 120.0 * column + x, 120.0 * row + y));
        }
        let lines: [&[usize]; 6] = [&[0, 1, 2], &[3, 4, 5], &[6, 7, 8], &[0, 3, 6], &[1, 4, 7], &[2, 5, 8]];
        for (index, nodes) in lines.into_iter().enumerate() {
            // The four streets around are two-way with the same lanes, so that they join where they bend.
            let around = ![1, 4].contains(&index);
            let carriageway = if around { lanes(carriageways[0].0, carriageways[0].0) } else {
                lanes(carriageways[index].0, carriageways[index].1)
            };
            town.streets.push(Street { carriageway, ..street(&format!("s{index}"), nodes) });
        }
        let parts = town.build().unwrap();
        check_links(&parts, 1e-8);
        check_ways(&parts);
    }
}
