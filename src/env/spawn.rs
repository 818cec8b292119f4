//! How an episode begins: a logical scene (ranges) becomes a concrete one.
//!
//! The sector about the ego is sampled directly, so nothing is rejected but places inside obstacles.

use rand::RngExt;

use super::FirstHeading;
use crate::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use crate::road::{LaneFilter, LaneStretch, Town};
use crate::seed::Stream;

/// What is uniform when a place in the sector is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The distance: places near the ego are denser.
    Range,
    /// The ground: as many places a square metre everywhere in the sector.
    Area,
}

/// Where the ego begins.
#[derive(Debug, Clone, PartialEq)]
pub enum EgoStart {
    /// Anywhere on the driving lanes outside junctions, uniform in length.
    Anywhere,
    /// One of these poses, each as likely.
    Poses(Vec<Pose>),
}

/// How an episode begins.
#[derive(Debug, Clone, PartialEq)]
pub struct SpawnRule {
    /// Bearing of the pedestrian from the ego's heading, positive to the left (rad).
    pub bearing: (f64, f64),
    /// Distance between the centres (m).
    pub distance: (f64, f64),
    /// What is uniform.
    pub measure: Measure,
    /// Least distance from the pedestrian's centre to an obstacle (m).
    pub clearance: f64,
    /// Where the ego begins.
    pub ego_start: EgoStart,
    /// How fast the ego begins (m/s).
    pub ego_speed: (f64, f64),
}

/// A concrete beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spawn {
    /// Pose of the ego.
    pub ego: Pose,
    /// Speed of the ego (m/s).
    pub ego_speed: f64,
    /// Pose of the pedestrian.
    pub pedestrian: Pose,
}

/// Why nobody can be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpawnError {
    /// The town has no lane to begin on.
    #[error("the town has no driving lane outside junctions")]
    NoLane,
    /// A listed pose of the ego lies on no lane, or against it.
    #[error(
        "the pose at ({x} m, {y} m) is {apart:.1} m from the nearest driving lane and turned by {degrees:.0} degrees from it"
    )]
    OffLane {
        /// Where (m).
        x: f64,
        /// Where (m).
        y: f64,
        /// Distance from the middle of the nearest lane (m).
        apart: f64,
        /// Angle from its heading to the lane's (degrees).
        degrees: f64,
    },
    /// Too few places are free of obstacles.
    #[error(
        "only {accepted} of {tried} places of the sector are {clearance} m clear of obstacles (constraint `clearance`)"
    )]
    Crowded {
        /// Places that were free.
        accepted: u32,
        /// Places that were tried.
        tried: u32,
        /// The clearance asked for (m).
        clearance: f64,
    },
}

/// Places that [`SpawnRule::probe`] tries for each listed pose of the ego, or in all.
const PROBES: u32 = 400;
/// A probe passes when one place in so many is free.
const ONE_IN: u32 = 100;
/// Places that one [`SpawnRule::sample`] tries around one pose of the ego; then the ego moves on.
const TRIES: u32 = 1000;
/// Poses of the ego that one [`SpawnRule::sample`] tries.
const EGOS: u32 = 1000;

impl SpawnRule {
    /// Makes sure that the rule can place somebody: at least one place in a hundred must be free, around every pose that
    /// is listed.
    ///
    /// # Errors
    /// Says what stands in the way.
    pub fn probe(&self, town: &Town, obstacles: &Obstacles, stream: &mut Stream) -> Result<(), SpawnError> {
        let around = |ego: &mut dyn FnMut(&mut Stream) -> Pose, stream: &mut Stream| {
            let free = |_: &u32| {
                let ego = ego(stream);
                self.place(&ego, obstacles, stream).is_some()
            };
            let accepted = (0..PROBES).filter(free).count() as u32;
            let crowded = SpawnError::Crowded { accepted, tried: PROBES, clearance: self.clearance };
            if accepted * ONE_IN < PROBES { Err(crowded) } else { Ok(()) }
        };
        match &self.ego_start {
            EgoStart::Anywhere if town.driving_lanes().is_empty() => Err(SpawnError::NoLane),
            EgoStart::Anywhere => around(&mut |stream| anywhere(town, stream), stream),
            EgoStart::Poses(poses) => poses.iter().try_for_each(|pose| {
                on_a_lane(town, pose)?;
                around(&mut |_| *pose, stream)
            }),
        }
    }

