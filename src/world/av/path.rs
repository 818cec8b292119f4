use std::collections::VecDeque;

use super::Perception;
use base::seed::Stream;
use road::geometry::{Point, Pose, Vector, wrap_angle};
use road::{ForkRule, RandomWalk, RoadOption, RoutePoint, Town};

/// Spacing of the points (m), along the reference line.
const STEP: f64 = 1.0;
/// The length of a known path (points).
pub(super) const HORIZON: usize = 80;

/// The path ahead of a car that drives through a town without a destination, for our own policies.
#[derive(Debug, Clone)]
pub struct Path {
    points: VecDeque<RoutePoint>,
    /// From each point to the next.
    steps: VecDeque<Step>,
    /// The first point, the unit vector to the second, and the number of the last point before the line through them is left.
    straight: Option<(Point, Vector, usize)>,
    walk: RandomWalk,
    stream: Option<Stream>,
}

/// How far beside that line a point is still on it (m).
const BEND: f64 = 0.1;

/// The way from a point of a path to the next: its length (m), and the change of heading without its sign (rad).
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub length: f64,
    pub turn: f64,
}

impl Default for Path {
    fn default() -> Self {
        Self {
            points: VecDeque::with_capacity(HORIZON + 1),
            steps: VecDeque::with_capacity(HORIZON + 1),
            straight: None,
            walk: RandomWalk::new(ForkRule::AnyBranch),
            stream: None,
        }
    }
}

impl Path {
    /// Starts on the given route, or on the driving lane nearest to the ego.
    pub fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.points.clear();
        self.steps.clear();
        self.straight = None;
        self.stream = Some(stream);
        self.walk.take(perception.route);
        self.points.extend(
            perception.start_lane().map(|start| RoutePoint::new(perception.town, start, RoadOption::LaneFollow)),
        );
        self.extend(perception.town);
    }

    /// Draws the turns that are not known yet from another stream.
    pub fn reseed(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    /// Drops the points behind the ego and adds points ahead.
    pub fn advance(&mut self, perception: &Perception<'_>) {
        let here = perception.ego.pose.position();
        while self.points.len() > 1 && nearer(&self.points[1].pose, &self.points[0].pose, here) {
            self.points.pop_front();
            self.steps.pop_front();
            self.straight = None;
        }
        self.extend(perception.town);
    }

    /// The points ahead, the first one abeam the ego.
    pub fn points(&self) -> impl ExactSizeIterator<Item = &RoutePoint> {
        self.points.iter()
    }

    /// The way from each point to the next.
    pub(super) fn steps(&self) -> impl Iterator<Item = &Step> {
        self.steps.iter()
    }

    /// The point with this number.
    pub fn point(&self, number: usize) -> &RoutePoint {
        &self.points[number]
    }

    /// The first point at least this far (m) from a place, or the last one.
    pub fn ahead(&self, from: Point, distance: f64) -> Option<&RoutePoint> {
        let far = self.points.iter().find(|point| (point.pose.position() - from).norm() >= distance);
        far.or_else(|| self.points.back())
    }

    /// Whether a car at this place has passed the end of the road.
    pub fn is_over(&self, place: Point) -> bool {
        self.points.len() == 1 && self.points[0].pose.to_local(place).x > 0.0
    }

    /// Whether the road ends within the path.
    pub fn ends(&self) -> bool {
        self.points.len() < HORIZON
    }

    /// Prepares [`Path::first_near`], which finds the same without it, and not as fast.
    pub(super) fn find_straight(&mut self) {
        let Some(next) = self.points.get(1).filter(|_| self.straight.is_none()) else { return };
        let start = self.points[0].pose.position();
        let ahead = (next.pose.position() - start).try_normalize(1e-9).unwrap_or_default();
        let is_off = |point: &RoutePoint| {
            let way = point.pose.position() - start;
            ahead.perp(&way).abs() > BEND || ahead.dot(&way) < 0.0
        };
        let straight = self.points.iter().position(is_off).unwrap_or(self.points.len());
        self.straight = Some((start, ahead, straight - 1));
    }

    /// The number of a point before which no chord, with a little overlap, is as near to a place as this beside it (m), or behind it (m).
    pub(super) fn first_near(&self, place: Point, beside: f64, behind: f64) -> usize {
        let Some((start, ahead, last)) = self.straight else { return 0 };
        let offset = place - start;
        if ahead.perp(&offset).abs() > beside + 2.0 * BEND || ahead.dot(&offset) < -behind { last } else { 0 }
    }

    fn extend(&mut self, town: &Town) {
        let Some(stream) = &mut self.stream else { return };
        while self.points.len() < HORIZON {
            let Some(last) = self.points.back() else { return };
            let Some(next) = self.walk.next(town, last, STEP, stream) else { return };
            self.steps.push_back(Step {
                length: (next.pose.position() - last.pose.position()).norm(),
                turn: wrap_angle(next.pose.yaw - last.pose.yaw).abs(),
            });
            self.points.push_back(next);
        }
    }
}

fn nearer(a: &Pose, b: &Pose, place: Point) -> bool {
    (a.position() - place).norm_squared() <= (b.position() - place).norm_squared()
}
