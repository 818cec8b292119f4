//! Failures for other programs: the files are read back, by our own readers and by independent ones.

use falsify::session::{Input, Session};
use proptest::prelude::*;
use road::design::{BuildingRow, Carriageway, Node, Street, TownDesign};
use road::geometry::{OrientedBox, Point, Pose};
use road::{Road, SpeedSign, Town, TownParts, TrafficLight, opendrive};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::program::{error, falsify, said};
use crate::shipped::shipped;

/// Places along a road at which two towns are compared.
const PLACES: u32 = 9;
/// The most by which a town may differ from the one that was written (m, rad).
const NEAR: f64 = 1e-6;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= NEAR
}

fn near_pose(a: &Pose, b: &Pose) -> bool {
    let turn = (a.yaw - b.yaw).abs();
    near(a.x, b.x) && near(a.y, b.y) && (turn <= NEAR || (std::f64::consts::TAU - turn).abs() <= NEAR)
}

fn near_box(a: &OrientedBox, b: &OrientedBox) -> bool {
    near_pose(&a.pose, &b.pose) && near(a.half.x, b.half.x) && near(a.half.y, b.half.y)
}

fn check_road(a: &Road, b: &Road) {
    let name = &a.name;
    let links =
        |road: &Road| (road.id, road.name.clone(), road.junction, road.left_hand, road.predecessor, road.successor);
    assert_eq!(links(a), links(b));
    assert!(near(a.length, b.length), "{name}: {} m, {} m", a.length, b.length);
    assert_eq!(a.sections.len(), b.sections.len(), "{name}");
    for (number, (one, other)) in a.sections.iter().zip(&b.sections).enumerate() {
        assert!(near(one.start, other.start) && near(one.end, other.end), "{name}");
        let lanes = |road: &Road| {
            let lanes = road.sections[number].lanes.iter();
            lanes.map(|lane| (lane.id, lane.kind, lane.predecessor, lane.successor)).collect::<Vec<_>>()
        };
        assert_eq!(lanes(a), lanes(b), "{name}");
        for (lane, same) in one.lanes.iter().zip(&other.lanes) {
            for place in 0..=PLACES {
                let s = one.start + (one.end - one.start) * f64::from(place) / f64::from(PLACES);
                assert!(near(lane.width.value(s), same.width.value(s)), "{name}, lane {}", lane.id);
                if lane.id != 0 {
                    let (first, second) = (a.lane_pose(number, lane.id, s), b.lane_pose(number, lane.id, s));
                    let (first, second) = (first.unwrap(), second.unwrap());
                    assert!(near_pose(&first, &second), "{name}, lane {}, s {s}: {first:?}, {second:?}", lane.id);
                }
            }
        }
    }
}

/// Checks that two lists are the same up to their order.
fn check_same<T: std::fmt::Debug>(what: &str, a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) {
    assert_eq!(a.len(), b.len(), "{what}");
    let mut left: Vec<&T> = b.iter().collect();
    for one in a {
        let found = left.iter().position(|other| same(one, other));
        left.remove(found.unwrap_or_else(|| panic!("{what}: {one:?} is lost among {left:?}")));
    }
}

/// Checks that a designed town is the same after it was written and read.
fn check_round_trip(town: &Town) {
    let text = export::town(town).unwrap();
    let read = Town::new(opendrive::read(&text, &town.name).unwrap());
    assert_eq!(read.warnings, [], "{}", town.name);
    assert_eq!(town.roads.len(), read.roads.len());
    town.roads.iter().zip(&read.roads).for_each(|(a, b)| check_road(a, b));
    // Numbers of junctions are free, since roads and lights name junctions by their places.
    for (a, b) in town.junctions.iter().zip(&read.junctions) {
        assert_eq!((&a.name, &a.connections), (&b.name, &b.connections));
    }
    assert_eq!(town.junctions.len(), read.junctions.len());
    let same_sign = |a: &SpeedSign, b: &SpeedSign| near(a.limit, b.limit) && near_box(&a.trigger, &b.trigger);
    check_same("signs", &town.speed_signs, &read.speed_signs, same_sign);
    let turns = |light: &TrafficLight| (light.group, light.turn, light.turns, light.road);
    let same_light = |a: &TrafficLight, b: &TrafficLight| {
        turns(a) == turns(b) && near_pose(&a.stop, &b.stop) && near_box(&a.trigger, &b.trigger)
    };
    check_same("lights", &town.traffic_lights, &read.traffic_lights, same_light);
    check_same("stops", &town.bus_stops, &read.bus_stops, |a, b| near(a.x, b.x) && near(a.y, b.y));
    check_same("obstacles", &town.obstacles, &read.obstacles, near_box);
    let same_stretch = |a: &Town, b: &Town| {
        let stretches = a.driving_lanes().iter().zip(b.driving_lanes());
        a.driving_lanes().len() == b.driving_lanes().len()
            && stretches.into_iter().all(|(one, other)| near_pose(&a.pose(one.start), &b.pose(other.start)))
    };
    assert!(same_stretch(town, &read), "{}", town.name);
}

