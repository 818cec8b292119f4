//! Towns that a scenario describes.

use proptest::prelude::*;
use road::design::{BuildingRow, Carriageway, DesignError, Node, Street, TownDesign};
use road::geometry::{OrientedBox, Point, Pose, Vector, wrap_angle};
use road::{Lane, LaneKind, Road, RoadEnd, RoadIndex, RoadLink, TownParts};
use std::f64::consts::TAU;

mod carriageways;
mod faults;

fn node(name: &str, x: f64, y: f64) -> Node {
    Node { name: name.to_owned(), position: Point::new(x, y), lights: false }
}

fn street(name: &str, nodes: &[usize]) -> Street {
    Street { name: name.to_owned(), nodes: nodes.to_vec(), speed_limit: None, carriageway: Carriageway::default() }
}

fn design(nodes: &[(&str, f64, f64)], streets: &[(&str, &[usize])]) -> TownDesign {
    TownDesign {
        name: "test".to_owned(),
        nodes: nodes.iter().map(|&(name, x, y)| node(name, x, y)).collect(),
        streets: streets.iter().map(|&(name, nodes)| street(name, nodes)).collect(),
        ..TownDesign::default()
    }
}

/// A street from west to east through the origin, and one that comes from the north.
fn t_junction() -> TownDesign {
    design(
        &[("west", -80.0, 0.0), ("middle", 0.0, 0.0), ("east", 80.0, 0.0), ("north", 0.0, 90.0)],
        &[("High Street", &[0, 1, 2]), ("North Street", &[3, 1])],
    )
}

fn crossing() -> TownDesign {
    let nodes = [("w", -80.0, -9.0), ("m", 3.0, 1.0), ("e", 80.0, 0.0), ("n", 0.0, 90.0), ("s", -20.0, -70.0)];
    design(&nodes, &[("along", &[0, 1, 2]), ("across", &[3, 1, 4])])
}

fn bend() -> TownDesign {
    design(
        &[("a", 0.0, 0.0), ("b", 60.0, 0.0), ("c", 100.0, 70.0), ("d", 10.0, 80.0)],
        &[("one", &[0, 1, 2]), ("two", &[3, 2])],
    )
}

/// A block with a street around it, one through it, and one that leads away.
fn block() -> TownDesign {
    let nodes = [
        ("sw", 0.0, 0.0),
        ("se", 120.0, 0.0),
        ("ne", 130.0, 140.0),
        ("nw", 0.0, 130.0),
        ("w", 0.0, 60.0),
        ("e", 125.0, 70.0),
    ];
    let mut town = design(&nodes, &[("ring", &[0, 1, 5, 2, 3, 4, 0]), ("through", &[4, 5]), ("away", &[5, 6])]);
    town.nodes.push(node("far", 240.0, 60.0));
    town.nodes[4].lights = true;
    town.block_buildings = Some(BuildingRow { setback: 2.0, depth: 10.0, length: 14.0, gap: 3.0 });
    town
}

/// The road, lane number and end at which a lane linked to `lane` starts or ends; none into a junction or without a link.
fn linked(road: &Road, end: RoadEnd, lane: &Lane) -> Option<(RoadIndex, RoadEnd, i32)> {
    let (link, id) = match end {
        RoadEnd::Start => (road.predecessor, lane.predecessor),
        RoadEnd::End => (road.successor, lane.successor),
    };
    match link? {
        RoadLink::Road(other, other_end) => Some((other, other_end, id.expect("a linked road links its lanes"))),
        RoadLink::Junction(_) => None,
    }
}

fn pose_at(road: &Road, end: RoadEnd, lane: i32) -> Pose {
    let s = if end == RoadEnd::Start { 0.0 } else { road.length };
    road.lane_pose(0, lane, s).expect("the lane exists")
}

