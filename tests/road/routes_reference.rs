//! Routes compared with those of CARLA's own planner.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use crate::reference;
use needs::needs;
use road::geometry::{Point, Vector};
use road::{RoadOption, RoutePlanner, RoutePoint, Town, opendrive};

/// The spacing of the recorded routes (m).
const SAMPLING: f64 = 2.0;
/// Agreement of points (m).
const TOLERANCE: f64 = 1e-3;
/// Where lanes divide at a junction, their centres start at the same position to the last bit. The inner order of CARLA's R-tree
/// decides which lane is the nearest. A goal that is moved by this distance (m) is on one lane without doubt.
const NUDGE: f64 = 0.02;
/// At most one route in this number may depend on that order, or on a previous route that the table does not have.
const ROUTES_PER_EXCEPTION: usize = 10;

/// A route as recorded, in CARLA's left-handed axes.
#[derive(Default)]
struct Recorded {
    origin: [f64; 2],
    goal: [f64; 2],
    /// Position, road, lane and option of each point.
    points: Vec<([f64; 2], u32, i32, String)>,
}

fn read_routes(text: &str) -> BTreeMap<u32, Recorded> {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().expect("a table has a header");
    let column = |name: &str| header.iter().position(|other| *other == name).unwrap_or_else(|| panic!("no {name}"));
    let columns = ["route", "origin_x", "origin_y", "goal_x", "goal_y", "x", "y", "road_id", "lane_id", "option"];
    let columns = columns.map(column);
    let mut routes: BTreeMap<u32, Recorded> = BTreeMap::new();
    for row in lines {
        let [route, origin_x, origin_y, goal_x, goal_y, x, y, road, lane, option] = columns.map(|index| row[index]);
        let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("{text} in {row:?}"));
        let route = routes.entry(number(route) as u32).or_default();
        route.origin = [number(origin_x), number(origin_y)];
        route.goal = [number(goal_x), number(goal_y)];
        let place = [number(x), number(y)];
        route.points.push((place, number(road) as u32, number(lane) as i32, option.to_owned()));
    }
    routes
}

fn place([x, y]: [f64; 2]) -> Point {
    Point::new(x, -y)
}

fn name(option: RoadOption) -> &'static str {
    match option {
        RoadOption::LaneFollow => "LANEFOLLOW",
        RoadOption::Left => "LEFT",
        RoadOption::Right => "RIGHT",
        RoadOption::Straight => "STRAIGHT",
    }
}

/// The difference of a route from the recorded one; empty if there is none.
fn difference(town: &Town, recorded: &Recorded, ours: &[RoutePoint]) -> String {
    for (index, (theirs, ours)) in recorded.points.iter().zip(ours).enumerate() {
        let (at, road, lane, option) = theirs;
        let off = (place(*at) - ours.pose.position()).norm();
        let id = town.roads[ours.waypoint.road.0 as usize].id;
        if off > TOLERANCE || off.is_nan() || option != name(ours.option) || (id, ours.waypoint.lane) != (*road, *lane)
        {
            return format!(
                "point {index} of {}: {at:?} on road {road}, lane {lane}, {option}; ours is {off:.4} m off on road {id}, lane {}, s {:.3}, {}",
                recorded.points.len(),
                ours.waypoint.lane,
                ours.waypoint.s,
                name(ours.option)
            );
        }
    }
    if recorded.points.len() == ours.len() {
        String::new()
    } else {
        format!("{} points, ours has {}", recorded.points.len(), ours.len())
    }
}

/// What CARLA's planner does to a route when the previous route ended in another junction: it still assumes to be in that
/// junction.
fn forget_first_junction(route: &mut [RoutePoint]) {
    let named = route.iter_mut().skip_while(|point| point.option == RoadOption::LaneFollow);
    for point in named.take_while(|point| point.option != RoadOption::LaneFollow) {
        point.option = RoadOption::LaneFollow;
    }
}