fn towns_of(files: &[PathBuf]) -> Vec<Arc<Town>> {
    let mut towns: Vec<Arc<Town>> = Vec::new();
    for file in files {
        let input = Input { files: vec![file.clone()], ..Input::default() };
        let checked = Session::default().check(&input).unwrap();
        let Ok(plan) = checked.plan() else { continue };
        let used = plan.campaigns.iter().flat_map(|campaign| &campaign.towns);
        towns.extend(plan.towns.iter().chain(used).map(|named| named.town.clone()));
    }
    let mut known = BTreeSet::new();
    towns.retain(|town| town.map.is_none() && known.insert(town.name.clone()));
    towns
}

#[test]
fn all_shipped_towns_are_the_same_after_they_were_exported_and_read() {
    let towns = towns_of(&[shipped("scenarios"), shipped("tests/suite")].concat());
    assert!(towns.len() >= 4, "{} towns", towns.len());
    let of = |list: fn(&Town) -> usize| towns.iter().map(|town| list(town)).sum::<usize>();
    assert!(of(|town| town.obstacles.len()) > 100 && of(|town| town.speed_signs.len()) > 10);
    assert!(of(|town| town.traffic_lights.len()) > 10 && of(|town| town.junctions.len()) > 10);
    towns.iter().for_each(|town| check_round_trip(town));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_crooked_grid_is_the_same_after_it_was_exported_and_read(
        shifts in prop::collection::vec((-10.0..10.0f64, -10.0..10.0f64), 9),
        chosen in prop::collection::vec(any::<bool>(), 12),
        lights in any::<bool>(),
        limit in prop::option::of(5.0..36.0f64),
        house in (-200.0..400.0f64, -200.0..-60.0f64, -3.0..3.0f64),
        lanes in prop::collection::vec((1..=3u32, any::<bool>()), 12),
        narrow in any::<bool>(),
    ) {
        let across = (0..9).filter(|node| node % 3 < 2).map(|node| [node, node + 1]);
        let up = (0..6).map(|node| [node + 3, node]);
        let pairs = across.chain(up).zip(&chosen).filter(|(_, chosen)| **chosen);
        let pairs: Vec<[usize; 2]> = pairs.map(|(pair, _)| pair).collect();
        prop_assume!(!pairs.is_empty());
        let used: Vec<usize> = (0..9).filter(|node| pairs.iter().any(|pair| pair.contains(node))).collect();
        let legs = |node: usize| pairs.iter().filter(|pair| pair.contains(&node)).count();
        let row = BuildingRow { setback: 0.0, depth: 9.0, length: 9.0, gap: 0.0 };
        let mut town = TownDesign { name: "grid".to_owned(), block_buildings: Some(row), ..TownDesign::default() };
        town.nodes.extend(used.iter().map(|&place| {
            let (column, row) = ((place % 3) as f64, (place / 3) as f64);
            let position = Point::new(80.0 * column + shifts[place].0, 80.0 * row + shifts[place].1);
            Node { name: format!("n{place}"), position, lights: lights && legs(place) > 2 }
        }));
        let number = |place: &usize| used.iter().position(|own| own == place).unwrap();
        town.streets.extend(pairs.iter().zip(&lanes).map(|(pair, &(lanes, one_way))| Street {
            name: format!("{pair:?} <&>"),
            nodes: pair.iter().map(number).collect(),
            speed_limit: limit,
            carriageway: match narrow {
                true => Carriageway::default(),
                false => Carriageway { forward: lanes, backward: if one_way { 0 } else { lanes } },
            },
        }));
        // Streets of different lanes cannot bend into each other.
        prop_assume!(town.build().is_ok());
        // Beyond the end of every road.
        town.buildings.push(OrientedBox::new(Pose::new(house.0, house.1, house.2), 8.0, 3.0));
        check_round_trip(&Town::new(town.build().unwrap()));
    }
}

