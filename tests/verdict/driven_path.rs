//! The path that a car drove.

use road::geometry::{Point, Pose, Vector};
use std::f64::consts::{FRAC_PI_2, PI};
use verdict::DrivenPath;

/// A quarter circle of 20 m to the left, in steps of half a degree; the car stands for a while in its middle.
fn bend() -> Vec<Pose> {
    let angles = (0..=180).flat_map(|i| std::iter::repeat_n(i, if i == 90 { 5 } else { 1 }));
    let pose = |i| {
        let yaw = FRAC_PI_2 * f64::from(i) / 180.0;
        Pose::new(20.0 * libm::sin(yaw), 20.0 * (1.0 - libm::cos(yaw)), yaw)
    };
    angles.map(pose).collect()
}

#[test]
fn places_and_poses_are_inverse_in_a_bend_and_beyond_it() {
    let path = DrivenPath::new(bend());
    for along in [0.0, 3.3, 15.0, 31.0, 40.0] {
        let pose = path.pose(along, &mut 0);
        for aside in [-4.0, 0.0, 3.0] {
            let place = path.place(pose.to_world(Vector::new(0.0, aside)), 0.0);
            assert!((place.along - along).abs() < 0.05 && (place.aside - aside).abs() < 0.01, "{along} {place:?}");
            assert!((place.direction - pose.forward()).norm() < 0.01);
        }
    }
}

#[test]
fn the_nearest_vertex_is_found_without_looking_at_all() {
    let path = DrivenPath::new(bend());
    for (x, y) in [(-5.0, 3.0), (0.0, 20.0), (3.0, 17.0), (20.0, 5.0), (21.0, 40.0), (14.0, 6.0), (500.0, -300.0)] {
        let point = Point::new(x, y);
        let distances = bend().into_iter().map(|pose| (point - pose.position()).norm());
        let least = distances.fold(f64::INFINITY, f64::min);
        let place = path.place(point, 0.0);
        let inside = (0.0..=10.0 * PI).contains(&place.along);
        assert!(!inside || (place.aside.abs() - least).abs() < 0.02, "{point}: {place:?}, {least} m");
    }
}

#[test]
fn a_car_that_stood_has_a_straight_path() {
    let path = DrivenPath::new([Pose::new(1.0, 2.0, FRAC_PI_2); 3]);
    assert!((path.pose(5.0, &mut 0).y - 7.0).abs() < 1e-12);
    assert!((path.place(Point::new(0.0, 6.0), 0.0).aside - 1.0).abs() < 1e-12);
    assert!((path.place(Point::new(0.0, -1.0), 0.0).along + 3.0).abs() < 1e-12, "behind");
}
