//! Heeding stop and yield signs, for the drivers that know them.

use super::lane_keeping::Demand;
use super::{Path, Perception};
use road::{GiveWay, GiveWaySign};

/// At most this speed at the line of a yield sign (m/s): 7 km/h, walking speed.
///
/// # Source
/// German road traffic regulations (StVO), section 8 (2): who gives way shows by a moderate speed that they will wait. The figure is ours: the
/// walking speed of German courts, 4 to 7 km/h. The only other road users are pedestrians, so there is no car to wait for.
const WALKING: f64 = 7.0 / 3.6;
/// How far before the line the front stops (m) (assumed).
const BEFORE_LINE: f64 = 0.5;
/// A car that is slower than this (m/s), within this distance of where it should stop (m), has stopped (assumed).
const STANDING: (f64, f64) = (0.1, 2.5);
/// Signs beyond this distance are not looked at (m): the length of a path.
const FAR: f64 = 90.0;
/// Spacing of the points of a path along its lanes (m), and a little more.
const SPACING: f64 = 1.1;

/// The next stop or yield sign along a path that counts, with the way from the middle of the ego to its line (m, more than 0).
pub(super) fn next_sign(perception: &Perception<'_>, path: &Path) -> Option<(GiveWay, f64)> {
    let ahead = signs(perception, path).filter(|(_, _, along)| *along > 0.0);
    ahead.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(_, sign, along)| (sign.kind, along))
}

/// The signs along a path that count, each with its number and the way from the middle of the ego to its line (m).
fn signs<'a>(
    perception: &'a Perception<'_>,
    path: &'a Path,
) -> impl Iterator<Item = (usize, &'a GiveWaySign, f64)> + 'a {
    let here = perception.ego.pose.position();
    perception.town.give_way_signs.iter().enumerate().filter_map(move |(index, sign)| {
        let works = sign.has_light && !perception.lights.is_empty();
        let far = (perception.town.pose(sign.line).position() - here).norm_squared() > FAR * FAR;
        if works || far { None } else { Some((index, sign, along(perception, path, sign)?)) }
    })
}

/// Heeds the next sign along a path. At a stop sign the car stops with its front before the line, and goes on once it has stood.
///
/// # Source
/// Vienna Convention on Road Signs and Signals, annex 1, B 1 and B 2: give way; stop before you go on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GiveWayMemory {
    /// The sign at which the car has stopped, up to where its front passes the line.
    stopped: Option<usize>,
}

impl GiveWayMemory {
    /// What the next sign ahead demands; `None` if there is no sign or the driver has done what it demands.
    pub fn next(&mut self, perception: &Perception<'_>, path: &Path) -> Option<Demand> {
        let ego = &perception.ego;
        let (mut first, mut stopped) = (None, None);
        for (index, sign, along) in signs(perception, path) {
            let ahead = along - ego.half.x;
            if ahead <= 0.0 {
                continue;
            }
            let gap = (ahead - BEFORE_LINE).max(0.0);
            let stands = ego.speed() < STANDING.0 && gap < STANDING.1;
            if sign.kind == GiveWay::Stop && (self.stopped == Some(index) || stands) {
                stopped = Some(index);
                continue;
            }
            let demand = match sign.kind {
                GiveWay::Stop => Demand { gap, speed: 0.0 },
                GiveWay::Yield => Demand { gap: ahead, speed: WALKING },
            };
            if first.is_none_or(|first: Demand| demand.gap < first.gap) {
                first = Some(demand);
            }
        }
        self.stopped = stopped;
        first
    }
}

/// The distance along the path from abeam the middle of the ego to the line of a sign (m); `None` if the path does not lead over it.
fn along(perception: &Perception<'_>, path: &Path, sign: &GiveWaySign) -> Option<f64> {
    let forward = perception.town.roads.get(sign.line.road.0 as usize)?.is_forward(sign.line.lane);
    let mut along = 0.0;
    let mut last: Option<&road::geometry::Pose> = None;
    for point in path.points() {
        along = match last {
            // The first point is the nearest to the ego, not the one abeam it.
            None => -point.pose.to_local(perception.ego.pose.position()).x,
            Some(last) => along + (point.pose.position() - last.position()).norm(),
        };
        last = Some(&point.pose);
        let left = (sign.line.s - point.waypoint.s) * if forward { 1.0 } else { -1.0 };
        if point.waypoint.is_on_lane_of(&sign.line) && (-SPACING..SPACING).contains(&left) {
            return Some(along + left);
        }
    }
    None
}