/// A straight road, as another program might write it.
const MAP: &str = r#"<?xml version="1.0"?><!-- by hand -->
<OpenDRIVE><header revMajor="1" revMinor="4"/>
<road id="7" length="100" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right><lane id="-1" type="driving">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes><signals/></road></OpenDRIVE>
"#;

#[test]
fn a_map_is_handed_through_with_what_the_scenario_adds() {
    let parts = opendrive::read(MAP, "map").unwrap();
    assert_eq!(export::town(&Town::new(parts.clone())).unwrap(), MAP);
    let house = OrientedBox::new(Pose::new(130.0, 20.0, 0.4), 5.0, 4.0);
    let sign = SpeedSign { limit: 10.0, trigger: OrientedBox::new(Pose::new(30.0, -1.75, 0.0), 1.4, 1.4) };
    let stop = Point::new(40.0, -6.0);
    let parts = TownParts { obstacles: vec![house], speed_signs: vec![sign.clone()], bus_stops: vec![stop], ..parts };
    let town = Town::new(parts);
    let text = export::town(&town).unwrap();
    let (head, tail) = MAP.split_once("<signals/>").unwrap();
    assert!(text.starts_with(head) && text.ends_with(tail), "{text}");
    let read = opendrive::read(&text, "map").unwrap();
    assert_eq!((read.obstacles.len(), read.speed_signs.len(), read.bus_stops.as_slice()), (1, 1, [stop].as_slice()));
    assert!(near_box(&read.obstacles[0], &house), "{:?}", read.obstacles);
    assert!(near_box(&read.speed_signs[0].trigger, &sign.trigger) && near(read.speed_signs[0].limit, 10.0));
    // What was added once is not added again.
    assert_eq!(export::town(&Town::new(read)).unwrap(), text);
}

#[test]
fn a_map_whose_roads_have_texts_as_ids_takes_additions() {
    let parts = opendrive::read(&MAP.replace("id=\"7\"", "id=\"seven\""), "map").unwrap();
    let house = OrientedBox::new(Pose::new(130.0, 20.0, 0.4), 5.0, 4.0);
    let text = export::town(&Town::new(TownParts { obstacles: vec![house], ..parts })).unwrap();
    assert!(near_box(&opendrive::read(&text, "map").unwrap().obstacles[0], &house), "{text}");
}

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
episode dark { tick: 0.05 s  hold: 20  ticks: 600  traffic_lights: false }
campaign out {
  vehicle: model3  body: suicidal  spawn: ahead  episode: dark
  evaluate { towns: [harbour, village] drivers: [blind, idm] pedestrians: [intercept] episodes: 4 }
}
"#;

/// Runs a campaign in a folder; gives the names of its collisions and of one episode without a collision, if there is one.
pub fn failures(folder: &Path) -> Vec<String> {
    failures_of(folder, SCENARIO)
}

fn failures_of(folder: &Path, scenario: &str) -> Vec<String> {
    std::fs::write(folder.join("out.scn"), scenario).unwrap();
    let run = falsify(&["run", "out.scn"], folder);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let text = std::fs::read_to_string(folder.join("reports/out/episodes.csv")).unwrap();
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let place = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let (run, episode, outcome) = (place("run_id"), place("episode"), place("outcome"));
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    rows.filter(|row| row[outcome] == "collision").map(|row| format!("{}:{}", row[run], row[episode])).collect()
}

