use std::collections::VecDeque;
use std::sync::Arc;

use rand::RngExt;

use super::carla_frame::{Direction, Location};
use super::release::ReleaseTraits;
use super::way_finding::{AtDestination, WayFinding};
use base::seed::{Seed, Stream};
use road::geometry::Point;
use road::{ForkRule, RandomWalk, RoadOption, RoutePlanner, RoutePoint, Town, Waypoint};

/// A walk without destination is refilled by this number of points when fewer are left.
const REFILL: usize = 100;
/// The maximum number of destinations that are drawn before the agent gives up.
const DRAWS: u32 = 100;
/// The maximum number of points of a given route.
const MAX_GIVEN: usize = 4096;
/// Points in the old planner's buffer.
const BUFFER: usize = 5;
/// Points within this distance are reached (m), at rest.
const REACHED: f64 = 3.0;
/// The increase of that distance with the speed (s).
const REACHED_TIME: f64 = 0.5;
/// The last point is reached within this distance (m).
const LAST_REACHED: f64 = 1.0;

/// A point of the route, with the values that the obstacle test needs repeatedly.
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

/// The queue of points ahead: it drops reached points and gives the point to steer for.
#[derive(Debug, Clone, Default)]
pub(super) struct Planner {
    queue: VecDeque<PlannedPoint>,
    buffer: VecDeque<PlannedPoint>,
    source: Source,
    /// The last place that it steered for.
    target: Option<Point>,
}

/// The source of more points.
#[derive(Debug, Clone, Default)]
enum Source {
    /// None: the route ends.
    #[default]
    None,
    Walk {
        walk: RandomWalk,
        stream: Stream,
    },
    Destinations {
        routes: Arc<RoutePlanner>,
        stream: Stream,
    },
}

impl Planner {
    /// Draws the turns or destinations that are not known yet from another stream.
    pub fn reseed(&mut self, fresh: Stream) {
        if let Source::Walk { stream, .. } | Source::Destinations { stream, .. } = &mut self.source {
            *stream = fresh;
        }
    }

    /// Starts at a lane: along the given lanes if there are any, and then to find its own way. Without a start there is no way.
    pub fn begin(
        &mut self,
        traits: &ReleaseTraits,
        way: WayFinding,
        town: &Town,
        start: Option<Waypoint>,
        lanes: &[Waypoint],
        mut stream: Stream,
    ) {
        self.clear();
        self.queue.reserve(2 * REFILL);
        self.buffer.reserve(BUFFER);
        let start = start.map(|start| RoutePoint::new(town, start, RoadOption::LaneFollow));
        self.target = start.map(|start| start.pose.position());
        match way {
            WayFinding::Wander(forks) => {
                let mut walk = RandomWalk::new(forks);
                walk.take(lanes);
                self.source = Source::Walk { walk, stream };
                self.queue.extend(start.map(PlannedPoint::new));
                if traits.buffered_planner {
                    self.extend(traits, town);
                    self.fill_buffer();
                }
            }
            WayFinding::Destination(at_destination) => {
                let routes = town.route_planner(traits.step);
                if let (Some(start), Some(end)) = (start, lanes.last()) {
                    self.take(traits, town, start, lanes, *end);
                }
                let found = self.plan(traits, town, &routes, &mut stream);
                if found && at_destination == AtDestination::Next {
                    self.source = Source::Destinations { routes, stream };
                }
            }
        }
    }

