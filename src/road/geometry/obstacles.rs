//! Obstacles that do not move, which block pedestrians and lines of sight. The only code that knows parry2d.
//!
//! parry2d computes in `f32`. A town is hundreds of metres wide, so every exact query is made in the frame of one box, where an `f32`
//! resolves micrometres. Only the search for nearby boxes uses world coordinates, with a margin.

use std::collections::BTreeSet;
use std::sync::Arc;

use parry2d::bounding_volume::Aabb;
use parry2d::math::Vector as Vec32;
use parry2d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry2d::query::{PointQuery, Ray, RayCast};
use parry2d::shape::Cuboid;

use super::{OrientedBox, Point, Vector};

/// Slack of the search in world coordinates (m).
const MARGIN: f64 = 0.05;

/// Where the rays of a line of sight end, as shares of half the width of what is looked at.
const RAYS: [f64; 5] = [0.0, -0.8, 0.8, -0.4, 0.4];

/// The boxes of a town with an index over them, and those of the parked vehicles of an episode. A copy shares the former.
#[derive(Clone)]
pub struct Obstacles {
    fixed: Arc<Fixed>,
    parked: Vec<Shaped>,
}

/// A box and its shape.
type Shaped = (OrientedBox, Cuboid);

struct Fixed {
    boxes: Vec<Shaped>,
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
        let index = Bvh::from_leaves(BvhBuildStrategy::Binned, &bounds);
        let fixed = Fixed { boxes: boxes.iter().copied().map(shaped).collect(), index };
        Self { fixed: Arc::new(fixed), parked: Vec::new() }
    }

    /// Replaces the parked vehicles by these.
    pub fn park(&mut self, vehicles: impl Iterator<Item = OrientedBox>) {
        self.parked.clear();
        self.parked.extend(vehicles.map(shaped));
    }

    /// The boxes of the town that stand between the two points of a line, by their numbers.
    pub fn hiding(&self, lines: impl Iterator<Item = (Point, Point)>) -> BTreeSet<usize> {
        let on_line = |(from, to): (Point, Point)| {
            let query = BvhNode::leaf(bounds(from.inf(&to), from.sup(&to)), 0);
            let near: Vec<u32> = self.fixed.index.leaves(move |node| node.intersects(&query)).collect();
            let near = near.into_iter().map(|number| number as usize);
            near.filter(|number| hides(&self.fixed.boxes[*number], from, to)).collect::<Vec<_>>()
        };
        lines.flat_map(on_line).collect()
    }

    /// The obstacles without a box of the town, with the middle of this one.
    pub fn without(&self, number: usize) -> (Self, Point) {
        let mut boxes: Vec<OrientedBox> = self.fixed.boxes.iter().map(|(each, _)| *each).collect();
        let gone = boxes.remove(number);
        (Self { parked: self.parked.clone(), ..Self::new(&boxes) }, gone.pose.position())
    }

    fn is_empty(&self) -> bool {
        self.fixed.boxes.is_empty() && self.parked.is_empty()
    }

    /// The boxes that may reach between two corners, and all parked vehicles.
    fn between(&self, low: Point, high: Point) -> impl Iterator<Item = &Shaped> {
        self.fixed_between(low, high).chain(&self.parked)
    }

    /// The boxes of the town that may reach between two corners.
    fn fixed_between(&self, low: Point, high: Point) -> impl Iterator<Item = &Shaped> {
        let query = BvhNode::leaf(bounds(low, high), 0);
        let found = self.fixed.index.leaves(move |node| node.intersects(&query));
        found.map(|found| &self.fixed.boxes[found as usize])
    }

    /// Moves the centre of a disc out of every box it overlaps, the shortest way; so a pedestrian slides along walls.
    ///
    /// Between two boxes closer than the disc is wide the last one wins.
    pub fn push_out(&self, centre: Point, radius: f64) -> Point {
        let reach = Vector::new(radius, radius);
        let mut centre = centre;
        if self.is_empty() {
            return centre;
        }
        for (obstacle, shape) in self.between(centre - reach, centre + reach) {
            // Most parked vehicles are far away.
            let around = obstacle.half.sum() + radius + MARGIN;
            if (obstacle.pose.position() - centre).norm_squared() > around * around {
                continue;
            }
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
        if self.is_empty() {
            return reach;
        }
        self.between(point - around, point + around).map(|(each, _)| each.distance_to(point)).fold(reach, f64::min)
    }

    /// The boxes within `reach` of a point (m), and perhaps some that are farther.
    pub fn near(&self, point: Point, reach: f64) -> impl Iterator<Item = &OrientedBox> {
        let around = Vector::new(reach, reach);
        self.between(point - around, point + around).map(|(each, _)| each)
    }

    /// The share of a target that an eye sees: of five rays to points across it those that neither an obstacle nor one of these boxes blocks. It is the one line of
    /// sight of drivers, sensors, signals and verdicts.
    ///
    /// Seen from above: whatever is in between hides, however low. The target is a middle and half its width as the eye sees it (m).
    pub fn visible_share(
        &self,
        eye: Point,
        target: (Point, f64),
        others: impl Iterator<Item = OrientedBox> + Clone,
    ) -> f64 {
        self.free_rays(eye, target, others).count() as f64 / RAYS.len() as f64
    }

    /// Whether an eye sees any of it.
    pub fn shows(&self, eye: Point, target: (Point, f64), others: impl Iterator<Item = OrientedBox> + Clone) -> bool {
        self.free_rays(eye, target, others).next().is_some()
    }

    fn free_rays(
        &self,
        eye: Point,
        (middle, half_width): (Point, f64),
        others: impl Iterator<Item = OrientedBox> + Clone,
    ) -> impl Iterator<Item = Point> {
        let across = across(eye, middle) * half_width;
        let ends = RAYS.into_iter().map(move |share| middle + across * share);
        ends.filter(move |end| {
            !self.blocks_sight(eye, *end) && !others.clone().any(|other| other.is_crossed_by(eye, *end))
        })
    }

    /// Writes for each ray from a point which share of it is free, from 0 to 1; 0 for all of them within a box.
    pub fn free_shares(&self, from: Point, rays: &[Vector], shares: &mut [f64]) {
        shares.fill(1.0);
        if self.is_empty() {
            return;
        }
        let reach = rays.iter().fold(0.0, |reach: f64, ray| reach.max(ray.norm()));
        let around = Vector::new(reach, reach);
        for (obstacle, shape) in self.between(from - around, from + around) {
            let start = single(obstacle.pose.to_local(from));
            for (ray, share) in rays.iter().zip(&mut *shares) {
                let ray = Ray::new(start, single(obstacle.pose.to_local(from + ray)) - start);
                if let Some(hit) = shape.cast_local_ray(&ray, *share as f32, true) {
                    *share = share.min(f64::from(hit));
                }
            }
        }
    }

    /// Whether a box stands between two points. A parked vehicle does not hide what is within it: itself.
    fn blocks_sight(&self, from: Point, to: Point) -> bool {
        if self.is_empty() {
            return false;
        }
        let mut others = self.parked.iter();
        self.fixed_between(from.inf(&to), from.sup(&to)).any(|each| hides(each, from, to))
            || others.any(|each| hides(each, from, to) && each.0.distance_to(to) > 0.0)
    }
}