/// A street to the east that rises by 12 cm a metre.
const SLOPE: &str = r#"<OpenDRIVE><road id="1" length="300" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="300"><line/></geometry></planView><elevationProfile><elevation s="0" a="0" b="0.12" c="0" d="0"/></elevationProfile><lanes><laneSection s="0"><left><lane id="1" type="driving"><width a="3.5"/></lane></left><right><lane id="-1" type="driving"><width a="3.5"/></lane></right></laneSection></lanes></road></OpenDRIVE>"#;
/// Episodes on it.
const ON_SLOPE: &str = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
town t = opendrive(file: "slope.xodr")
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m  ego_lane { from: (150 m, -1.75 m, 0 deg)  length: 60 m } }
episode brief { ticks: 100  hold: 10 }
campaign out {
  vehicle: model3  body: plausible  spawn: near  episode: brief
  evaluate { towns: [t]  drivers: [blind]  pedestrians: [intercept]  episodes: 20 }
}
"#;

#[test]
fn the_rear_axle_lies_on_a_slope_and_the_car_is_inclined_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("slope.xodr"), SLOPE).unwrap();
    let name = failures_of(here, ON_SLOPE).remove(0);
    let exported = falsify(&["export", &name, "--as", "xosc-1.3"], here);
    assert_eq!(exported.status.code(), Some(0), "{exported:?}");
    let text = std::fs::read_to_string(here.join(format!("{}.xosc", name.replace(':', "-")))).unwrap();
    let read = roxmltree::Document::parse(&text).unwrap();
    let all = read.descendants().filter(|node| node.has_tag_name("Polyline"));
    for (line, inclined) in all.zip([true, false]) {
        for place in line.descendants().filter(|node| node.has_tag_name("WorldPosition")) {
            let [x, z, h, p] = ["x", "z", "h", "p"].map(|name| place.attribute(name).unwrap().parse::<f64>().unwrap());
            assert!((z - 0.12 * x).abs() < 1e-6, "{place:?}");
            // Positive pitch lowers the nose: the axes turn from z to x.
            let pitch = if inclined { -libm::atan(0.12 * libm::cos(h)) } else { 0.0 };
            assert!((p - pitch).abs() < 1e-6, "{place:?}");
        }
    }
}

#[test]
fn failures_are_exported_one_by_one_and_as_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let names = failures(here);
    assert!(names.len() >= 6, "{names:?}");

    let one = falsify(&["export", &names[0], "--as", "xosc-1.3"], here);
    assert_eq!(one.status.code(), Some(0), "{one:?}");
    let stem = names[0].replace(':', "-");
    let old = falsify(&["export", &names[0], "--as", "xosc-1.0"], here);
    assert!(old.status.success() && here.join(format!("{stem}-1.0.xosc")).is_file(), "{old:?}");
    let text = std::fs::read_to_string(here.join(format!("{stem}.xosc"))).unwrap();
    let read = roxmltree::Document::parse(&text).unwrap();
    let map = read.descendants().find_map(|node| node.attribute("filepath")).unwrap();
    let town = opendrive::read(&std::fs::read_to_string(here.join(map)).unwrap(), "map").unwrap();
    assert!(!town.obstacles.is_empty());

    // The vertices are the ticks of the episode, at the rear axle.
    let replay = falsify(&["replay", &names[0], "--json", "--ticks", "ticks.csv"], here);
    assert_eq!(replay.status.code(), Some(0), "{replay:?}");
    let ticks = std::fs::read_to_string(here.join("ticks.csv")).unwrap();
    let head: Vec<&str> = ticks.lines().next().unwrap().split(',').collect();
    let places = ["ego_x_m", "ego_y_m", "ego_yaw_deg"].map(|name| head.iter().position(|own| *own == name).unwrap());
    let polyline = read.descendants().find(|node| node.has_tag_name("Polyline")).unwrap();
    let vertices: Vec<_> = polyline.descendants().filter(|node| node.has_tag_name("WorldPosition")).collect();
    assert_eq!(vertices.len(), ticks.lines().count() - 1);
    let half_base = 3.0046 / 2.0;
    for (line, vertex) in ticks.lines().skip(1).zip(vertices) {
        let values: Vec<&str> = line.split(',').collect();
        let [x, y, yaw] = places.map(|place| values[place].parse::<f64>().unwrap());
        let number = |name: &str| vertex.attribute(name).unwrap().parse::<f64>().unwrap();
        let (sin, cos) = libm::sincos(yaw.to_radians());
        assert!((number("x") - (x - half_base * cos)).abs() < 1e-4, "{line}");
        assert!((number("y") - (y - half_base * sin)).abs() < 1e-4, "{line}");
    }

    let list = names.iter().map(|name| format!("reports/out/{name}\n")).collect::<String>();
    std::fs::write(here.join("names.txt"), list).unwrap();
    let piped = crate::program::command()
        .args(["export", "-", "--as", "xosc-1.3", "--out", "all", "--ego", "user", "--pedestrians", "released"])
        .current_dir(here)
        .stdin(std::fs::File::open(here.join("names.txt")).unwrap())
        .output()
        .unwrap();
    assert_eq!(piped.status.code(), Some(0), "{piped:?}");
    assert_eq!(said(&piped).lines().count(), names.len());
    let written = std::fs::read_dir(here.join("all")).unwrap().count();
    // Two towns have two maps.
    assert_eq!(written, names.len() + 2);
    let released = std::fs::read_to_string(here.join(format!("all/{stem}.xosc"))).unwrap();
    let read = roxmltree::Document::parse(&released).unwrap();
    let named = |name: &str| read.descendants().filter(|node| node.has_tag_name(name)).count();
    assert_eq!((named("FollowTrajectoryAction"), named("RelativeDistanceCondition")), (1, 1));
    assert!(released.contains("domainAbsoluteRelative=\"relative\""));
}

