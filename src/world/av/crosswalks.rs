//! Yielding to pedestrians at crosswalks, for the drivers that have the key.

use super::{Actor, Path, Perception};
use base::{choice, keys};
use road::geometry::polygon;
use road::geometry::{Point, Pose};

choice! {
    /// What a driver does at crosswalks.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum AtCrosswalk {
        Ignore = "ignore",
        Yield = "yield",
    }
}

keys! {
    /// The key of a driver that can yield.
    #[derive(Copy)]
    pub struct CrosswalkKeys {
        /// Whether it stops before a crosswalk on which it sees a pedestrian, or one within 1.5 m of it that has not
        /// crossed yet.
        crosswalks: AtCrosswalk = "ignore",
    }
}

impl CrosswalkKeys {
    /// Whether the driver yields to pedestrians.
    pub fn yields(&self) -> bool {
        self.crosswalks == AtCrosswalk::Yield
    }
}

/// A pedestrian this near to a crosswalk wants to use it (m).
///
/// # Source
/// German road traffic regulations (StVO), section 26: pedestrians who recognisably want to use the crosswalk. The distance is ours: a step
/// before the kerb.
const NEAR: f64 = 1.5;
/// Crosswalks beyond this distance are not looked at (m).
const FAR: f64 = 80.0;
/// A pedestrian that has passed the path by more than this beside the car, and walks on, has crossed (m).
const PASSED: f64 = 1.0;
/// Slower pedestrians have no direction (m/s).
const AT_REST: f64 = 0.2;
/// How far before a crosswalk a car stops, if its gap at rest were 0 (m): there is the line of a stop.
const STOP_LINE: f64 = 1.0;

/// The distance from the ego's front to the line of a stop (m) before the first crosswalk at which it must yield; `None` if it may drive on.
pub(super) fn gap(perception: &Perception<'_>, path: &Path) -> Option<f64> {
    let along = to_yield_at(perception, path)?;
    Some((along - perception.ego.half.x - STOP_LINE).max(0.0))
}

/// The distance along the path from the middle of the ego to the first crosswalk that a visible pedestrian uses or is about to use (m); none
/// when there is none within 80 m, and for a crosswalk that the ego's front has reached.
fn to_yield_at(perception: &Perception<'_>, path: &Path) -> Option<f64> {
    let (ego, here) = (&perception.ego, perception.ego.pose.position());
    let mut first: Option<f64> = None;
    for corners in &perception.town.crosswalks {
        let is_far = corners.first().is_none_or(|corner| (corner - here).norm() > FAR);
        if is_far || !perception.town.is_on_level(perception.place(), corners.place()) {
            continue;
        }
        let near = |actor: &&Actor| polygon::distance(corners, actor.pose.position()) <= NEAR;
        let mut users =
            perception.pedestrians.iter().filter(near).filter(|actor| perception.in_sight(actor)).peekable();
        if users.peek().is_none() {
            continue;
        }
        let Some((along, entry)) = entry(path, here, corners) else { continue };
        let uses = |actor: &Actor| {
            let local = entry.to_local(actor.pose.position());
            let outwards = actor.velocity.dot(&entry.left()) * local.y.signum();
            local.y.abs() <= ego.half.y + PASSED || outwards <= AT_REST
        };
        if along > ego.half.x && users.any(uses) && first.is_none_or(|first| along < first) {
            first = Some(along);
        }
    }
    first
}

/// Where the path enters a polygon: the distance along the path from abeam the ego (m), and the pose there.
fn entry(path: &Path, ego: Point, corners: &[Point]) -> Option<(f64, Pose)> {
    let mut points = path.points().map(|point| point.pose);
    let mut last = points.next()?;
    let mut along = -last.to_local(ego).x;
    for next in points {
        if polygon::contains(corners, next.position()) {
            return Some((along, last));
        }
        along += (next.position() - last.position()).norm();
        last = next;
    }
    None
}