/// Checks that linked lanes meet, face the same way, are alike, and have the same width; gives how many links there are.
fn check_links(town: &TownParts, tolerance: f64) -> usize {
    let mut links = 0;
    for road in &town.roads {
        for end in [RoadEnd::Start, RoadEnd::End] {
            for lane in road.sections[0].lanes.iter().filter(|lane| lane.id != 0) {
                let Some((other, other_end, id)) = linked(road, end, lane) else { continue };
                let other = &town.roads[other.0 as usize];
                let (here, there) = (pose_at(road, end, lane.id), pose_at(other, other_end, id));
                let apart = (here.position() - there.position()).norm();
                assert!(apart < tolerance, "{} to {}: {apart} m apart", road.name, other.name);
                let turned = wrap_angle(here.yaw - there.yaw).abs();
                assert!(turned < tolerance, "{} to {}: turned by {turned}", road.name, other.name);
                let theirs = other.sections[0].lane(id).expect("the linked lane exists");
                assert_eq!((lane.kind, lane.width.value(0.0)), (theirs.kind, theirs.width.value(0.0)));
                links += 1;
            }
            check_inside(road);
        }
    }
    links
}

/// Checks that the lane centres of a road have neither gaps nor kinks.
fn check_inside(road: &Road) {
    let steps = (road.length / 0.05).ceil();
    for lane in road.sections[0].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving) {
        let poses = (0..=steps as usize).map(|i| road.lane_pose(0, lane.id, road.length * i as f64 / steps).unwrap());
        let poses: Vec<Pose> = poses.collect();
        for pair in poses.windows(2) {
            let step = (pair[1].position() - pair[0].position()).norm();
            let turn = wrap_angle(pair[1].yaw - pair[0].yaw).abs();
            // A lane's centre never bends more tightly than half a lane and half a metre around its inner edge.
            assert!(step < 0.1 && turn < 0.05 / 2.0, "{}: step {step}, turn {turn}", road.name);
        }
    }
}

/// The mouths (road, lane into the junction) of a junction's legs.
fn approaches(town: &TownParts, junction: u32) -> Vec<(RoadIndex, i32)> {
    let mut found = Vec::new();
    for (index, road) in town.roads.iter().enumerate() {
        let into = |link| matches!(link, Some(RoadLink::Junction(own)) if own.0 == junction);
        if into(road.successor) {
            found.push((RoadIndex(index as u32), -1));
        }
        if into(road.predecessor) {
            found.push((RoadIndex(index as u32), 1));
        }
    }
    found
}

/// Checks that every lane into a junction leads to the lane out of it on every other leg, and nowhere else.
fn check_junctions(town: &TownParts) {
    for (index, junction) in town.junctions.iter().enumerate() {
        let legs = approaches(town, index as u32);
        assert_eq!(junction.connections.len(), legs.len() * (legs.len() - 1));
        for &(road, lane) in &legs {
            let mut reached = Vec::new();
            for way in junction.connections.iter().filter(|way| way.incoming == road && way.lane_links[0].0 == lane) {
                assert_eq!((way.contact, way.lane_links[0].1), (RoadEnd::Start, -1));
                let connecting = &town.roads[way.connecting.0 as usize];
                assert_eq!(connecting.junction.map(|own| own.0), Some(index as u32));
                let driving = connecting.sections[0].lane(-1).unwrap();
                let (before, _, from) = linked(connecting, RoadEnd::Start, driving).unwrap();
                assert_eq!((before, from), (road, lane));
                let (after, _, to) = linked(connecting, RoadEnd::End, driving).unwrap();
                // The lane out of a leg is the other one of its two.
                reached.push((after, -to));
            }
            let mut others: Vec<_> = legs.iter().copied().filter(|leg| *leg != (road, lane)).collect();
            others.sort();
            reached.sort();
            assert_eq!(reached, others);
        }
    }
}

fn built(design: &TownDesign) -> TownParts {
    let town = design.build().unwrap();
    check_junctions(&town);
    let ids: std::collections::BTreeSet<u32> = town.roads.iter().map(|road| road.id).collect();
    assert_eq!(ids.len(), town.roads.len());
    town
}

