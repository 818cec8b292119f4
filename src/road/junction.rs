use super::{LaneId, RoadEnd, RoadIndex};

/// One way through a junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// Its number, different from those of the junction's other connections. CARLA's order of the branches at a fork depends on it.
    pub id: u32,
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
