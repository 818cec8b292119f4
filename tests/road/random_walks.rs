//! Routes that are drawn at forks.

use base::seed::Seed;
use road::geometry::{Point, Pose};
use road::{ForkRule, LaneFilter, RandomWalk, RoadOption, RoutePoint, Town, Waypoint, turn};

/// A street to the east, and one that leads north from its middle.
fn t_junction() -> Town {
    crate::streets::town(&[(-80.0, 0.0), (0.0, 0.0), (80.0, 0.0), (0.0, 80.0)], &[&[0, 1, 2], &[1, 3]])
}

#[test]
fn every_way_through_a_junction_is_taken_and_named() {
    let town = t_junction();
    let start = town.nearest_lane(Point::new(0.0, 60.0), LaneFilter::Driving).unwrap();
    let towards = (0..2).map(|side| if side == 0 { start } else { town.left_lane(start).unwrap() });
    let start = towards.into_iter().find(|lane| town.pose(*lane).yaw < 0.0).unwrap();
    let mut stream = Seed::root(1).stream();
    let mut walk = RandomWalk::new(ForkRule::AnyBranch);
    let mut seen = [0; 2];
    for _ in 0..40 {
        let mut point = RoutePoint::new(&town, start, RoadOption::LaneFollow);
        let mut through = Vec::new();
        for _ in 0..50 {
            point = walk.next(&town, &point, 2.0, &mut stream).unwrap();
            if point.is_junction {
                through.push(point.option);
            } else if !through.is_empty() {
                break;
            }
        }
        assert!(through.iter().all(|option| *option == through[0]), "{through:?}");
        // Coming from the north, east is to the left.
        match through[0] {
            RoadOption::Left if point.pose.x > 0.0 => seen[0] += 1,
            RoadOption::Right if point.pose.x < 0.0 => seen[1] += 1,
            other => panic!("{other:?} ends at {:?}", point.pose),
        }
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
}

#[test]
fn given_lanes_are_taken_and_then_forks_are_drawn_again() {
    let town = t_junction();
    // Back from a place on the way out to the west, through the junction, to one of the two ways in.
    let goal = town.nearest_lane(Point::new(-60.0, 1.75), LaneFilter::Driving).unwrap();
    for rule in [ForkRule::AnyBranch, ForkRule::NamedTurn] {
        for inside in town.predecessors(goal) {
            let before = town.predecessors(inside).next().unwrap();
            let start = town.moved(before, -30.0);
            let walk = |lanes: &[Waypoint], seed: u64| {
                let (mut walk, mut stream) = (RandomWalk::new(rule), Seed::root(seed).stream());
                walk.take(lanes);
                let mut point = RoutePoint::new(&town, start, RoadOption::LaneFollow);
                while point.is_junction || point.waypoint.is_on_lane_of(&start) {
                    point = walk.next(&town, &point, 2.0, &mut stream).unwrap();
                }
                (point.waypoint.is_on_lane_of(&goal), stream)
            };
            for seed in 0..8 {
                let (arrived, stream) = walk(&[start, before, inside, goal], seed);
                assert!(arrived && stream.word() == 0, "the way is given, so nothing is drawn");
            }
            let elsewhere = (0..16).any(|seed| !walk(&[], seed).0);
            assert!(rule == ForkRule::NamedTurn || elsewhere, "without lanes it goes elsewhere, too");
        }
    }
}

#[test]
fn turns_are_named_by_their_side() {
    let heading = |degrees: f64| Pose::new(0.0, 0.0, degrees.to_radians());
    assert_eq!(turn(&heading(0.0), &heading(30.0)), RoadOption::Straight);
    assert_eq!(turn(&heading(170.0), &heading(-130.0)), RoadOption::Left);
    assert_eq!(turn(&heading(10.0), &heading(-60.0)), RoadOption::Right);
}
