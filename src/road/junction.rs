use super::{LaneId, RoadEnd, RoadIndex};

/// One way through a junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// The road that leads into the junction.
    pub incoming: RoadIndex,
    /// The road inside the junction.
    pub connecting: RoadIndex,
    /// The end of the connecting road at which a car enters it.
    pub contact: RoadEnd,
    /// Pairs of lanes: of the incoming road, of the connecting road.
    pub lane_links: Vec<(LaneId, LaneId)>,
}

/// A place where roads meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Junction {
    /// Its number in the file.
    pub id: u32,
    /// Its name, often empty.
    pub name: String,
    /// The ways through it.
    pub connections: Vec<Connection>,
}