    /// Takes the given lanes up to the end of the route, from where a destination is planned to.
    fn take(&mut self, traits: &ReleaseTraits, town: &Town, start: RoutePoint, lanes: &[Waypoint], end: Waypoint) {
        let mut walk = RandomWalk::new(ForkRule::AnyBranch);
        walk.take(lanes);
        let reached = |place: &Waypoint| place.is_on_lane_of(&end) && (place.s - end.s) * f64::from(end.lane) <= 0.0;
        // Every fork on the way is given, so nothing is drawn.
        let mut unused = Seed::root(0).stream();
        let mut point = Some(start);
        while let Some(here) = point.filter(|here| !reached(&here.waypoint) && self.queue.len() < MAX_GIVEN) {
            self.queue.push_back(PlannedPoint::new(here));
            point = walk.next(town, &here, traits.step, &mut unused);
        }
        self.target = Some(town.pose(end).position());
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

    /// The point this number of steps ahead, or the last one.
    pub fn ahead(&self, steps: usize) -> Option<&PlannedPoint> {
        self.queue.get(steps).or_else(|| self.queue.back())
    }

    /// Drops the reached points and returns the one to steer for; `None` at the end of the route.
    ///
    /// The old planner first returns the point and then drops the reached ones, so the reached points are checked once more.
    pub fn run(&mut self, traits: &ReleaseTraits, town: &Town, ego: Location, speed: f64) -> Option<Location> {
        self.extend(traits, town);
        if traits.buffered_planner {
            return self.run_buffered(ego);
        }
        let reached = REACHED + REACHED_TIME * speed;
        while let Some(head) = self.queue.front() {
            let limit = if self.queue.len() == 1 { LAST_REACHED } else { reached };
            if ego.distance(head.location) >= limit {
                self.target = Some(head.point.pose.position());
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
        let head = self.buffer.front()?;
        let target = head.location;
        self.target = Some(head.point.pose.position());
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

    /// Gets more points when needed: a walk always has some points ahead, and a destination is drawn on arrival.
    fn extend(&mut self, traits: &ReleaseTraits, town: &Town) {
        match &mut self.source {
            Source::Walk { walk, stream } if self.queue.len() < REFILL => {
                for _ in 0..REFILL {
                    let Some(last) = self.queue.back() else { return };
                    let Some(next) = walk.next(town, &last.point, traits.step, stream) else { return };
                    self.queue.push_back(PlannedPoint::new(next));
                }
            }
            Source::Destinations { .. } if self.queue.is_empty() => {
                // The source is taken out and put back, since planning needs the rest of the planner.
                if let Source::Destinations { routes, mut stream } = std::mem::take(&mut self.source)
                    && self.plan(traits, town, &routes, &mut stream)
                {
                    self.source = Source::Destinations { routes, stream };
                }
            }
            _ => {}
        }
    }

    /// Draws a destination and plans to it from the place last steered for. A destination is drawn again if it cannot be reached, or
    /// if it lies behind on the same lane, where CARLA's route would be a single point. Returns whether one was found.
    fn plan(&mut self, traits: &ReleaseTraits, town: &Town, routes: &RoutePlanner, stream: &mut Stream) -> bool {
        let (Some(from), destinations) = (self.target, routes.destinations()) else { return false };
        if destinations.is_empty() {
            return false;
        }
        for _ in 0..DRAWS {
            let to = town.pose(destinations[stream.random_range(0..destinations.len())]).position();
            if let Some(route) = routes.trace(town, from, to).filter(|route| route.len() > 1) {
                self.buffer.clear();
                self.queue.extend(route.into_iter().map(PlannedPoint::new));
                if traits.buffered_planner {
                    self.fill_buffer();
                }
                return true;
            }
        }
        false
    }

    fn clear(&mut self) {
        self.queue.clear();
        self.buffer.clear();
        self.source = Source::None;
        self.target = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Release;
    use super::*;
    use base::seed::Seed;
    use road::geometry::Pose;
    use road::{RoadIndex, TownParts};

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

    /// A block with one street around it.
    fn block() -> Town {
        use road::design::{Carriageway, Node, Street, TownDesign};
        let node = |(x, y)| Node { name: String::new(), position: Point::new(x, y), lights: false };
        let street =
            |nodes| Street { name: String::new(), nodes, speed_limit: None, carriageway: Carriageway::default() };
        let nodes = [(0.0, 0.0), (90.0, 0.0), (180.0, 0.0), (180.0, 80.0), (90.0, 80.0), (0.0, 80.0)];
        let design = TownDesign {
            nodes: nodes.into_iter().map(node).collect(),
            streets: vec![street(vec![0, 1, 2, 3, 4, 5, 0]), street(vec![1, 4])],
            ..TownDesign::default()
        };
        Town::new(design.build().unwrap())
    }

    /// Drives by jumping from point to point; returns the lengths of the routes between arrivals.
    fn drive(town: &Town, traits: &ReleaseTraits, at: AtDestination, seed: u64, ticks: u32) -> (Vec<usize>, Location) {
        let start = town.generate_waypoints(2.0)[3];
        let mut planner = Planner::default();
        planner.begin(traits, WayFinding::Destination(at), town, Some(start), &[], Seed::root(seed).stream());
        let (mut here, mut lengths, mut steps) = (Location::new(town.pose(start).position(), 0.0), Vec::new(), 0);
        for _ in 0..ticks {
            match planner.run(traits, town, here, 0.0) {
                Some(target) => {
                    assert!(here.distance(target) < 14.0, "the next route begins where the last one ended");
                    here = target;
                    steps += 1;
                }
                None => {
                    lengths.push(steps);
                    steps = 0;
                }
            }
        }
        (lengths, here)
    }

    #[test]
    fn destination_follows_destination() {
        let town = block();
        for release in Release::ALL {
            let traits = release.traits();
            let way = drive(&town, &traits, AtDestination::Next, 1, 2000);
            // The old planner gets the next route before the car stands.
            let arrivals = if traits.buffered_planner { 0..=0 } else { 10..=200 };
            assert!(arrivals.contains(&way.0.len()), "{} arrivals of {}", way.0.len(), release.name());
            assert!(way.0.iter().all(|steps| *steps > 0), "a single tick of standing: {:?}", way.0);
            assert_ne!(way, drive(&town, &traits, AtDestination::Next, 2, 2000), "another stream, other ways");
            assert_eq!(way, drive(&town, &traits, AtDestination::Next, 1, 2000));
        }
    }

    #[test]
    fn at_the_only_destination_it_stays() {
        let town = block();
        let (lengths, here) = drive(&town, &Release::V0_9_15.traits(), AtDestination::Stop, 1, 2000);
        assert!(lengths[0] > 2 && lengths[1..].iter().all(|steps| *steps == 0), "{lengths:?}");
        assert_eq!(here, drive(&town, &Release::V0_9_15.traits(), AtDestination::Stop, 1, 500).1);
    }

    #[test]
    fn without_a_lane_there_is_no_way_to_go() {
        let (town, traits) = (nowhere(), Release::V0_9_15.traits());
        let mut planner = Planner::default();
        let way = WayFinding::Destination(AtDestination::Next);
        planner.begin(&traits, way, &town, None, &[], Seed::root(1).stream());
        assert_eq!(planner.run(&traits, &town, at(0.0), 0.0), None);
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
