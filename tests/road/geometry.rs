//! Poses, boxes, obstacles and polygons.

use proptest::prelude::*;
use road::geometry::polygon::{contains, distance};
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector};
use std::f64::consts::FRAC_PI_2;

#[test]
fn local_and_world_frames_are_inverse() {
    let pose = Pose::new(3.0, -2.0, 0.7);
    let local = Vector::new(1.5, -0.25);
    assert!((pose.to_local(pose.to_world(local)) - local).norm() < 1e-12);
}

#[test]
fn bearings_are_positive_to_the_left() {
    let north = Pose::new(0.0, 0.0, FRAC_PI_2);
    assert!((north.bearing_to(Point::new(-1.0, 0.0)) - FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn boxes_overlap_unless_an_axis_separates_them() {
    let car = OrientedBox::new(Pose::new(0.0, 0.0, 0.0), 2.0, 1.0);
    let turned = |x, y| OrientedBox::new(Pose::new(x, y, std::f64::consts::FRAC_PI_4), 1.0, 1.0);
    assert!(car.overlaps(&turned(3.4, 0.0)) && !car.overlaps(&turned(3.42, 0.0)));
    assert!(!car.overlaps(&turned(2.8, 1.8)), "corner to corner, where axis-parallel bounds overlap");
}

#[test]
fn the_separation_leads_from_side_to_side_or_from_corner_to_corner() {
    let car = OrientedBox::new(Pose::new(0.0, 0.0, 0.0), 2.0, 1.0);
    let at = |x, y, yaw| OrientedBox::new(Pose::new(x, y, yaw), 2.0, 1.0);
    assert_eq!(car.separation(&at(1.0, 1.0, 0.5)), Vector::zeros());
    assert!((car.separation(&at(5.5, 0.5, 0.0)) - Vector::new(1.5, 0.0)).norm() < 1e-12, "side to side");
    assert!((car.separation(&at(7.0, 6.0, 0.0)) - Vector::new(3.0, 4.0)).norm() < 1e-12, "corner to corner");
    let turned = at(0.0, -4.0, std::f64::consts::FRAC_PI_2);
    assert!((car.separation(&turned) - Vector::new(0.0, -1.0)).norm() < 1e-12);
    assert!((turned.separation(&car) - Vector::new(0.0, 1.0)).norm() < 1e-12);
}

#[test]
fn a_line_meets_a_box_or_passes_its_corner() {
    let car = OrientedBox::new(Pose::new(10.0, 0.0, std::f64::consts::FRAC_PI_2), 2.0, 1.0);
    let eye = Point::origin();
    assert!(car.is_crossed_by(eye, Point::new(20.0, 0.0)) && car.is_crossed_by(eye, Point::new(10.0, 1.9)));
    assert!(!car.is_crossed_by(eye, Point::new(8.9, 0.0)), "it ends before the box");
    assert!(!car.is_crossed_by(eye, Point::new(9.0, 2.1)) && !car.is_crossed_by(eye, Point::new(-20.0, 0.0)));
}

#[test]
fn distance_is_zero_inside_and_euclidean_at_corners() {
    let unit = OrientedBox::spanning(Point::new(-1.0, -1.0), Point::new(1.0, 1.0));
    assert_eq!(unit.distance_to(Point::new(0.5, -0.5)), 0.0);
    assert!((unit.distance_to(Point::new(4.0, 5.0)) - 5.0).abs() < 1e-12);
}

fn house() -> OrientedBox {
    OrientedBox::new(Pose::new(200.0, -300.0, 0.4), 10.0, 5.0)
}

/// Whether one point sees another.
fn sees(obstacles: &Obstacles, from: Point, to: Point) -> bool {
    obstacles.shows(from, (to, 0.0), std::iter::empty())
}

#[test]
fn sight_is_blocked_through_a_box_and_free_past_it() {
    let obstacles = Obstacles::new(&[house()]);
    let through = house().pose.to_world(Vector::new(-20.0, 0.0));
    assert!(!sees(&obstacles, through, house().pose.to_world(Vector::new(20.0, 1.0))));
    assert!(sees(&obstacles, through, house().pose.to_world(Vector::new(20.0, 40.0))));
}

#[test]
fn a_ray_is_free_up_to_the_first_box() {
    let behind = OrientedBox::new(Pose::new(200.0, -270.0, 0.4), 10.0, 5.0);
    let obstacles = Obstacles::new(&[behind, house()]);
    // Seven metres before the near side of the house, whose frame is turned.
    let place = house().pose.to_world(Vector::new(0.0, -12.0));
    let along = |x: f64, y: f64| house().pose.to_world(Vector::new(x, y - 12.0)) - place;
    let mut shares = [f64::NAN; 4];
    obstacles.free_shares(
        place,
        &[along(0.0, 20.0), along(20.0, 0.0), along(0.0, -20.0), along(9.9, 9.9)],
        &mut shares,
    );
    assert!((shares[0] - 7.0 / 20.0).abs() < 1e-5 && (shares[3] - 7.0 / 9.9).abs() < 1e-5, "{shares:?}");
    assert_eq!(shares[1..3], [1.0; 2]);
    obstacles.free_shares(house().pose.position(), &[along(1.0, 2.0)], &mut shares[..1]);
    assert_eq!(shares[0], 0.0);
}

proptest! {
    #[test]
    fn a_disc_pushed_out_touches_no_box(x in -20.0..20.0f64, y in -15.0..15.0f64, radius in 0.1..0.6f64) {
        let obstacles = Obstacles::new(&[house()]);
        let start = house().pose.to_world(Vector::new(x, y));
        let end = obstacles.push_out(start, radius);
        prop_assert!(house().distance_to(end) >= radius - 1e-4);
        if house().distance_to(start) >= radius {
            prop_assert!((end - start).norm() < 1e-9);
        }
    }

    /// What ends on a target is free up to there, and a target without a free ray has none.
    #[test]
    fn a_share_is_that_of_free_rays(x in 12.0..40.0f64, y in -30.0..30.0f64, width in 0.0..3.0f64, car in -10.0..10.0f64) {
        let obstacles = Obstacles::new(&[house()]);
        let eye = house().pose.to_world(Vector::new(-25.0, 0.0));
        let target = house().pose.to_world(Vector::new(x, y));
        let other = OrientedBox::new(Pose::new(eye.x + 4.0, eye.y + car, 0.3), 2.0, 1.0);
        let across = (target - eye).normalize();
        let ends = [-0.8, -0.4, 0.0, 0.4, 0.8].map(|share| target + Vector::new(-across.y, across.x) * (share * width));
        let free = ends.iter().filter(|end| sees(&obstacles, eye, **end) && !other.is_crossed_by(eye, **end)).count();
        let others = std::iter::once(other);
        let share = obstacles.visible_share(eye, (target, width), others.clone());
        prop_assert_eq!(share, free as f64 / 5.0);
        prop_assert_eq!(obstacles.shows(eye, (target, width), others), free > 0);
    }

    #[test]
    fn sight_agrees_with_points_on_the_line(ax in -30.0..30.0f64, ay in -30.0..30.0f64, bx in -30.0..30.0f64, by in -30.0..30.0f64) {
        let obstacles = Obstacles::new(&[house()]);
        let (a, b) = (house().pose.to_world(Vector::new(ax, ay)), house().pose.to_world(Vector::new(bx, by)));
        let deepest = (0..=400)
            .map(|i| {
                let local = house().pose.to_local(a + (b - a) * (f64::from(i) / 400.0)).abs();
                (local.x - 10.0).max(local.y - 5.0)
            })
            .fold(f64::INFINITY, f64::min);
        if deepest < -0.01 {
            prop_assert!(!sees(&obstacles, a, b));
        }
        if deepest > 0.3 {
            prop_assert!(sees(&obstacles, a, b));
        }
    }
}

#[test]
fn distances_from_a_square_and_from_a_dart() {
    let ring = |corners: &[(f64, f64)]| corners.iter().map(|(x, y)| Point::new(*x, *y)).collect::<Vec<_>>();
    let square = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)]);
    for (x, y, wanted) in [(2.0, 1.0, 0.0), (5.0, 1.0, 1.0), (7.0, 6.0, 5.0), (-1.0, 2.0, 1.0), (2.0, -0.5, 0.5)] {
        assert!((distance(&square, Point::new(x, y)) - wanted).abs() < 1e-12, "({x}, {y})");
    }
    let dart = ring(&[(0.0, 0.0), (4.0, 0.0), (1.0, 1.0), (0.0, 4.0)]);
    assert!(contains(&dart, Point::new(0.5, 0.5)) && !contains(&dart, Point::new(2.0, 2.0)));
}
