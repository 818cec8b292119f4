use std::collections::VecDeque;

use super::carla_frame::{Direction, Location};
use super::release::ReleaseTraits;
use crate::road::{ForkRule, RandomWalk, RoadOption, RoutePoint, Town, Waypoint};
use crate::seed::Stream;

/// A walk without destination is refilled by so many points when there are fewer.
const REFILL: usize = 100;
/// Points in the old planner's buffer.
const BUFFER: usize = 5;
/// Points closer than this are reached (m), at rest.
const REACHED: f64 = 3.0;
/// So much more at speed (s).
const REACHED_TIME: f64 = 0.5;
/// The last point is reached only so close by (m).
const LAST_REACHED: f64 = 1.0;

/// A point of the route, with what the obstacle test asks of it over and over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlannedPoint {
    pub point: RoutePoint,
    pub location: Location,
    pub right: Direction,
}

impl PlannedPoint {
    fn new(point: RoutePoint) -> Self {
        Self { point, location: Location::new(point.pose.position(), 0.0), right: Direction::new(&point.pose).right() }
    }
}

/// The queue of points ahead: it drops what is reached and names the point to steer for.
#[derive(Debug, Clone, Default)]
pub(super) struct Planner {
    queue: VecDeque<PlannedPoint>,
    buffer: VecDeque<PlannedPoint>,
    walk: RandomWalk,
    stream: Option<Stream>,
}

impl Planner {
    /// Begins a walk without destination at a lane; without one, there is no way to go.
    pub fn wander(
        &mut self,
        traits: &ReleaseTraits,
        forks: ForkRule,
        town: &Town,
        start: Option<Waypoint>,
        stream: Stream,
    ) {
        self.clear();
        self.walk = RandomWalk::new(forks);
        self.queue.reserve(2 * REFILL);
        self.buffer.reserve(BUFFER);
        self.stream = Some(stream);
        let start = start.map(|start| PlannedPoint::new(RoutePoint::new(town, start, RoadOption::LaneFollow)));
        self.queue.extend(start);
        if traits.buffered_planner {
            self.refill(town, traits.step);
            self.fill_buffer();
        }
    }

    /// Follows a given route and stops at its end.
    pub fn follow(&mut self, traits: &ReleaseTraits, route: impl IntoIterator<Item = RoutePoint>) {
        self.clear();
        self.queue.extend(route.into_iter().map(PlannedPoint::new));
        if traits.buffered_planner {
            self.fill_buffer();
        }
    }

    /// The points ahead as the obstacle test sees them.
    pub fn points(&self) -> impl ExactSizeIterator<Item = &PlannedPoint> {
        self.queue.iter()
    }

    /// The point so many steps ahead, or the last one.
    pub fn ahead(&self, steps: usize) -> Option<&PlannedPoint> {
        self.queue.get(steps).or_else(|| self.queue.back())
    }

    /// Drops the reached points and gives the one to steer for; none at the end of the route.
    ///
    /// The old planner first gives the point and then drops the reached ones, so it looks at them once more.
    pub fn run(&mut self, traits: &ReleaseTraits, town: &Town, ego: Location, speed: f64) -> Option<Location> {
        self.refill(town, traits.step);
        if traits.buffered_planner {
            return self.run_buffered(ego);
        }
        let reached = REACHED + REACHED_TIME * speed;
        while let Some(head) = self.queue.front() {
            let limit = if self.queue.len() == 1 { LAST_REACHED } else { reached };
            if ego.distance(head.location) >= limit {
                return Some(head.location);
            }
            self.queue.pop_front();
        }
        None
    }

    fn run_buffered(&mut self, ego: Location) -> Option<Location> {
        if self.queue.is_empty() {
            return None;
        }
        if self.buffer.is_empty() {
            self.fill_buffer();
        }
        let target = self.buffer.front()?.location;
        let reached = self.buffer.iter().rposition(|point| {
            let (x, y) = ego.offset(point.location);
            (x * x + y * y).sqrt() < REACHED
        });
        self.buffer.drain(..reached.map_or(0, |last| last + 1));
        Some(target)
    }

