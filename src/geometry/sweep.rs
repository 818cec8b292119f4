//! The first touch of a moving disc and a moving box within one tick, in closed form.
//!
//! In the frame of the box the disc's centre moves along a line (to the accuracy of one tick's rotation, under a
//! centimetre at walking distances). The disc touches the box when its centre enters the box grown by the radius: two
//! slabs and four quarter circles.

use super::{OrientedBox, Point, Vector};

/// A touch within a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// When, as a share of the tick from 0 to 1.
    pub fraction: f64,
    /// The disc's centre in the frame of the box then: ahead and to the left (m).
    pub local: Vector,
}

/// Finds the first moment at which a disc that moves from `from` to `to` touches a box that moves from `start` to
/// `end`; both boxes have the same size.
pub fn first_touch(from: Point, to: Point, radius: f64, start: &OrientedBox, end: &OrientedBox) -> Option<Touch> {
    let a = start.pose.to_local(from);
    let motion = end.pose.to_local(to) - a;
    let half = start.half;
    let reach = half + Vector::new(radius, radius);
    // Most ticks end here: the whole way lies beyond one side of the grown box.
    let b = a + motion;
    if a.x.min(b.x) > reach.x || a.x.max(b.x) < -reach.x || a.y.min(b.y) > reach.y || a.y.max(b.y) < -reach.y {
        return None;
    }
    let fraction = enter_grown(a, motion, half, radius)?;
    Some(Touch { fraction, local: a + motion * fraction })
}

/// Finds the time (s) after which a disc touches a box, when it keeps its place and velocity in the frame of the box (m, m/s); none
/// when that is not within the horizon (s). 0 when it touches already.
pub fn time_to_touch(place: Vector, velocity: Vector, half: Vector, radius: f64, horizon: f64) -> Option<f64> {
    let (reach, end) = (half + Vector::new(radius, radius), place + velocity * horizon);
    if place.x.min(end.x) > reach.x
        || place.x.max(end.x) < -reach.x
        || place.y.min(end.y) > reach.y
        || place.y.max(end.y) < -reach.y
    {
        return None;
    }
    enter_grown(place, velocity * horizon, half, radius).map(|fraction| fraction * horizon)
}

/// The share of a motion after which a point enters a box that is grown by a radius.
fn enter_grown(start: Vector, motion: Vector, half: Vector, radius: f64) -> Option<f64> {
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let slabs = [
        enter_slab(start, motion, Vector::new(half.x + radius, half.y)),
        enter_slab(start, motion, Vector::new(half.x, half.y + radius)),
    ];
    let circles = corners.map(|(x, y)| enter_circle(start - Vector::new(x * half.x, y * half.y), motion, radius));
    slabs.into_iter().chain(circles).flatten().min_by(f64::total_cmp)
}

fn enter_slab(start: Vector, motion: Vector, half: Vector) -> Option<f64> {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        if motion[axis] == 0.0 {
            if start[axis].abs() > half[axis] {
                return None;
            }
            continue;
        }
        let (t1, t2) = ((-half[axis] - start[axis]) / motion[axis], (half[axis] - start[axis]) / motion[axis]);
        low = low.max(t1.min(t2));
        high = high.min(t1.max(t2));
    }
    (low <= high).then_some(low)
}

fn enter_circle(start: Vector, motion: Vector, radius: f64) -> Option<f64> {
    let c = start.norm_squared() - radius * radius;
    if c <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (motion.norm_squared(), start.dot(&motion));
    let discriminant = b * b - a * c;
    if a == 0.0 || discriminant < 0.0 {
        return None;
    }
    let t = (-b - discriminant.sqrt()) / a;
    (0.0..=1.0).contains(&t).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    #[test]
    fn a_fast_car_does_not_jump_over_a_walker() {
        let car = |x| OrientedBox::new(Pose::new(x, 0.0, 0.0), 2.4, 1.08);
        let walker = Point::new(5.0, 1.2);
        // 20 m in one tick: the car is past the walker at the end of it.
        let touch = first_touch(walker, walker, 0.19, &car(-10.0), &car(10.0)).unwrap();
        assert!(touch.fraction > 0.6 && touch.fraction < 0.65, "{touch:?}");
        assert!(touch.local.x > 2.4);
        assert_eq!(first_touch(Point::new(5.0, 1.3), Point::new(5.0, 1.3), 0.19, &car(-10.0), &car(10.0)), None);
    }

    proptest! {
        #[test]
        fn agrees_with_small_steps(x in -6.0..6.0f64, y in -4.0..4.0f64, dx in -1.5..1.5f64, dy in -1.5..1.5f64, r in 0.1..0.5f64) {
            let car = OrientedBox::new(Pose::new(0.0, 0.0, 0.0), 2.4, 1.08);
            let (from, to) = (Point::new(x, y), Point::new(x + dx, y + dy));
            let steps = 2000;
            let slow = (0..=steps).map(|i| f64::from(i) / f64::from(steps))
                .find(|t| car.distance_to(from + (to - from) * *t) <= r);
            match (first_touch(from, to, r, &car, &car), slow) {
                (Some(fast), Some(slow)) => prop_assert!((fast.fraction - slow).abs() < 2e-3),
                (None, None) => {}
                // A graze may fall between two steps.
                (Some(fast), None) => prop_assert!(car.distance_to(from + (to - from) * fast.fraction) > r - 1e-3),
                (None, Some(_)) => prop_assert!(false, "missed"),
            }
        }
    }
}
