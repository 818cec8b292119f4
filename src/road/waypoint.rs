use super::{LaneId, RoadIndex};

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
