use super::RoadIndex;
use crate::geometry::{OrientedBox, Pose};

/// A speed limit that a vehicle takes over when its box touches the sign's trigger box.
///
/// # Source
/// CARLA `Traffic/SpeedLimitComponent.cpp`: a square of half size 0.35 × lane width on every driving lane the sign applies to.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedSign {
    /// The limit (m/s).
    pub limit: f64,
    /// Where it takes effect.
    pub trigger: OrientedBox,
}

/// A traffic light on an approach to a junction.
///
/// # Source
/// CARLA `Traffic/TrafficLightComponent.cpp`: the trigger box lies on the approach lane, centre 3.0 m before its end, half
/// length 1.5 m, half width a quarter of the lane's.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficLight {
    /// The id of its signal in the map. A signal for several lanes has a light on each of them.
    pub signal: String,
    /// Lights of one group follow one cycle.
    pub group: u32,
    /// Its turn within the group: 0, 1, ….
    pub turn: u32,
    /// How many turns the group has.
    pub turns: u32,
    /// The road of the approach lane.
    pub road: RoadIndex,
    /// Centre of the trigger box, heading along the approach lane.
    pub stop: Pose,
    /// Where a vehicle is affected.
    pub trigger: OrientedBox,
}
