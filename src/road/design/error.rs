use thiserror::Error;

/// Why a town cannot be laid out as designed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    #[error("the {what} is {value} m; it must lie between {low} and {high} m")]
    Measure { what: &'static str, value: f64, low: f64, high: f64 },
    #[error("node `{node}` does not lie within {reach} m of the origin")]
    FarNode { node: String, reach: f64 },
    #[error("street `{street}` has a speed limit of {limit} m/s")]
    SpeedLimit { street: String, limit: f64 },
    #[error("building {building} has no place or no size")]
    BuildingMeasure { building: usize },
    #[error("street `{street}` needs two nodes and has {nodes}")]
    ShortStreet { street: String, nodes: usize },
    #[error("street `{street}` names node number {node}, which does not exist")]
    UnknownNode { street: String, node: usize },
    #[error("street `{street}` names node `{node}` twice in a row")]
    RepeatedNode { street: String, node: String },
    #[error("nodes `{first}` and `{second}` lie on one place")]
    SamePlace { first: String, second: String },
    #[error("no street uses node `{node}`")]
    UnusedNode { node: String },
    #[error("streets `{first}` and `{second}` cross at ({x:.1}, {y:.1}) without a common point there")]
    Crossing { first: String, second: String, x: f64, y: f64 },
    #[error("streets `{first}` and `{second}` overlap near ({x:.1}, {y:.1})")]
    Overlap {
        first: String,
        second: String,
        /// About where they overlap (m).
        x: f64,
        /// About where they overlap (m).
        y: f64,
    },
    #[error(
        "streets `{first}` and `{second}` meet at node `{node}` at {degrees:.1} degrees; at least {least:.0} are needed"
    )]
    SharpAngle { node: String, first: String, second: String, degrees: f64, least: f64 },
    #[error("{legs} legs meet at node `{node}`; a junction has at most four")]
    ManyLegs { node: String, legs: usize },
    #[error(
        "street `{street}` is {length:.1} m long between `{from}` and `{to}`; bends and junctions need {needed:.1} m"
    )]
    ShortLeg { street: String, from: String, to: String, length: f64, needed: f64 },
    #[error(
        "no car can drive on at node `{node}`: streets `{first}` and `{second}` are one-way against each other there"
    )]
    OneWayAgainst { node: String, first: String, second: String },
    #[error(
        "streets `{first}` and `{second}` have different lanes and meet at node `{node}`; only a junction of three or four streets joins such streets"
    )]
    UnequalLanes { node: String, first: String, second: String },
    #[error(
        "street `{street}` bends at node `{node}` with a radius of {radius} m; for its lanes at least {needed:.1} m are needed"
    )]
    TightBend { node: String, street: String, radius: f64, needed: f64 },
    #[error(
        "no way leads {} street `{street}` at node `{node}`: all other streets there are one-way {} the node",
        if *stuck { "on from" } else { "into" }, if *stuck { "towards" } else { "away from" }
    )]
    NoWay {
        node: String,
        street: String,
        /// Whether cars cannot leave the street; otherwise they cannot reach it.
        stuck: bool,
    },
    #[error("node `{node}` has traffic lights and is not a junction")]
    LightsWithoutJunction { node: String },
    #[error("building {building} stands on a lane of `{road}`")]
    BuildingOnLane { building: usize, road: String },
}

impl DesignError {
    /// The names of the streets and nodes at fault, the one that says most about the place first.
    pub fn names(&self) -> Vec<&str> {
        match self {
            Self::Measure { .. } | Self::BuildingMeasure { .. } => Vec::new(),
            Self::FarNode { node, .. }
            | Self::UnusedNode { node }
            | Self::ManyLegs { node, .. }
            | Self::LightsWithoutJunction { node } => vec![node],
            Self::SpeedLimit { street, .. } | Self::ShortStreet { street, .. } | Self::UnknownNode { street, .. } => {
                vec![street]
            }
            Self::RepeatedNode { street, node } => vec![street, node],
            Self::SamePlace { first, second }
            | Self::Crossing { first, second, .. }
            | Self::Overlap { first, second, .. } => vec![first, second],
            Self::SharpAngle { node, first, second, .. }
            | Self::OneWayAgainst { node, first, second }
            | Self::UnequalLanes { node, first, second } => vec![first, second, node],
            Self::TightBend { node, street, .. } | Self::NoWay { node, street, .. } => vec![street, node],
            Self::ShortLeg { street, from, to, .. } => vec![street, from, to],
            Self::BuildingOnLane { road, .. } => vec![road],
        }
    }
}