    fn fill_buffer(&mut self) {
        let moved = BUFFER.min(self.queue.len());
        self.buffer.extend(self.queue.drain(..moved));
    }

    fn refill(&mut self, town: &Town, step: f64) {
        let Some(stream) = &mut self.stream else { return };
        if self.queue.len() >= REFILL {
            return;
        }
        for _ in 0..REFILL {
            let Some(last) = self.queue.back() else { return };
            let Some(next) = self.walk.next(town, &last.point, step, stream) else { return };
            self.queue.push_back(PlannedPoint::new(next));
        }
    }

    fn clear(&mut self) {
        self.queue.clear();
        self.buffer.clear();
        self.stream = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Release;
    use super::*;
    use crate::geometry::{Point, Pose};
    use crate::road::{RoadIndex, TownParts};

    fn nowhere() -> Town {
        Town::new(TownParts::default())
    }

    fn straight(points: u32, step: f64) -> impl Iterator<Item = RoutePoint> {
        (0..points).map(move |i| RoutePoint {
            waypoint: Waypoint { road: RoadIndex(0), section: 0, lane: -1, s: f64::from(i) * step },
            pose: Pose::new(f64::from(i) * step, 0.0, 0.0),
            lane_width: 4.0,
            is_junction: false,
            option: RoadOption::LaneFollow,
        })
    }

    fn at(x: f64) -> Location {
        Location::new(Point::new(x, 0.0), 0.0)
    }

    #[test]
    fn points_within_three_metres_and_half_a_second_are_dropped() {
        let (town, traits) = (nowhere(), Release::V0_9_15.traits());
        let mut planner = Planner::default();
        planner.follow(&traits, straight(20, 2.0));
        assert_eq!(planner.run(&traits, &town, at(0.0), 0.0), Some(at(4.0)), "at rest");
        assert_eq!(planner.run(&traits, &town, at(0.0), 7.5), Some(at(8.0)), "6.75 m at 7.5 m/s");
        assert_eq!(planner.points().len(), 16);
    }

    #[test]
    fn only_the_head_is_compared() {
        let (town, traits) = (nowhere(), Release::V0_9_15.traits());
        let mut planner = Planner::default();
        planner.follow(&traits, straight(20, 2.0));
        assert_eq!(planner.run(&traits, &town, at(20.0), 0.0), Some(at(0.0)), "points far behind the ego stay");
    }

    #[test]
    fn the_last_point_is_kept_until_very_close() {
        let (town, traits) = (nowhere(), Release::V0_9_15.traits());
        let mut planner = Planner::default();
        planner.follow(&traits, straight(3, 2.0));
        assert_eq!(planner.run(&traits, &town, at(2.9), 5.0), Some(at(4.0)));
        assert_eq!(planner.run(&traits, &town, at(3.1), 5.0), None);
        assert_eq!(planner.run(&traits, &town, at(3.1), 5.0), None);
    }

    #[test]
    fn the_buffered_planner_drops_after_steering_and_stops_with_an_empty_queue() {
        let (town, traits) = (nowhere(), Release::V0_9_11.traits());
        let mut planner = Planner::default();
        planner.follow(&traits, straight(7, 2.0));
        assert_eq!(planner.points().len(), 2, "five of seven are in the buffer");
        assert_eq!(planner.run(&traits, &town, at(3.0), 9.0), Some(at(0.0)));
        assert_eq!(planner.run(&traits, &town, at(6.0), 9.0), Some(at(6.0)), "0, 2 and 4 were dropped");
        assert_eq!(planner.run(&traits, &town, at(6.5), 9.0), Some(at(10.0)), "the buffer is filled again");
        assert_eq!(planner.run(&traits, &town, at(6.5), 9.0), None, "though the buffer has points");
    }

    #[test]
    fn steps_beyond_the_end_give_the_last_point() {
        let mut planner = Planner::default();
        assert_eq!(planner.ahead(3), None);
        planner.follow(&Release::V0_9_15.traits(), straight(3, 2.0));
        assert_eq!(planner.ahead(1).map(|point| point.location), Some(at(2.0)));
        assert_eq!(planner.ahead(9).map(|point| point.location), Some(at(4.0)));
    }
}