/// The failures of towns whose lights work, exported with these options, by name.
fn exported_with_lights(here: &Path, options: &[&str]) -> Vec<(String, String)> {
    let names = failures_of(here, &SCENARIO.replace("traffic_lights: false", "traffic_lights: true"));
    assert!(names.len() >= 4, "{names:?}");
    let command = ["export"].into_iter().chain(names.iter().map(String::as_str)).chain(options.iter().copied());
    let done = falsify(&command.collect::<Vec<_>>(), here);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let read = |line: &str| {
        let (name, files) = line.split_once(' ').unwrap();
        (name.to_owned(), std::fs::read_to_string(here.join(files.split_whitespace().next().unwrap())).unwrap())
    };
    said(&done).lines().map(read).collect()
}

#[test]
fn an_ego_of_the_user_gets_the_phases_of_the_lights() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut lit = 0;
    for (name, text) in exported_with_lights(here, &["--as", "xosc-1.3", "--ego", "user"]) {
        let read = roxmltree::Document::parse(&text).unwrap();
        let map = read.descendants().find_map(|node| node.attribute("filepath")).unwrap();
        let map = std::fs::read_to_string(here.join(map)).unwrap();
        let map = roxmltree::Document::parse(&map).unwrap();
        let ids = |tag: &str| {
            let nodes = map.descendants().filter(|node| node.has_tag_name(tag));
            nodes.filter_map(|node| node.attribute("id")).map(str::to_owned).collect::<BTreeSet<_>>()
        };
        let (controllers, signals) = (ids("controller"), ids("signal"));
        // The names of the colours, tick by tick, of the controllers of each junction.
        let mut junctions: std::collections::BTreeMap<&str, Vec<Vec<&str>>> = std::collections::BTreeMap::new();
        for controller in read.descendants().filter(|node| node.has_tag_name("TrafficSignalController")) {
            let id = controller.attribute("name").unwrap();
            assert!(controllers.contains(id), "{name}: {id}");
            let mut colours = Vec::new();
            let mut names = std::collections::BTreeSet::new();
            for phase in controller.children().filter(|node| node.has_tag_name("Phase")) {
                let duration = phase.attribute("duration").unwrap().parse::<f64>().unwrap();
                let ticks = (duration / 0.05).round() as usize;
                let own_name = phase.attribute("name").unwrap();
                assert!(names.insert(own_name), "{name}: two phases are called {own_name}");
                let colour = own_name.split_once(' ').unwrap().0;
                colours.extend(std::iter::repeat_n(colour, ticks));
                for state in phase.children().filter(|node| node.has_tag_name("TrafficSignalState")) {
                    assert!(signals.contains(state.attribute("trafficSignalId").unwrap()), "{name}");
                    let lamps = match colour {
                        "stop" => "on;off;off",
                        "attention" => "off;on;off",
                        _ => "off;off;on",
                    };
                    assert_eq!(state.attribute("state"), Some(lamps));
                }
            }
            junctions.entry(id.rsplit_once('_').unwrap().0).or_default().push(colours);
            lit += 1;
        }
        for turns in junctions.values() {
            let period = 300 * turns.len();
            for colours in turns {
                let count = |colour: &str| colours.iter().filter(|own| **own == colour).count();
                assert_eq!((colours.len(), count("go"), count("attention")), (period, 200, 60), "{name}");
            }
            let open = |tick: usize| turns.iter().filter(|colours| colours[tick] != "stop").count();
            assert!((0..period).all(|tick| open(tick) <= 1), "{name}: two turns are open at once");
        }
    }
    assert!(lit > 4, "{lit} controllers");
    let name = failures_of(here, &SCENARIO.replace("traffic_lights: false", "traffic_lights: true"));
    let refused: Vec<_> = name
        .iter()
        .map(|name| falsify(&["export", name, "--as", "xosc-1.0", "--ego", "user", "--out", "old"], here))
        .collect();
    let refused = refused.iter().find(|done| !done.status.success()).unwrap();
    assert!(
        error(refused).contains("phases of the traffic lights") && error(refused).contains("xosc-1.3"),
        "{refused:?}"
    );
}