#[test]
fn a_t_junction_is_continuous_and_joins_every_pair_of_legs() {
    let town = built(&t_junction());
    assert_eq!((town.roads.len(), town.junctions.len()), (3 + 6, 1));
    // Every way has a driving lane; the three rightmost ones have a shoulder and a sidewalk too, linked at both ends.
    assert_eq!(check_links(&town, 1e-9), (3 * 3 + 3) * 2);
}

#[test]
fn the_sidewalk_runs_straight_through_along_the_bar_of_a_t() {
    let town = built(&t_junction());
    let bar = town.roads.iter().find(|road| {
        let straight = (road.plan_view.pose(0.0).yaw - road.plan_view.pose(road.length).yaw).abs() < 1e-12;
        road.junction.is_some() && straight && road.sections[0].lane(-3).is_some()
    });
    // The right turn on the way from west to east is south, where no street starts.
    let middle = bar.unwrap().lane_pose(0, -3, bar.unwrap().length / 2.0).unwrap();
    assert!((middle.position() - Point::new(0.0, -6.3)).norm() < 1e-9 && middle.yaw.abs() < 1e-9, "{middle:?}");
}

#[test]
fn right_turns_keep_the_radius_of_the_corner() {
    let town = built(&t_junction());
    // From east inwards (heading west) to the north: a right turn about (10.3, 10.3).
    let turn = town.roads.iter().find(|road| {
        let (start, end) = (road.plan_view.pose(0.0), road.plan_view.pose(road.length));
        road.junction.is_some() && start.x > 5.0 && (end.yaw - TAU / 4.0).abs() < 1e-9
    });
    let turn = turn.unwrap();
    for s in [0.0, 0.3, 0.7, 1.0].map(|share| share * turn.length) {
        let centre = Point::new(10.3, 10.3);
        assert!(((turn.lane_pose(0, -1, s).unwrap().position() - centre).norm() - 8.3).abs() < 1e-9);
        assert!(((turn.lane_pose(0, -3, s).unwrap().position() - centre).norm() - 4.0).abs() < 1e-9);
    }
}

#[test]
fn a_crossing_is_continuous_and_joins_every_pair_of_legs() {
    let town = built(&crossing());
    assert_eq!((town.roads.len(), town.junctions.len()), (4 + 12, 1));
    assert_eq!(check_links(&town, 1e-9), (4 * 3 + 8) * 2);
}

#[test]
fn bends_are_arcs_of_the_bend_radius_in_either_direction_of_the_streets() {
    let town = built(&bend());
    assert_eq!((town.roads.len(), town.junctions.len()), (3 + 2, 0));
    // Two bends, each with two ends, six lanes on each side of each end's link.
    assert_eq!(check_links(&town, 1e-9), 2 * 2 * 6 * 2);
    for bend in &town.roads[3..] {
        let turn = wrap_angle(bend.plan_view.pose(bend.length).yaw - bend.plan_view.pose(0.0).yaw).abs();
        assert!((bend.length / turn - 12.0).abs() < 1e-9);
    }
}

#[test]
fn streets_in_line_are_joined_without_a_bend() {
    let town =
        built(&design(&[("a", 0.0, 0.0), ("b", 30.0, 40.0), ("c", 60.0, 80.0)], &[("one", &[0, 1]), ("two", &[2, 1])]));
    assert_eq!(town.roads.len(), 2);
    assert_eq!(check_links(&town, 1e-9), 2 * 6);
    assert_eq!(town.roads[0].successor, Some(RoadLink::Road(RoadIndex(1), RoadEnd::End)));
    assert_eq!(town.roads[0].predecessor, None);
}

#[test]
fn a_hardly_visible_bend_is_continuous_too() {
    for turn in [1e-3, 1e-5, 1e-6, 1e-8] {
        let town =
            built(&design(&[("a", 0.0, 0.0), ("b", 50.0, 0.0), ("c", 100.0, 50.0 * turn)], &[("one", &[0, 1, 2])]));
        assert_eq!(check_links(&town, 1e-9), 2 * 6 * 2, "{turn}");
    }
}

