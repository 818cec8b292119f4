use super::{Road, Town, Waypoint};
use crate::geometry::{Pose, wrap_angle};

/// The distance between the first samples of a reference line (m).
const STEP: f64 = 1.0;
/// The greatest number of these samples, a guard against files with absurd lengths.
const MOST_STEPS: f64 = 100_000.0;
/// How often the interval around the nearest sample is halved.
const HALVINGS: u32 = 60;
/// How far beyond the ends of a road a pose may lie, to allow for rounding (m).
const BEYOND: f64 = 1e-6;

/// A pose in the coordinates of a road.
///
/// # Source
/// ASAM OpenDRIVE, "Reference line coordinate systems": `s` along the reference line, `t` across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frenet {
    /// Distance along the reference line from its start (m).
    pub s: f64,
    /// Distance from the reference line, positive to the left (m).
    pub t: f64,
    /// Heading relative to the reference line's, in (−π, π] (rad).
    pub phi: f64,
}

impl Frenet {
    /// Finds the coordinates of a pose by the nearest place on a road's reference line.
    ///
    /// None for a pose beyond the road's ends. If the centre of a bend is nearer to the road than the pose, there are several
    /// solutions; the one with the least `t` is returned.
    pub fn new(road: &Road, pose: &Pose) -> Option<Self> {
        let place = pose.position();
        let count = (road.length / STEP).ceil().clamp(1.0, MOST_STEPS);
        let step = road.length / count;
        let distance = |s: f64| (road.plan_view.point(s).position - place).norm_squared();
        let mut nearest = (0.0, f64::INFINITY);
        let mut index = 0.0;
        while index <= count {
            let distance = distance(index * step);
            if distance < nearest.1 {
                nearest = (index, distance);
            }
            index += 1.0;
        }
        // At the nearest place the pose changes from ahead to behind.
        let ahead = |s: f64| {
            let line = road.plan_view.point(s);
            (place - line.position).dot(&line.forward)
        };
        let (mut low, mut high) = (((nearest.0 - 1.0) * step).max(0.0), ((nearest.0 + 1.0) * step).min(road.length));
        if ahead(low) < -BEYOND || ahead(high) > BEYOND {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if ahead(middle) > 0.0 { low = middle } else { high = middle }
        }
        let s = 0.5 * (low + high);
        let line = road.plan_view.point(s);
        let t = line.forward.perp(&(place - line.position));
        Some(Self { s, t, phi: wrap_angle(pose.yaw - line.yaw) })
    }

    /// The pose in the world; beyond the road's ends the reference line is clamped.
    pub fn pose(&self, road: &Road) -> Pose {
        let line = road.plan_view.point(self.s);
        let place = line.beside(self.t);
        Pose { x: place.x, y: place.y, yaw: wrap_angle(line.yaw + self.phi) }
    }
}

impl Town {
    /// A pose in the coordinates of a waypoint's road; none beyond the road's ends.
    pub fn frenet(&self, waypoint: Waypoint, pose: &Pose) -> Option<Frenet> {
        Frenet::new(self.roads.get(waypoint.road.0 as usize)?, pose)
    }

    /// The pose in the world of coordinates on a waypoint's road.
    pub fn pose_of(&self, waypoint: Waypoint, frenet: &Frenet) -> Option<Pose> {
        Some(frenet.pose(self.roads.get(waypoint.road.0 as usize)?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Geometry, LaneSection, PlanView, Profile, Shape};
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// A line, an arc and a spiral of 40 m each, one after the other.
    fn road(start: Pose, curvature: f64, last: f64) -> Road {
        let line = Geometry::line(0.0, start, 40.0);
        let arc = Geometry::arc(40.0, line.pose(40.0), 40.0, curvature);
        let spiral = Geometry::new(80.0, arc.pose(40.0), 40.0, Shape::Spiral(curvature, last));
        Road {
            id: 0,
            name: String::new(),
            length: 120.0,
            junction: None,
            left_hand: false,
            plan_view: PlanView::new(vec![spiral, line, arc]),
            lane_offset: Profile::default(),
            sections: vec![LaneSection { start: 0.0, end: 120.0, lanes: Vec::new() }],
            predecessor: None,
            successor: None,
        }
    }

    #[test]
    fn left_is_positive() {
        let road = road(Pose::new(5.0, 1.0, FRAC_PI_2), 0.02, 0.0);
        let frenet = Frenet::new(&road, &Pose::new(3.0, 11.0, PI)).unwrap();
        assert!((frenet.s - 10.0).abs() < 1e-9 && (frenet.t - 2.0).abs() < 1e-9, "{frenet:?}");
        assert!((frenet.phi - FRAC_PI_2).abs() < 1e-9);
        let centre = Frenet::new(&road, &Pose::new(5.0 - 10.0, 41.0, 0.0)).unwrap();
        assert!((centre.s - 40.0).abs() < 1e-6 && (centre.t - 10.0).abs() < 1e-6, "{centre:?}");
    }

    #[test]
    fn beyond_the_ends_there_is_nothing() {
        let road = road(Pose::default(), 0.01, -0.01);
        assert_eq!(Frenet::new(&road, &Pose::new(-0.5, 3.0, 0.0)), None);
        let end = road.plan_view.pose(120.0);
        let beyond = end.position() + end.forward();
        assert_eq!(Frenet::new(&road, &Pose::new(beyond.x, beyond.y, 0.0)), None);
        assert!(Frenet::new(&road, &Pose::new(0.0, 3.0, 0.0)).is_some());
    }

    proptest! {
        #[test]
        fn there_and_back(
            x in -500.0..500.0, y in -500.0..500.0, yaw in -PI..PI,
            curvature in -0.02..0.02, last in -0.02..0.02,
            s in 0.0..120.0, t in -15.0..15.0, phi in -3.1..3.1,
        ) {
            let road = road(Pose::new(x, y, yaw), curvature, last);
            let frenet = Frenet { s, t, phi };
            let pose = frenet.pose(&road);
            let back = Frenet::new(&road, &pose).unwrap();
            prop_assert!((back.s - s).abs() < 1e-7 && (back.t - t).abs() < 1e-7, "{back:?}");
            prop_assert!(wrap_angle(back.phi - phi).abs() < 1e-7);
            prop_assert!((back.pose(&road).position() - pose.position()).norm() < 1e-7);
        }
    }
}