#[test]
fn a_planning_problem_has_a_name_of_its_own_and_no_recorded_car() {
    let folder = tempfile::tempdir().unwrap();
    let mut names = BTreeSet::new();
    let mut lights = 0;
    let exported = exported_with_lights(folder.path(), &["--as", "commonroad"]);
    for (name, text) in &exported {
        let read = roxmltree::Document::parse(text).unwrap();
        let named = |tag: &str| read.descendants().filter(move |node| node.has_tag_name(tag)).collect::<Vec<_>>();
        names.insert(read.root_element().attribute("benchmarkID").unwrap().to_owned());
        assert_eq!((named("planningProblem").len(), named("dynamicObstacle").len()), (1, 1), "{name}");
        assert!(!text.contains("<type>car</type>"), "{name}");
        let references: Vec<_> = named("trafficLightRef").iter().map(|node| node.attribute("ref")).collect();
        for light in named("trafficLight") {
            assert!(references.contains(&light.attribute("id")), "{name}");
            let durations = light.descendants().filter(|node| node.has_tag_name("duration"));
            let ticks: usize = durations.map(|node| node.text().unwrap().parse::<usize>().unwrap()).sum();
            assert_eq!(ticks % 300, 0, "{name}");
            lights += 1;
        }
    }
    assert_eq!(names.len(), exported.len(), "{names:?}");
    assert!(lights > 4, "{lights} lights");
    let (name, _) = &exported[0];
    let (run, number) = name.split_once(':').unwrap();
    assert!(names.contains(&format!("ZAM_Falsify{run}-1_{}_T-1", number.parse::<u32>().unwrap() + 1)), "{names:?}");
    let (_, text) = &exported[0];
    let read = roxmltree::Document::parse(text).unwrap();
    let bounds = read.descendants().filter(|node| node.has_tag_name("leftBound") || node.has_tag_name("rightBound"));
    for bound in bounds {
        let number = |point: roxmltree::Node<'_, '_>, tag: &str| {
            let text = point.children().find(|node| node.has_tag_name(tag)).unwrap().text().unwrap();
            text.parse::<f64>().unwrap()
        };
        let points: Vec<[f64; 2]> = bound
            .children()
            .filter(|node| node.is_element())
            .map(|point| ["x", "y"].map(|tag| number(point, tag)))
            .collect();
        for three in points.windows(3) {
            let [a, b, c] = [three[0], three[1], three[2]];
            let area = ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs();
            assert!(area > 1e-9, "CommonRoad's checker crashes at points on a line: {three:?}");
        }
    }
    // A recording has the car and no problem.
    let (_, recording) =
        &exported_with_lights(folder.path(), &["--as", "commonroad", "--ego", "recorded", "--out", "recorded"])[0];
    assert!(recording.contains("<type>car</type>") && !recording.contains("planningProblem"));
    let released = falsify(&["export", name, "--as", "commonroad", "--pedestrians", "released"], folder.path());
    assert!(error(&released).contains("pedestrians that are released"), "{released:?}");
}

