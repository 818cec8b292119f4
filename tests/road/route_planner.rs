//! Routes to a destination.

use std::sync::Arc;

use road::geometry::Point;
use road::{LaneFilter, RoadOption, RoutePlanner, RoutePoint, Town};

/// Two blocks with a street between them, which continues to a dead end in the north.
fn town() -> Town {
    let nodes = [(0.0, 0.0), (100.0, 0.0), (200.0, 0.0), (200.0, 80.0), (100.0, 80.0), (0.0, 80.0), (100.0, 150.0)];
    crate::streets::town(&nodes, &[&[0, 1, 2, 3, 4, 5, 0], &[1, 4, 6]])
}

fn heading(town: &Town, near: Point, towards: Point) -> Point {
    let lane = town.nearest_lane(near, LaneFilter::Driving).unwrap();
    let sides = [Some(lane), town.left_lane(lane)].into_iter().flatten().map(|lane| town.pose(lane));
    let mut along = sides.filter(|pose| pose.forward().dot(&(towards - pose.position())) > 0.0);
    along.next().unwrap().position()
}

fn turns(route: &[RoutePoint]) -> Vec<RoadOption> {
    let mut options: Vec<RoadOption> = route.iter().map(|point| point.option).collect();
    options.dedup();
    options.retain(|option| *option != RoadOption::LaneFollow);
    options
}

#[test]
fn a_route_follows_lanes_and_ends_near_its_goal() {
    let town = town();
    let planner = RoutePlanner::new(&town, 2.0);
    assert!(planner.destinations().len() > 400);
    let mut longest = 0;
    let ways = planner
        .destinations()
        .iter()
        .step_by(17)
        .flat_map(|from| planner.destinations().iter().step_by(19).map(move |to| (*from, *to)));
    for (from, to) in ways {
        let [from, to] = [from, to].map(|waypoint| town.pose(waypoint).position());
        if town.nearest_lane(from, LaneFilter::Driving).is_some_and(|lane| town.is_junction(lane)) {
            continue;
        }
        let Some(route) = planner.trace(&town, from, to) else { continue };
        let gaps = route.windows(2).map(|pair| (pair[1].pose.position() - pair[0].pose.position()).norm());
        // The point of a segment that is nearer to its end than the spacing is left out.
        assert!(gaps.fold(0.0, f64::max) < 4.5, "no gaps");
        assert!((route[0].pose.position() - from).norm() < 3.0, "begins where it should");
        if route.len() > 1 {
            let last = route[route.len() - 1].pose.position();
            assert!((last - to).norm() < 4.5, "{last} is the end of a way to {to}");
        }
        longest = longest.max(route.len());
    }
    assert!(longest > 100);
}

#[test]
fn junctions_are_named_and_lanes_are_not() {
    let town = town();
    let planner = RoutePlanner::new(&town, 2.0);
    let south = heading(&town, Point::new(50.0, 0.0), Point::new(100.0, 0.0));
    let north = heading(&town, Point::new(100.0, 40.0), Point::new(100.0, 80.0));
    let east = heading(&town, Point::new(150.0, 0.0), Point::new(200.0, 0.0));
    let west = heading(&town, Point::new(50.0, 80.0), Point::new(0.0, 80.0));
    let end = heading(&town, Point::new(100.0, 130.0), Point::new(100.0, 150.0));
    let way = |from, to| planner.trace(&town, from, to).unwrap();
    assert_eq!(turns(&way(south, north)), [RoadOption::Left]);
    assert_eq!(turns(&way(south, east)), [RoadOption::Straight]);
    assert_eq!(turns(&way(south, west)), [RoadOption::Left, RoadOption::Left]);
    assert_eq!(turns(&way(north, end)), [RoadOption::Straight]);
    for point in way(south, north) {
        // The end of the segment before is the start of a junction's lane.
        let length = town.roads[point.waypoint.road.0 as usize].length;
        let at_end = point.waypoint.s.min(length - point.waypoint.s) < 1e-3;
        assert!(point.option != RoadOption::LaneFollow || !point.is_junction || at_end);
    }
}

#[test]
fn nothing_leads_out_of_a_dead_end() {
    let town = town();
    let planner = RoutePlanner::new(&town, 2.0);
    let end = heading(&town, Point::new(100.0, 130.0), Point::new(100.0, 150.0));
    let back = heading(&town, Point::new(100.0, 110.0), Point::new(100.0, 0.0));
    assert_eq!(planner.trace(&town, end, back), None);
    assert!(planner.trace(&town, back, Point::new(0.0, 40.0)).is_some());
    assert_eq!(RoutePlanner::new(&Town::new(Default::default()), 2.0).trace(&town, end, back), None);
}

#[test]
fn a_goal_just_behind_gives_a_single_point() {
    let town = town();
    let planner = RoutePlanner::new(&town, 2.0);
    let from = heading(&town, Point::new(60.0, 0.0), Point::new(100.0, 0.0));
    let behind = heading(&town, Point::new(40.0, 0.0), Point::new(100.0, 0.0));
    assert_eq!(planner.trace(&town, from, behind).unwrap().len(), 1);
    assert!(planner.trace(&town, behind, from).unwrap().len() > 7);
}

#[test]
fn a_town_keeps_its_planners() {
    let town = town();
    let first = town.route_planner(2.0);
    assert!(Arc::ptr_eq(&first, &town.route_planner(2.0)));
    assert_eq!(town.route_planner(4.5).sampling(), 4.5);
}