#[test]
fn speed_signs_stand_at_the_start_of_both_lanes() {
    let mut design =
        design(&[("a", 0.0, 0.0), ("b", 100.0, 0.0), ("c", 200.0, 0.0)], &[("fast", &[0, 1]), ("free", &[1, 2])]);
    design.streets[0].speed_limit = Some(13.5);
    let signs = built(&design).speed_signs;
    assert_eq!(signs.len(), 2);
    for (sign, (x, y)) in signs.iter().zip([(1.0, -2.0), (99.0, 2.0)]) {
        assert!((sign.trigger.pose.position() - Point::new(x, y)).norm() < 1e-9);
        assert_eq!((sign.limit, sign.trigger.half), (13.5, Vector::new(0.35 * 4.0, 0.35 * 4.0)));
    }
}

#[test]
fn traffic_lights_stand_on_every_approach_and_head_into_the_junction() {
    let mut design = t_junction();
    design.nodes[1].lights = true;
    let lights = built(&design).traffic_lights;
    assert_eq!(
        lights.iter().map(|light| (light.group, light.turn, light.turns)).collect::<Vec<_>>(),
        [(0, 0, 3), (0, 1, 3), (0, 2, 3)]
    );
    // Counter-clockwise from the east; roads end 10.3 m before the node.
    for (light, (x, y)) in lights.iter().zip([(13.3, 2.0), (-2.0, 13.3), (-13.3, -2.0)]) {
        assert!((light.stop.position() - Point::new(x, y)).norm() < 1e-9, "{light:?}");
        assert!(light.stop.bearing_to(Point::origin()).abs() < 0.2);
        assert_eq!((light.trigger.pose, light.trigger.half), (light.stop, Vector::new(1.5, 1.0)));
    }
}

/// Checks that no obstacle touches a lane or another obstacle.
fn check_obstacles(town: &TownParts) {
    for road in &town.roads {
        for lane in road.sections[0].lanes.iter().filter(|lane| lane.id != 0) {
            let half = lane.width.value(0.0) / 2.0 - 1e-5;
            for s in (0..).map(|i| f64::from(i) * 0.5).take_while(|&s| s <= road.length) {
                let pose = road.lane_pose(0, lane.id, s).unwrap();
                for place in [-half, 0.0, half].map(|t| pose.to_world(Vector::new(0.0, t))) {
                    assert!(town.obstacles.iter().all(|house| house.distance_to(place) > 0.0), "{} {place}", road.name);
                }
            }
        }
    }
    for (index, first) in town.obstacles.iter().enumerate() {
        let inner = OrientedBox { half: first.half.add_scalar(-1e-5), ..*first };
        for second in &town.obstacles[index + 1..] {
            let places = inner.corners();
            assert!(places.iter().chain([&first.pose.position()]).all(|&place| second.distance_to(place) > 0.0));
        }
    }
}

#[test]
fn building_rows_fill_both_sides_and_stay_off_lanes_and_each_other() {
    let mut design = block();
    let fixed = OrientedBox::new(Pose::new(50.0, 25.0, 0.5), 8.0, 4.0);
    design.buildings.push(fixed);
    let town = built(&design);
    check_obstacles(&town);
    assert_eq!(town.obstacles[0], fixed);
    assert!(town.obstacles.len() > 40, "{}", town.obstacles.len());
    let south = |house: &&OrientedBox| (house.pose.y - (-8.3 - 2.0 - 5.0)).abs() < 1e-9;
    // Between the bends at both ends about 96 m are straight.
    assert_eq!(town.obstacles.iter().filter(south).count(), 5);
}

