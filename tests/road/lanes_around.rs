//! The lanes around a place.

use road::Town;
use road::geometry::Point;

/// Two streets that cross at the origin, with lanes of 4 m.
fn crossing() -> Town {
    let nodes = [(-80.0, 0.0), (0.0, 0.0), (80.0, 0.0), (0.0, 80.0), (0.0, -80.0)];
    crate::streets::town(&nodes, &[&[0, 1, 2], &[3, 1, 4]])
}

#[test]
fn a_point_is_inside_the_lane_around_it_up_to_the_edge() {
    let town = crossing();
    let at = |y: f64| town.lane_around(Point::new(-50.0, y)).unwrap();
    let own = at(-2.0);
    assert!((own.inside - 2.1).abs() < 1e-6 && own.direction.x > 0.99 && !own.is_junction, "{own:?}");
    assert!((at(-4.05).inside - 0.05).abs() < 1e-6 && (at(-4.5).inside + 0.4).abs() < 1e-6);
    assert!(at(1.75).direction.x < -0.99, "the other lane leads back");
}

#[test]
fn past_the_end_is_ahead_of_a_lane_that_leads_nowhere() {
    let town = crossing();
    let past = |x: f64, y: f64| town.is_past_end(Point::new(x, y));
    assert!(past(84.0, -2.0) && past(-84.0, 2.0) && past(90.0, -4.0), "ahead of the end of its own lane");
    assert!(!past(79.0, -2.0) && !past(81.0, -2.0), "on the road, and up to half a width past its end");
    assert!(!past(79.0, -9.0) && !past(0.0, 0.0), "beside the road is not past its end");
    assert!(!past(-90.0, -2.0), "behind the start of a lane");
}

#[test]
fn a_road_ends_within_the_way_to_the_nearest_end() {
    let town = crossing();
    let from = town.lane_around(Point::new(50.0, -1.75)).unwrap().place;
    assert!(town.ends_within(from, 31.0) && !town.ends_within(from, 29.0));
    let behind_the_junction = town.lane_around(Point::new(-50.0, -1.75)).unwrap().place;
    assert!(town.ends_within(behind_the_junction, 135.0) && !town.ends_within(behind_the_junction, 110.0));
}

#[test]
fn the_way_on_has_the_turns_of_a_junction_and_nothing_else() {
    let town = crossing();
    let from = town.lane_around(Point::new(-50.0, -1.75)).unwrap().place;
    let inside = |x: f64, y: f64| town.inside_way_on(from, Point::new(x, y));
    assert!(inside(0.0, -1.75) > 1.8, "straight on");
    assert!(inside(1.75, 30.0) > 1.8 && inside(-1.75, -30.0) > 1.8, "after a turn to the left, and to the right");
    assert!(inside(-1.75, 30.0) < 0.0 && inside(30.0, 1.75) < 0.0, "against the traffic");
    assert!(town.lane_around(Point::new(0.0, 1.75)).unwrap().is_junction);
}