/// The unit vector across a line of sight.
fn across(eye: Point, place: Point) -> Vector {
    let line = (place - eye).try_normalize(1e-9).unwrap_or_else(Vector::x);
    Vector::new(-line.y, line.x)
}

/// Half the width of a box as an eye sees it from afar (m).
pub fn half_width_of(outline: &OrientedBox, eye: Point) -> f64 {
    let across = across(eye, outline.pose.position());
    let [forward, left] = outline.pose.axes();
    outline.half.x * across.dot(&forward).abs() + outline.half.y * across.dot(&left).abs()
}

/// Whether a box stands between two points.
fn hides((obstacle, shape): &Shaped, from: Point, to: Point) -> bool {
    let (start, end) = (obstacle.pose.to_local(from), obstacle.pose.to_local(to));
    shape.cast_local_ray(&Ray::new(single(start), single(end - start)), 1.0, true).is_some()
}

impl std::fmt::Debug for Obstacles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Obstacles({})", self.fixed.boxes.len() + self.parked.len())
    }
}

fn shaped(each: OrientedBox) -> Shaped {
    (each, Cuboid::new(single(each.half)))
}

fn single(vector: Vector) -> Vec32 {
    Vec32::new(vector.x as f32, vector.y as f32)
}

fn bounds(low: Point, high: Point) -> Aabb {
    let margin = Vector::new(MARGIN, MARGIN);
    Aabb::new(single((low - margin).coords), single((high + margin).coords))
}