#[test]
fn houses_that_would_reach_the_next_street_are_left_out() {
    // The street in the south and the one through the middle are 43 m apart in the west and 54 m in the east.
    let mut design = block();
    design.block_buildings = Some(BuildingRow { setback: 0.0, depth: 55.0, length: 9.0, gap: 0.0 });
    let town = built(&design);
    check_obstacles(&town);
    let inside = |house: &&OrientedBox| (0.0..120.0).contains(&house.pose.x) && (0.0..60.0).contains(&house.pose.y);
    assert_eq!(town.obstacles.iter().filter(inside).filter(|house| house.pose.yaw.abs() < 0.2).count(), 0);
    assert!(town.obstacles.len() > 20, "{}", town.obstacles.len());
}

#[test]
fn a_block_is_continuous() {
    check_links(&built(&block()), 1e-9);
}

/// The faults of a broken T-junction.
fn faults(change: impl FnOnce(&mut TownDesign)) -> Vec<DesignError> {
    let mut design = t_junction();
    change(&mut design);
    design.build().unwrap_err()
}

fn name(text: &str) -> String {
    text.to_owned()
}

proptest! {
    #[test]
    fn any_star_with_room_is_continuous(
        shares in prop::collection::vec(0.0..1.0f64, 3..=4),
        lengths in prop::collection::vec(40.0..150.0f64, 4),
        first in 0.0..TAU,
        outward in prop::collection::vec(any::<bool>(), 4),
        lane_width in 2.5..4.0f64,
    ) {
        let legs = shares.len();
        let total: f64 = shares.iter().sum::<f64>().max(1e-3);
        let free = TAU - legs as f64 * TAU / 8.0;
        let mut town = TownDesign { nodes: vec![node("middle", 10.0, -20.0)], ..TownDesign::default() };
        town.profile.lane_width = lane_width;
        town.nodes[0].lights = true;
        let mut heading = first;
        for leg in 0..legs {
            let middle = town.nodes[0].position;
            let end = middle + Vector::new(libm::cos(heading), libm::sin(heading)) * lengths[leg];
            town.nodes.push(node(&format!("end {leg}"), end.x, end.y));
            let nodes = if outward[leg] { [0, leg + 1] } else { [leg + 1, 0] };
            town.streets.push(street(&format!("leg {leg}"), &nodes));
            heading += TAU / 8.0 + free * shares[leg] / total;
        }
        let town = built(&town);
        prop_assert_eq!(check_links(&town, 1e-8), 2 * legs * (legs - 1 + 2));
        prop_assert_eq!(town.traffic_lights.len(), legs);
    }

    #[test]
    fn any_tangle_is_answered_without_a_panic(
        places in prop::collection::vec((-90..90i32, -90..90i32), 1..9),
        streets in prop::collection::vec(prop::collection::vec(0..9usize, 0..5), 0..5),
        lights in any::<u8>(),
    ) {
        let mut town = TownDesign::default();
        for (index, &(x, y)) in places.iter().enumerate() {
            let lights = lights >> index & 1 == 1;
            town.nodes.push(Node { lights, ..node(&format!("n{index}"), f64::from(x), f64::from(y)) });
        }
        town.streets = streets.iter().map(|nodes| street("s", nodes)).collect();
        // There is at least one node, which is a fault unless a street uses it.
        if streets.iter().all(Vec::is_empty) {
            prop_assert!(!town.build().unwrap_err().is_empty());
        } else if let Ok(parts) = town.build() {
            check_links(&parts, 1e-6);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_crooked_grid_is_built(
        shifts in prop::collection::vec((-10.0..10.0f64, -10.0..10.0f64), 9),
        chosen in prop::collection::vec(any::<bool>(), 12),
        depth in 4.0..40.0f64,
    ) {
        let across = (0..9).filter(|node| node % 3 < 2).map(|node| [node, node + 1]);
        let up = (0..6).map(|node| [node + 3, node]);
        let pairs: Vec<[usize; 2]> = across.chain(up).zip(&chosen).filter(|(_, chosen)| **chosen).map(|(pair, _)| pair).collect();
        let used: Vec<usize> = (0..9).filter(|node| pairs.iter().any(|pair| pair.contains(node))).collect();
        let row = BuildingRow { setback: 0.0, depth, length: 9.0, gap: 0.0 };
        let mut town = TownDesign { block_buildings: Some(row), ..TownDesign::default() };
        for &place in &used {
            let (column, row) = ((place % 3) as f64, (place / 3) as f64);
            town.nodes.push(node(&format!("n{place}"), 80.0 * column + shifts[place].0, 80.0 * row + shifts[place].1));
        }
        let number = |place: &usize| used.iter().position(|own| own == place).unwrap();
        town.streets = pairs.iter().map(|pair| street(&format!("{pair:?}"), &[number(&pair[0]), number(&pair[1])])).collect();
        let parts = built(&town);
        check_links(&parts, 1e-8);
        check_obstacles(&parts);
    }
}

/// A car at 30 km/h, 8.33 m/s, has v²/r = 5.8 m/s² on a radius of 12 m, and 6.9 in the lane 2 m nearer to the middle of the bend.
#[test]
fn bends_that_are_too_fast_are_found_by_the_limit_at_which_cars_come() {
    let with = |limits: [Option<f64>; 2], radius: f64| {
        let mut town = TownDesign { bend_radius: radius, ..bend() };
        town.streets.iter_mut().zip(limits).for_each(|(street, limit)| street.speed_limit = limit.map(|kmh| kmh / 3.6));
        let found = town.fast_bends([4.0, 7.0]);
        found
            .iter()
            .map(|bend| (bend.street, (bend.limit * 3.6).round(), (bend.lateral * 10.0).round() / 10.0))
            .collect::<Vec<_>>()
    };
    assert_eq!(with([None, None], 12.0), [(0, 30.0, 6.9), (1, 30.0, 6.9)]);
    assert_eq!(with([None, None], 20.0), []);
    assert_eq!(with([Some(20.0), Some(20.0)], 12.0), []);
    // A street without signs has the limit of the one before it.
    assert_eq!(with([Some(50.0), None], 20.0), [(0, 50.0, 10.7), (1, 50.0, 10.7)]);
    assert_eq!(with([Some(50.0), Some(30.0)], 20.0), [(0, 50.0, 10.7)]);
}

/// A right turn about a corner of 5 m has the middle of the street on 5 + 8.3 m, and the lane on 11.3 m: 6.1 m/s² at 30 km/h, 17 at 50.
#[test]
fn turns_of_a_junction_that_are_too_fast_are_found() {
    let with = |kmh: Option<f64>, corner_radius: f64| {
        let mut town = TownDesign { corner_radius, ..t_junction() };
        town.streets[1].speed_limit = kmh.map(|kmh| kmh / 3.6);
        let found = town.fast_bends([4.0, 7.0]);
        assert!(found.iter().all(|bend| bend.in_junction));
        found.iter().map(|bend| (bend.street, (bend.radius * 10.0).round() / 10.0)).collect::<Vec<_>>()
    };
    assert_eq!(with(None, 5.0), []);
    assert_eq!(with(Some(50.0), 5.0), [(0, 11.3), (1, 11.3)]);
    assert_eq!(with(Some(50.0), 40.0), []);
}

/// What is wrong at thousands of places is said of the first hundred, at once.
#[test]
fn thousands_of_equal_streets_are_refused_in_time() {
    let mut nodes = Vec::new();
    let mut streets = Vec::new();
    for pair in 0..1500_usize {
        let (x, y) = ((pair % 40) as f64 * 300.0 - 6000.0, (pair / 40) as f64 * 100.0 - 2000.0);
        nodes.extend([node(&format!("a{pair}"), x, y), node(&format!("b{pair}"), x + 200.0, y)]);
        streets.extend(["c", "d"].map(|one| street(&format!("{one}{pair}"), &[2 * pair, 2 * pair + 1])));
    }
    let town = TownDesign { nodes, streets, ..TownDesign::default() };
    let faults = town.build().unwrap_err();
    assert_eq!(faults.len(), 100);
}
