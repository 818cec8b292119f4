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
