use crate::RoadEnd;

/// The widths of a street's parts: driving lanes, and on either side of them a shoulder and a sidewalk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreetProfile {
    /// Width of a driving lane (m).
    pub lane_width: f64,
    /// Width of a shoulder (m).
    pub shoulder: f64,
    /// Width of a sidewalk (m).
    pub sidewalk: f64,
}

impl Default for StreetProfile {
    /// The cross-section of the streets in CARLA's Town01 and Town02.
    fn default() -> Self {
        Self { lane_width: 4.0, shoulder: 0.3, sidewalk: 4.0 }
    }
}

/// The driving lanes of a street, by direction. Traffic keeps to the right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Carriageway {
    /// Number of lanes in the direction of the street's nodes.
    pub forward: u32,
    /// Number of lanes against it; 0 in a one-way street.
    pub backward: u32,
}

impl Default for Carriageway {
    /// One lane in each direction.
    fn default() -> Self {
        Self { forward: 1, backward: 1 }
    }
}

impl Carriageway {
    /// The distance from the middle of the street to the edge of its driving lanes (m).
    pub(super) fn half_width(self, profile: &StreetProfile) -> f64 {
        f64::from(self.forward + self.backward) / 2.0 * profile.lane_width
    }

    /// The distance from the middle of the street to the outer edge of its sidewalks (m).
    pub fn street_half_width(self, profile: &StreetProfile) -> f64 {
        self.half_width(profile) + profile.shoulder + profile.sidewalk
    }

    /// Lateral place of the line between the two directions, seen in the direction of the nodes, positive to the left of the middle (m).
    pub(super) fn divide(self, profile: &StreetProfile) -> f64 {
        (f64::from(self.forward) - f64::from(self.backward)) / 2.0 * profile.lane_width
    }

    /// The same lanes as they are seen from the node at one end.
    pub(super) fn at(self, end: RoadEnd, profile: &StreetProfile) -> Approach {
        let divide = self.divide(profile);
        match end {
            RoadEnd::End => Approach { inward: self.forward, outward: self.backward, divide, side: -1 },
            RoadEnd::Start => Approach { inward: self.backward, outward: self.forward, divide: -divide, side: 1 },
        }
    }
}

/// The lanes at one end of a street, seen by a car that drives to the node there. Lanes are counted from 1 on, from the line between the
/// directions outwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Approach {
    /// Number of lanes to the node.
    pub inward: u32,
    /// Number of lanes away from the node.
    pub outward: u32,
    /// Lateral place of the line between the directions, positive to the left of the middle (m).
    pub divide: f64,
    /// The sign of the numbers of the inward lanes, shoulder and sidewalk on the right.
    side: i32,
}

impl Approach {
    /// The number of the road's lane that is this many lanes from the line, on the right of a car to the node. Beyond the lanes are the shoulder
    /// and the sidewalk.
    pub fn inward_lane(&self, place: u32) -> i32 {
        self.side * place as i32
    }

    /// The same on the left of that car, where traffic leads away from the node.
    pub fn outward_lane(&self, place: u32) -> i32 {
        -self.side * place as i32
    }
}