#[needs(reference = "reference/behavior_agent_traces/ _routes.csv")]
#[test]
fn routes_agree_with_the_reference() {
    let folder = reference::folder().join("reference").join("behavior_agent_traces");
    let mut files: Vec<PathBuf> = fs::read_dir(&folder).unwrap().flatten().map(|entry| entry.path()).collect();
    files.sort();
    let (mut agreeing, mut all) = (0, 0);
    for file in files {
        let Some(file_name) = file.file_name().and_then(|name| name.to_str()) else { continue };
        if file_name.ends_with("_routes.csv.gz") {
            loud!("SKIPPED: {file_name} is compressed; unpack it to compare");
        }
        let Some(town_name) = file_name.strip_suffix("_routes.csv") else { continue };
        let Ok(map) = fs::read_to_string(reference::folder().join("maps").join(format!("{town_name}.xodr"))) else {
            loud!("SKIPPED: {file_name}, for want of its map");
            continue;
        };
        let town = Town::new(opendrive::read(&map, town_name).expect("the map of recorded routes is readable"));
        let planner = RoutePlanner::new(&town, SAMPLING);
        let routes = read_routes(&fs::read_to_string(&file).unwrap());
        let (mut wrong, mut exceptions) = (0, 0);
        for (number, recorded) in &routes {
            let (origin, goal) = (place(recorded.origin), place(recorded.goal));
            let compare =
                |origin, goal| difference(&town, recorded, &planner.trace(&town, origin, goal).unwrap_or_default());
            let difference = compare(origin, goal);
            let nudges = [(0.0, NUDGE), (0.0, -NUDGE), (NUDGE, 0.0), (-NUDGE, 0.0)].map(|(x, y)| Vector::new(x, y));
            let mut nudged = nudges.iter().flat_map(|nudge| [(origin + nudge, goal), (origin, goal + nudge)]);
            if difference.is_empty() {
                continue;
            }
            let mut unnamed = planner.trace(&town, origin, goal).unwrap_or_default();
            forget_first_junction(&mut unnamed);
            if nudged.any(|(origin, goal)| compare(origin, goal).is_empty()) {
                exceptions += 1;
                eprintln!("  {town_name}, route {number}: lanes equally near decide; {difference}");
            } else if self::difference(&town, recorded, &unnamed).is_empty() {
                exceptions += 1;
                eprintln!("  {town_name}, route {number}: the route before it decides; {difference}");
            } else {
                wrong += 1;
                eprintln!("  {town_name}, route {number}: {difference}");
            }
        }
        let points: usize = routes.values().map(|route| route.points.len()).sum();
        let agree = routes.len() - wrong - exceptions;
        eprintln!(
            "{town_name}: {agree} of {} routes agree, {points} points; {exceptions} more are explained above",
            routes.len()
        );
        let allowed = routes.len().div_ceil(ROUTES_PER_EXCEPTION);
        assert!(exceptions <= allowed, "{exceptions} exceptions are too many");
        agreeing += routes.len() - wrong;
        all += routes.len();
    }
    assert!(all > 0, "no routes are readable in {}", folder.display());
    assert_eq!(agreeing, all, "routes that agree with CARLA's");
}

/// The first branch of a fork decides the way of CARLA's driver without a destination.
#[needs(reference = "maps/oracle/ _topology.csv")]
#[test]
fn topology_and_branches_are_in_the_order_of_the_reference() {
    let folder = reference::folder().join("maps");
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder.join("oracle")).unwrap().flatten().map(|entry| entry.path()).collect();
    files.sort();
    for file in files {
        let Some(town_name) = file.file_name().and_then(|name| name.to_str()?.strip_suffix("_topology.csv")) else {
            continue;
        };
        let Ok(map) = fs::read_to_string(folder.join(format!("{town_name}.xodr"))) else {
            loud!("SKIPPED: the topology of {town_name}, for want of its map");
            continue;
        };
        let town = Town::new(opendrive::read(&map, town_name).expect("the map of a topology is readable"));
        let text = fs::read_to_string(&file).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = lines.next().expect("a table has a header");
        let columns =
            ["entry_road_id", "entry_section_id", "entry_lane_id", "exit_road_id", "exit_section_id", "exit_lane_id"]
                .map(|name| header.iter().position(|other| *other == name).unwrap_or_else(|| panic!("no {name}")));
        let theirs: Vec<[i64; 6]> =
            lines.map(|row| columns.map(|column| row[column].parse().expect("numbers are whole"))).collect();
        let ours = town.topology().into_iter().map(|ends| {
            let [(a, b, c), (d, e, f)] = [ends.0, ends.1].map(|end| {
                (i64::from(town.roads[end.road.0 as usize].id), i64::from(end.section), i64::from(end.lane))
            });
            [a, b, c, d, e, f]
        });
        // CARLA loses some dead ends, which we keep.
        let dead_end = |pair: &[i64; 6]| pair[..3] == pair[3..];
        let ours: Vec<[i64; 6]> = ours.filter(|pair| !dead_end(pair) || theirs.contains(pair)).collect();
        eprintln!("{town_name}: {} pairs in order", theirs.len());
        assert!(ours == theirs, "{town_name}: first difference {:?}", theirs.iter().zip(&ours).find(|(a, b)| a != b));
    }
}
