use base::choice;
use road::LaneFilter;

/// Proportional, integral and differential gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pid {
    pub proportional: f64,
    pub integral: f64,
    pub differential: f64,
}

/// Gains of both controllers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gains {
    /// For the pedals; the error is in km/h.
    pub longitudinal: Pid,
    /// For the wheel; the error is in radians.
    pub lateral: Pid,
}

const fn pid(proportional: f64, integral: f64, differential: f64) -> Pid {
    Pid { proportional, integral, differential }
}

/// Since 0.9.12.
const GAINS: Gains = Gains { longitudinal: pid(1.0, 0.05, 0.0), lateral: pid(1.95, 0.05, 0.2) };

choice! {
    /// The release of CARLA that the agent reproduces. 0.9.10 behaves as 0.9.11, 0.9.14 as 0.9.15.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub enum Release {
        V0_9_11 = "0.9.10.1" | "0.9.11",
        V0_9_12 = "0.9.12",
        V0_9_13 = "0.9.13",
        #[default]
        V0_9_15 = "0.9.14" | "0.9.15",
    }
}

/// The points between which an obstacle's distance and bearing are measured outside junctions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// From the ego's centre to the obstacle's.
    Centres,
    /// From the middle of the ego's bumper to the middle of the obstacle's back.
    BumperToRear,
}

/// When the route is compared as a polygon instead of by lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PolygonRule {
    Never,
    /// When the ego and the obstacle are in junctions; the first such obstacle decides for all.
    BothInJunctions,
    /// When the ego or the obstacle is in a junction, or the ego is wider than its lane. Obstacles out of reach are
    /// skipped before their lane is looked up.
    EitherInJunction,
}

/// Which red lights stop the agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RedLightRule {
    /// The light in whose trigger box the vehicle stands, according to the server.
    Affected,
    /// The lights whose trigger box the agent finds ahead on its road.
    OwnTest,
}

/// The differences between releases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReleaseTraits {
    /// Brake of an emergency stop.
    pub emergency_brake: f64,
    /// The kind of lanes among which an obstacle's lane is sought.
    pub obstacle_lane: LaneFilter,
    /// How obstacles are measured.
    pub measure: Measure,
    /// Bearings of obstacles are taken from a heading computed in 64 bits, not from CARLA's 32-bit vector.
    pub exact_heading: bool,
    /// The point of the queue whose lane counts like the ego's own.
    pub accepted_point: usize,
    /// When polygons are used.
    pub polygons: PolygonRule,
    /// Without a walker near by, the walker step tests the vehicles.
    pub vehicles_for_walkers: bool,
    /// Which red lights count.
    pub red_light: RedLightRule,
    /// Slows down before a turn.
    pub slows_for_turns: bool,
    /// Runs the planner twice when following or turning.
    pub repeats_planner: bool,
    /// The planner has a buffer of points besides its queue, and drops points after steering.
    pub buffered_planner: bool,
    /// The controllers forget their errors every tick.
    pub forgetful: bool,
    /// Gains up to 50 km/h.
    pub gains: Gains,
    /// Gains above 50 km/h.
    pub fast_gains: Gains,
    /// Spacing of a route without destination (m).
    pub step: f64,
}

const V0_9_15: ReleaseTraits = ReleaseTraits {
    emergency_brake: 0.5,
    obstacle_lane: LaneFilter::Any,
    measure: Measure::BumperToRear,
    exact_heading: false,
    accepted_point: 3,
    polygons: PolygonRule::EitherInJunction,
    vehicles_for_walkers: true,
    red_light: RedLightRule::OwnTest,
    slows_for_turns: true,
    repeats_planner: false,
    buffered_planner: false,
    forgetful: false,
    gains: GAINS,
    fast_gains: GAINS,
    step: 2.0,
};

const V0_9_13: ReleaseTraits =
    ReleaseTraits { polygons: PolygonRule::BothInJunctions, repeats_planner: true, ..V0_9_15 };

const V0_9_12: ReleaseTraits = ReleaseTraits {
    obstacle_lane: LaneFilter::Driving,
    measure: Measure::Centres,
    accepted_point: 5,
    polygons: PolygonRule::Never,
    vehicles_for_walkers: false,
    ..V0_9_13
};

const V0_9_11: ReleaseTraits = ReleaseTraits {
    emergency_brake: 1.0,
    exact_heading: true,
    red_light: RedLightRule::Affected,
    slows_for_turns: false,
    repeats_planner: false,
    buffered_planner: true,
    forgetful: true,
    gains: Gains { longitudinal: pid(0.15, 0.07, 0.05), lateral: pid(0.58, 0.5, 0.02) },
    fast_gains: Gains { longitudinal: pid(0.37, 0.032, 0.024), lateral: pid(0.75, 0.4, 0.02) },
    step: 4.5,
    ..V0_9_12
};

impl Release {
    pub(super) const fn traits(self) -> ReleaseTraits {
        match self {
            Self::V0_9_11 => V0_9_11,
            Self::V0_9_12 => V0_9_12,
            Self::V0_9_13 => V0_9_13,
            Self::V0_9_15 => V0_9_15,
        }
    }
}