    /// Draws a beginning; the rule must have passed [`SpawnRule::probe`].
    ///
    /// The ego's pose is drawn once, so crowded places are as likely as free ones; only where not one of a thousand
    /// places is free it is drawn again.
    pub fn sample(&self, town: &Town, obstacles: &Obstacles, first: FirstHeading, stream: &mut Stream) -> Spawn {
        let beginning = (0..EGOS).find_map(|_| {
            let ego = match &self.ego_start {
                EgoStart::Poses(poses) => poses[stream.random_range(0..poses.len())],
                EgoStart::Anywhere => anywhere(town, stream),
            };
            let place = (0..TRIES).find_map(|_| self.place(&ego, obstacles, stream))?;
            Some((ego, place))
        });
        let (ego, place) = beginning.expect("checked: the probe found free places");
        let turn = stream.random_range(-std::f64::consts::PI..std::f64::consts::PI);
        let yaw = match first {
            FirstHeading::Random => wrap_angle(turn),
            FirstHeading::TowardsEgo => libm::atan2(ego.y - place.y, ego.x - place.x),
        };
        let ego_speed = between(self.ego_speed, stream);
        Spawn { ego, ego_speed, pedestrian: Pose::new(place.x, place.y, yaw) }
    }

    /// Draws a place in the sector about the ego; none when it is not clear of obstacles.
    fn place(&self, ego: &Pose, obstacles: &Obstacles, stream: &mut Stream) -> Option<Point> {
        let bearing = between(self.bearing, stream);
        let (near, far) = self.distance;
        let distance = match self.measure {
            Measure::Range => between((near, far), stream),
            Measure::Area => between((near * near, far * far), stream).sqrt(),
        };
        let place = ego.to_world(Vector::new(distance * libm::cos(bearing), distance * libm::sin(bearing)));
        (obstacles.clearance(place, self.clearance) >= self.clearance).then_some(place)
    }
}

/// Makes sure that a car can begin at a pose: near the middle of a driving lane and about along it.
fn on_a_lane(town: &Town, pose: &Pose) -> Result<(), SpawnError> {
    let lane = town.nearest_lane(pose.position(), LaneFilter::Driving).ok_or(SpawnError::NoLane)?;
    let middle = town.pose(lane);
    let (apart, turned) = ((middle.position() - pose.position()).norm(), wrap_angle(middle.yaw - pose.yaw));
    if apart > town.lane_width(lane).max(2.0) || turned.abs() > std::f64::consts::FRAC_PI_2 {
        let (x, y, degrees) = (pose.x, pose.y, turned.to_degrees());
        return Err(SpawnError::OffLane { x, y, apart, degrees });
    }
    Ok(())
}

fn anywhere(town: &Town, stream: &mut Stream) -> Pose {
    let lanes = town.driving_lanes();
    let total: f64 = lanes.iter().map(|lane: &LaneStretch| lane.length).sum();
    let mut left = stream.random_range(0.0..total);
    let last = lanes.len() - 1;
    let index = lanes[..last].iter().position(|lane| {
        let here = left < lane.length;
        if !here {
            left -= lane.length;
        }
        here
    });
    let stretch = &lanes[index.unwrap_or(last)];
    town.pose(town.along(stretch, left.min(stretch.length)))
}

fn between((low, high): (f64, f64), stream: &mut Stream) -> f64 {
    low + (high - low) * stream.random::<f64>()
}
