use rand::RngExt;

use super::SpawnError;
use base::choice;
use base::seed::Stream;
use base::signature::Distribution;
use road::geometry::{Pose, wrap_angle};
use road::{LaneFilter, LaneStretch, Town, Waypoint};

/// A concrete start of the ego and the first pedestrian.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Spawn {
    pub ego: Pose,
    /// Speed of the ego (m/s); 0 in a start that is drawn for a driver in its steady state, before the driver has driven.
    pub ego_speed: f64,
    pub pedestrian: Pose,
}

/// The rule for the ego's start.
#[derive(Debug, Clone, PartialEq)]
pub enum EgoStart {
    /// Anywhere on the driving lanes outside junctions, uniform in length.
    Anywhere,
    /// One of these poses, with equal probability.
    Poses(Vec<Pose>),
    /// Anywhere on these parts of lanes, uniform in length.
    Pieces(Vec<LanePiece>),
}

/// The speed of the ego at the start.
#[derive(Debug, Clone, PartialEq)]
pub enum EgoSpeed {
    /// The steady state of its driver, which has driven its lane alone up to the pose.
    Steady,
    /// Drawn (m/s); the driver starts at the pose.
    Drawn(Distribution),
}

/// A part of a driving lane, given by its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LanePiece {
    /// A pose near the middle of the lane and along it.
    pub from: Pose,
    /// Its length from its start, in driving direction (m).
    pub length: f64,
}

choice! {
    /// The stretches of road on which the ego may start.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum RoadShape {
        /// All.
        #[default]
        Any = "any",
        /// Stretches where the lane is straight for the next 10 m.
        Straight = "straight",
        /// Stretches where the lane bends.
        Bend = "bend",
    }
}

/// The distance ahead over which the shape of the road is measured (m).
pub const LOOK_AHEAD: f64 = 10.0;
/// A lane is straight if it turns by less than this over that length (rad).
const STRAIGHT: f64 = 0.05;

impl EgoStart {
    /// Draws a pose.
    pub(super) fn sample(&self, town: &Town, stream: &mut Stream) -> Pose {
        match self {
            Self::Poses(poses) => poses[stream.random_range(0..poses.len())],
            Self::Anywhere => anywhere(town, stream),
            Self::Pieces(pieces) => {
                let total: f64 = pieces.iter().map(|piece| piece.length).sum();
                let mut left = stream.random_range(0.0..1.0) * total;
                let last = pieces.len() - 1;
                let found = pieces[..last].iter().position(|piece| {
                    let here = left < piece.length;
                    if !here {
                        left -= piece.length;
                    }
                    here
                });
                let piece = &pieces[found.unwrap_or(last)];
                let lane = lane_of(town, &piece.from).expect("checked: the piece lies on a lane");
                town.pose(town.moved(lane, left.min(piece.length)))
            }
        }
    }

    /// Checks that every pose lies on a driving lane.
    ///
    /// # Errors
    /// The first pose that does not.
    pub(super) fn check(&self, town: &Town) -> Result<(), SpawnError> {
        match self {
            Self::Anywhere if town.driving_lanes().is_empty() => Err(SpawnError::NoLane),
            Self::Anywhere => Ok(()),
            Self::Poses(poses) => poses.iter().try_for_each(|pose| on_a_lane(town, pose).map(drop)),
            Self::Pieces(pieces) => pieces.iter().try_for_each(|piece| {
                let start = on_a_lane(town, &piece.from)?;
                let room = room_ahead(town, start);
                let (x, y, length) = (piece.from.x, piece.from.y, piece.length);
                if length > room { Err(SpawnError::ShortLane { x, y, length, room }) } else { Ok(()) }
            }),
        }
    }
}

impl RoadShape {
    /// Whether the road ahead of a pose has this shape.
    pub(super) fn admits(self, town: &Town, pose: &Pose) -> bool {
        let straight = || {
            let ahead = pose.to_world(road::geometry::Vector::new(LOOK_AHEAD, 0.0));
            let lane = town.nearest_lane(ahead, LaneFilter::Driving).map(|lane| town.pose(lane));
            lane.is_some_and(|there| {
                wrap_angle(there.yaw - pose.yaw).abs() < STRAIGHT && pose.to_local(there.position()).y.abs() < 0.5
            })
        };
        match self {
            Self::Any => true,
            Self::Straight => straight(),
            Self::Bend => !straight(),
        }
    }
}

/// The driving lane whose middle is nearest.
fn lane_of(town: &Town, pose: &Pose) -> Option<Waypoint> {
    town.lane_under(pose)
}

/// The length of the lane section ahead of a waypoint (m).
fn room_ahead(town: &Town, from: Waypoint) -> f64 {
    let same = |stretch: &&LaneStretch| {
        let start = stretch.start;
        (start.road, start.section, start.lane) == (from.road, from.section, from.lane)
    };
    town.driving_lanes().iter().find(same).map_or(0.0, |stretch| stretch.length - (from.s - stretch.start.s).abs())
}

/// Checks that a car can start at a pose: near the middle of a driving lane and about along it.
fn on_a_lane(town: &Town, pose: &Pose) -> Result<Waypoint, SpawnError> {
    let lane = lane_of(town, pose).ok_or(SpawnError::NoLane)?;
    let middle = town.pose(lane);
    let (apart, turned) = ((middle.position() - pose.position()).norm(), wrap_angle(middle.yaw - pose.yaw));
    if apart > town.lane_width(lane).max(2.0) || turned.abs() > std::f64::consts::FRAC_PI_2 {
        let (x, y, degrees) = (pose.x, pose.y, turned.to_degrees());
        return Err(SpawnError::OffLane { x, y, apart, degrees });
    }
    Ok(lane)
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
