//! Cubics and the reference lines of roads.

use road::geometry::Pose;
use road::{Cubic, Geometry, PlanView, Profile, Shape};
use std::f64::consts::{FRAC_PI_2, PI};

#[test]
fn each_cubic_is_valid_from_its_start() {
    let profile = Profile::new(vec![
        Cubic { start: 10.0, a: 5.0, b: 1.0, c: 0.5, d: 0.25 },
        Cubic { start: 0.0, a: 3.0, ..Cubic::default() },
    ]);
    assert_eq!((profile.value(-1.0), profile.value(9.0)), (3.0, 3.0));
    assert_eq!(profile.value(12.0), 5.0 + 2.0 + 2.0 + 2.0);
    assert_eq!(profile.slope(12.0), 1.0 + 2.0 + 3.0);
    assert_eq!(Profile::default().value(1.0), 0.0);
}

#[test]
fn a_sum_has_the_values_and_slopes_of_its_terms_together() {
    let one = Profile::new(vec![
        Cubic { start: 0.0, a: 1.0, b: 0.1, c: 0.02, d: -0.003 },
        Cubic { start: 7.0, a: 2.0, b: -0.2, ..Cubic::default() },
    ]);
    let two = Profile::new(vec![Cubic { start: -3.0, a: 0.5, b: 0.3, c: -0.01, d: 0.002 }]);
    let sum = Profile::sum(&[(&one, 1.0), (&two, -0.5)], 2.0, 10.0);
    assert_eq!(sum.cubics().len(), 2);
    for s in [2.0, 4.5, 6.999, 7.0, 9.5] {
        assert!((sum.value(s) - (one.value(s) - 0.5 * two.value(s))).abs() < 1e-12);
        assert!((sum.slope(s) - (one.slope(s) - 0.5 * two.slope(s))).abs() < 1e-12);
    }
}

fn near(pose: Pose, x: f64, y: f64, yaw: f64) {
    assert!((pose.x - x).abs() < 1e-9 && (pose.y - y).abs() < 1e-9 && (pose.yaw - yaw).abs() < 1e-9, "{pose:?}");
}

#[test]
fn a_quarter_circle_to_the_left_ends_ahead_and_to_the_left() {
    let radius = 20.0;
    let arc = Geometry::arc(0.0, Pose::new(1.0, 2.0, FRAC_PI_2), radius * FRAC_PI_2, 1.0 / radius);
    near(arc.pose(arc.length), 1.0 - radius, 2.0 + radius, PI);
}

#[test]
fn a_line_view_is_held_at_both_ends() {
    let bend = Geometry::arc(10.0, Pose::new(10.0, 0.0, 0.0), 10.0, -0.1);
    let view = PlanView::new(vec![bend, Geometry::line(0.0, Pose::default(), 10.0)]);
    near(view.pose(-5.0), 0.0, 0.0, 0.0);
    near(view.pose(7.0), 7.0, 0.0, 0.0);
    near(view.pose(99.0), 10.0 + 10.0 * libm::sin(1.0_f64), -10.0 * (1.0 - libm::cos(1.0_f64)), -1.0);
    near(PlanView::default().pose(1.0), 0.0, 0.0, 0.0);
}

#[test]
fn a_spiral_from_straight_reaches_the_curvature_of_the_arc_after_it() {
    let spiral = Geometry::new(0.0, Pose::default(), 30.0, Shape::Spiral(0.0, 0.02));
    assert!((spiral.pose(30.0).yaw - 0.3).abs() < 1e-12);
    let curvature = (spiral.pose(30.0).yaw - spiral.pose(29.999).yaw) / 0.001;
    assert!((curvature - 0.02).abs() < 1e-6);
}

#[test]
fn a_cubic_is_followed_by_its_length() {
    let cubic = Geometry::new(0.0, Pose::default(), 10.0, Shape::Poly3([0.0, 0.75, 0.0, 0.0]));
    near(cubic.pose(5.0), 4.0, 3.0, libm::atan(0.75_f64));
}

#[test]
fn both_parameters_of_two_cubics_draw_the_same_curve() {
    let pose = Pose::new(3.0, -1.0, 0.3);
    let length = 8.0;
    let (u, v) = ([0.0, 1.0, 0.0, -0.001], [0.0, 0.0, 0.05, 0.002]);
    let scaled = |[a, b, c, d]: [f64; 4]| [a, b * length, c * length * length, d * length * length * length];
    let by_length = Geometry::new(0.0, pose, length, Shape::ParamPoly3 { u, v, normalized: false });
    let by_share = Geometry::new(0.0, pose, length, Shape::ParamPoly3 { u: scaled(u), v: scaled(v), normalized: true });
    for ds in [0.0, 2.5, 8.0] {
        let expected = by_length.pose(ds);
        near(by_share.pose(ds), expected.x, expected.y, expected.yaw);
    }
    let steps = 4000;
    let at = |i: i32| by_length.pose(5.0 * f64::from(i) / f64::from(steps)).position();
    let walked: f64 = (0..steps).map(|i| (at(i + 1) - at(i)).norm()).sum();
    assert!((walked - 5.0).abs() < 1e-6, "{walked}");
}