#[test]
fn what_cannot_be_exported_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let names = failures(here);
    let variant = falsify(&["export", &names[0], "--as", "xodr", "--ego", "user"], here);
    assert_eq!(variant.status.code(), Some(2), "{variant:?}");
    assert!(error(&variant).contains("xodr cannot represent an ego that the user drives"), "{}", error(&variant));
    let unknown = falsify(&["export", &names[0], "--as", "mov"], here);
    assert_eq!(unknown.status.code(), Some(2), "{unknown:?}");
    assert!(error(&unknown).contains("xosc-1.3"), "{}", error(&unknown));
    let nothing = falsify(&["export", "--as", "xodr"], here);
    assert_eq!(nothing.status.code(), Some(2), "{nothing:?}");
    let bad = falsify(&["export", "12:x", "--as", "xodr"], here);
    assert_eq!(bad.status.code(), Some(2), "{bad:?}");
    assert!(error(&bad).contains("'12:x'") && error(&bad).contains("write RUN:EPISODE"), "{}", error(&bad));

    // A report holds its scenario, so it does not matter that the file was changed.
    std::fs::write(here.join("out.scn"), SCENARIO.replace("dark", "night")).unwrap();
    let changed = falsify(&["export", &names[0], "--as", "xodr"], here);
    assert_eq!(changed.status.code(), Some(0), "{changed:?}");
}

#[test]
fn a_film_shows_each_tick_for_as_long_as_it_took() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let name = failures(here).swap_remove(0);
    let stem = name.replace(':', "-");
    let made = falsify(&["export", &name, "--as", "gif"], here);
    assert_eq!(made.status.code(), Some(0), "{made:?}");
    let file = std::fs::File::open(here.join(format!("{stem}.gif"))).unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut film = options.read_info(file).unwrap();
    let (width, height) = (usize::from(film.width()), usize::from(film.height()));
    let (mut delays, mut picture, mut pictures) = (Vec::new(), vec![0_u8; width * height * 4], Vec::new());
    while let Some(frame) = film.read_next_frame().unwrap() {
        let [left, top, wide, high] = [frame.left, frame.top, frame.width, frame.height].map(usize::from);
        assert_eq!(frame.buffer.len(), wide * high * 4);
        for (place, pixel) in frame.buffer.chunks(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let to = ((top + place / wide) * width + left + place % wide) * 4;
            picture[to..to + 4].copy_from_slice(pixel);
        }
        delays.push(frame.delay);
        pictures.push(picture.clone());
    }

    let replay = falsify(&["replay", &name, "--ticks", "ticks.csv"], here);
    assert_eq!(replay.status.code(), Some(0), "{replay:?}");
    let frames = std::fs::read_to_string(here.join("ticks.csv")).unwrap().lines().count() - 1;
    // At most the last 12 s.
    assert_eq!(delays.len(), frames.min(241));
    let (last, others) = delays.split_last().unwrap();
    assert!(others.iter().all(|delay| *delay == 5), "{delays:?}");
    assert_eq!(*last, 150);
    // The pedestrian is red, the car is blue; the picture moves.
    let near = |pixel: &[u8], wanted: [u8; 3]| pixel.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 8);
    let has = |picture: &[u8], wanted| picture[52 * width * 4..].chunks(4).filter(|pixel| near(pixel, wanted)).count();
    for picture in &pictures {
        assert!(has(picture, [214, 48, 48]) > 20);
    }
    assert!(has(&pictures[pictures.len() - 1], [34, 86, 196]) > 200);
    assert_ne!(pictures[0], pictures[pictures.len() - 1]);
}
