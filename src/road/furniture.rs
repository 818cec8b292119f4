use std::ops::Deref;

use super::{Place, RoadIndex, Waypoint};
use crate::geometry::{OrientedBox, Point, Pose};
use base::choice;

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

choice! {
    /// What a sign demands of drivers that give way, the stricter one first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum GiveWay {
        /// To stand at the line before they go on.
        Stop = "stop",
        /// To be slow at the line.
        Yield = "yield",
    }
}

impl GiveWay {
    /// The demand of a signal type of OpenDRIVE.
    pub fn of_signal(kind: &str) -> Option<Self> {
        match kind {
            "206" => Some(Self::Stop),
            "205" => Some(Self::Yield),
            _ => None,
        }
    }
}

/// A stop or yield sign over one lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GiveWaySign {
    pub kind: GiveWay,
    /// The place on the lane that the front of a car must not pass before it has stopped, or slowed down.
    pub line: Waypoint,
    /// Whether the lane has a traffic light there. While that works, the sign does not count.
    ///
    /// # Source
    /// German road traffic regulations (StVO), section 37: lights take precedence over signs.
    pub has_light: bool,
}

/// A crosswalk: its corners in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Crosswalk {
    pub corners: Vec<Point>,
    /// The height of its street (m).
    pub ground: f64,
}

impl Crosswalk {
    /// Its first corner.
    pub fn place(&self) -> Place {
        Place::on(self.corners.first().copied().unwrap_or_default(), self.ground)
    }
}

impl Deref for Crosswalk {
    type Target = [Point];

    fn deref(&self) -> &[Point] {
        &self.corners
    }
}
