use super::{
    Junction, LaneIndex, LaneKind, LaneStretch, Road, SpeedSign, TrafficLight, Waypoint, lane_index, opendrive::OpenDriveWarning,
};
use crate::geometry::{OrientedBox, Point, Pose};

/// What a town is made of, before it is indexed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TownParts {
    /// Its name.
    pub name: String,
    /// The roads.
    pub roads: Vec<Road>,
    /// The junctions.
    pub junctions: Vec<Junction>,
    /// Signs that set a speed limit.
    pub speed_signs: Vec<SpeedSign>,
    /// Traffic lights.
    pub traffic_lights: Vec<TrafficLight>,
    /// Buildings, walls, trees: whatever blocks walkers and sight.
    pub obstacles: Vec<OrientedBox>,
    /// What the reader of a file had to skip or guess.
    pub warnings: Vec<OpenDriveWarning>,
}

/// A road network with everything that stands beside it, indexed for the questions a simulation asks.
#[derive(Debug)]
pub struct Town {
    /// Its name.
    pub name: String,
    /// The roads.
    pub roads: Vec<Road>,
    /// The junctions.
    pub junctions: Vec<Junction>,
    /// Signs that set a speed limit.
    pub speed_signs: Vec<SpeedSign>,
    /// Traffic lights.
    pub traffic_lights: Vec<TrafficLight>,
    /// Buildings, walls, trees: whatever blocks walkers and sight.
    pub obstacles: Vec<OrientedBox>,
    /// What the reader of a file had to skip or guess.
    pub warnings: Vec<OpenDriveWarning>,
    driving_lanes: Vec<LaneStretch>,
    index: LaneIndex,
}
