use super::{LaneId, RoadIndex};
use crate::geometry::Point;

/// A place on a lane's centre line. The [`Town`](super::Town) gives its pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    pub road: RoadIndex,
    /// The lane section within the road.
    pub section: u32,
    /// The lane within the section; never 0.
    pub lane: LaneId,
    /// Distance along the road's reference line from its start (m).
    pub s: f64,
}

impl Waypoint {
    /// Whether another place is on the same lane of the same section.
    pub fn is_on_lane_of(&self, other: &Self) -> bool {
        (self.road, self.section, self.lane) == (other.road, other.section, other.lane)
    }
}

/// A driving lane of one section outside junctions, on which an episode may start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneStretch {
    /// Where driving along it starts.
    pub start: Waypoint,
    /// Its length along the reference line (m).
    pub length: f64,
}

/// A place and, where that is known, the height of its ground (m). In a town with roads above each other it says which of them counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub point: Point,
    pub ground: Option<f64>,
}

impl Place {
    /// A place whose ground is this high (m).
    pub fn on(point: Point, ground: f64) -> Self {
        Self { point, ground: Some(ground) }
    }
}

impl From<Point> for Place {
    fn from(point: Point) -> Self {
        Self { point, ground: None }
    }
}
