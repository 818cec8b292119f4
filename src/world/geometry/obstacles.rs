//! Static obstacles, which block pedestrians and lines of sight. The only code that knows parry2d.
//!
//! parry2d computes in `f32`. A town is hundreds of metres wide, so every exact query is made in the frame of one box, where an `f32`
//! resolves micrometres. Only the search for nearby boxes uses world coordinates, with a margin.

use parry2d::bounding_volume::Aabb;
use parry2d::math::Vector as Vec32;
use parry2d::partitioning::{Bvh, BvhBuildStrategy};
use parry2d::query::{PointQuery, Ray, RayCast};
use parry2d::shape::Cuboid;

use super::{OrientedBox, Point, Vector};

/// Slack of the search in world coordinates (m).
const MARGIN: f64 = 0.05;

/// Static boxes, with an index over them.
pub struct Obstacles {
    boxes: Vec<(OrientedBox, Cuboid)>,
    index: Bvh,
}

impl Obstacles {
    /// Indexes the boxes.
    pub fn new(boxes: &[OrientedBox]) -> Self {
        let bounds: Vec<Aabb> = boxes
            .iter()
            .map(|each| {
                let corners = each.corners();
                let low = corners.iter().fold(corners[0], |a, b| a.inf(b));
                let high = corners.iter().fold(corners[0], |a, b| a.sup(b));
                bounds(low, high)
            })
            .collect();
        let with_shape = |each: &OrientedBox| (*each, Cuboid::new(single(each.half)));
        Self {
            boxes: boxes.iter().map(with_shape).collect(),
            index: Bvh::from_leaves(BvhBuildStrategy::Binned, &bounds),
        }
    }

    /// Moves the centre of a disc out of every box it overlaps, the shortest way; so a pedestrian slides along walls.
    ///
    /// Between two boxes closer than the disc is wide the last one wins.
    pub fn push_out(&self, centre: Point, radius: f64) -> Point {
        let reach = Vector::new(radius, radius);
        let mut centre = centre;
        if self.boxes.is_empty() {
            return centre;
        }
        for found in self.index.intersect_aabb(&bounds(centre - reach, centre + reach)) {
            let (obstacle, shape) = &self.boxes[found as usize];
            let local = obstacle.pose.to_local(centre);
            let projection = shape.project_local_point(single(local), false);
            let surface = Vector::new(f64::from(projection.point.x), f64::from(projection.point.y));
            let outward = if projection.is_inside { surface - local } else { local - surface };
            let distance = outward.norm();
            if !projection.is_inside && distance >= radius {
                continue;
            }
            // A centre exactly on the surface has no direction of its own; it takes the direction from the box's centre.
            let middle = local.try_normalize(1e-9).unwrap_or_else(Vector::x);
            let direction = if distance > 1e-9 { outward / distance } else { middle };
            centre = obstacle.pose.to_world(surface + direction * radius);
        }
        centre
    }

    /// The distance from a point to the nearest box within `reach` (m); `reach` when there is none.
    pub fn clearance(&self, point: Point, reach: f64) -> f64 {
        let around = Vector::new(reach, reach);
        if self.boxes.is_empty() {
            return reach;
        }
        let searched = bounds(point - around, point + around);
        let near = self.index.intersect_aabb(&searched);
        near.map(|found| self.boxes[found as usize].0.distance_to(point)).fold(reach, f64::min)
    }

    /// Whether the middle or an edge of a disc of this radius (m) can be seen from a point.
    pub fn shows(&self, from: Point, middle: Point, radius: f64) -> bool {
        let sight = (middle - from).try_normalize(1e-9).unwrap_or_else(Vector::x);
        let edge = Vector::new(-sight.y, sight.x) * radius;
        [Vector::zeros(), edge, -edge].iter().any(|offset| !self.blocks_sight(from, middle + offset))
    }

    /// Writes for each ray from a point which share of it is free, from 0 to 1; 0 for all of them within a box.
    pub fn free_shares(&self, from: Point, rays: &[Vector], shares: &mut [f64]) {
        shares.fill(1.0);
        if self.boxes.is_empty() {
            return;
        }
        let reach = rays.iter().fold(0.0, |reach: f64, ray| reach.max(ray.norm()));
        let around = Vector::new(reach, reach);
        for found in self.index.intersect_aabb(&bounds(from - around, from + around)) {
            let (obstacle, shape) = &self.boxes[found as usize];
            let start = single(obstacle.pose.to_local(from));
            for (ray, share) in rays.iter().zip(&mut *shares) {
                let ray = Ray::new(start, single(obstacle.pose.to_local(from + ray)) - start);
                if let Some(hit) = shape.cast_local_ray(&ray, *share as f32, true) {
                    *share = share.min(f64::from(hit));
                }
            }
        }
    }

    /// Whether a box stands between two points.
    pub fn blocks_sight(&self, from: Point, to: Point) -> bool {
        if self.boxes.is_empty() {
            return false;
        }
        self.index.intersect_aabb(&bounds(from.inf(&to), from.sup(&to))).any(|found| {
            let (obstacle, shape) = &self.boxes[found as usize];
            let (start, end) = (obstacle.pose.to_local(from), obstacle.pose.to_local(to));
            let ray = Ray::new(single(start), single(end - start));
            shape.cast_local_ray(&ray, 1.0, true).is_some()
        })
    }
}

impl std::fmt::Debug for Obstacles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Obstacles({})", self.boxes.len())
    }
}

fn single(vector: Vector) -> Vec32 {
    Vec32::new(vector.x as f32, vector.y as f32)
}

fn bounds(low: Point, high: Point) -> Aabb {
    let margin = Vector::new(MARGIN, MARGIN);
    Aabb::new(single((low - margin).coords), single((high + margin).coords))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use proptest::prelude::*;

    fn house() -> OrientedBox {
        OrientedBox::new(Pose::new(200.0, -300.0, 0.4), 10.0, 5.0)
    }

    #[test]
    fn sight_is_blocked_through_a_box_and_free_past_it() {
        let obstacles = Obstacles::new(&[house()]);
        let through = house().pose.to_world(Vector::new(-20.0, 0.0));
        assert!(obstacles.blocks_sight(through, house().pose.to_world(Vector::new(20.0, 1.0))));
        assert!(!obstacles.blocks_sight(through, house().pose.to_world(Vector::new(20.0, 40.0))));
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
                prop_assert!(obstacles.blocks_sight(a, b));
            }
            if deepest > 0.3 {
                prop_assert!(!obstacles.blocks_sight(a, b));
            }
        }
    }
}
