use thiserror::Error;

/// Why a town cannot be laid out as designed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A measure lies outside its limits.
    #[error("the {what} is {value} m; it must lie between {low} and {high} m")]
    Measure {
        /// Which measure.
        what: &'static str,
        /// Its value (m).
        value: f64,
        /// The least it may be (m).
        low: f64,
        /// The most it may be (m).
        high: f64,
    },
    /// A node lies too far away, or nowhere.
    #[error("node `{node}` does not lie within {reach} m of the origin")]
    FarNode {
        node: String,
        /// How far it may lie from the origin along either axis (m).
        reach: f64,
    },
    /// A speed limit is not a positive number.
    #[error("street `{street}` has a speed limit of {limit} m/s")]
    SpeedLimit {
        street: String,
        /// Its limit (m/s).
        limit: f64,
    },
    /// A building has no place or no size.
    #[error("building {building} has no place or no size")]
    BuildingMeasure {
        /// Its place in the design.
        building: usize,
    },
    /// A street has fewer than two nodes.
    #[error("street `{street}` needs two nodes and has {nodes}")]
    ShortStreet {
        street: String,
        /// How many nodes it has.
        nodes: usize,
    },
    /// A street names a node that does not exist.
    #[error("street `{street}` names node number {node}, which does not exist")]
    UnknownNode {
        street: String,
        /// The requested index.
        node: usize,
    },
    /// A street names a node twice in a row.
    #[error("street `{street}` names node `{node}` twice in a row")]
    RepeatedNode { street: String, node: String },
    /// Two nodes lie on one place.
    #[error("nodes `{first}` and `{second}` lie on one place")]
    SamePlace {
        /// A node.
        first: String,
        /// The other one.
        second: String,
    },
    /// No street uses a node.
    #[error("no street uses node `{node}`")]
    UnusedNode { node: String },
    /// Streets cross where they have no node in common.
    #[error("streets `{first}` and `{second}` cross at ({x:.1}, {y:.1}) without a common point there")]
    Crossing {
        /// A street.
        first: String,
        /// The other one, or the same again.
        second: String,
        /// Where they cross (m).
        x: f64,
        /// Where they cross (m).
        y: f64,
    },
    /// Streets lie so close that their sidewalks overlap.
    #[error("streets `{first}` and `{second}` overlap near ({x:.1}, {y:.1})")]
    Overlap {
        /// A street, or the node of a bend or junction.
        first: String,
        /// The other one, or the same again.
        second: String,
        /// About where they overlap (m).
        x: f64,
        /// About where they overlap (m).
        y: f64,
    },
    /// Two streets meet at too sharp an angle.
    #[error(
        "streets `{first}` and `{second}` meet at node `{node}` at {degrees:.1} degrees; at least {least:.0} are needed"
    )]
    SharpAngle {
        node: String,
        /// A street.
        first: String,
        /// The other one, or the same again.
        second: String,
        /// The angle between them (degrees).
        degrees: f64,
        /// The least it may be (degrees).
        least: f64,
    },
    /// More than four legs meet at a node.
    #[error("{legs} legs meet at node `{node}`; a junction has at most four")]
    ManyLegs {
        node: String,
        /// How many legs it has.
        legs: usize,
    },
    /// There is no room for a road between the junctions or bends at its ends.
    #[error(
        "street `{street}` is {length:.1} m long between `{from}` and `{to}`; bends and junctions need {needed:.1} m"
    )]
    ShortLeg {
        street: String,
        /// The node at one end.
        from: String,
        /// The node at the other end.
        to: String,
        /// The distance of the nodes (m).
        length: f64,
        /// The least it may be (m).
        needed: f64,
    },
    /// Two one-way streets lead both to a node, or both away from it.
    #[error(
        "no car can drive on at node `{node}`: streets `{first}` and `{second}` are one-way against each other there"
    )]
    OneWayAgainst {
        node: String,
        /// A street.
        first: String,
        /// The other one.
        second: String,
    },
    /// Two streets with different lanes meet without a junction.
    #[error(
        "streets `{first}` and `{second}` have different lanes and meet at node `{node}`; only a junction of three or four streets joins such streets"
    )]
    UnequalLanes {
        node: String,
        /// A street.
        first: String,
        /// The other one.
        second: String,
    },
    /// A street is too wide for its bend.
    #[error(
        "street `{street}` bends at node `{node}` with a radius of {radius} m; for its lanes at least {needed:.1} m are needed"
    )]
    TightBend {
        node: String,
        street: String,
        /// The radius of all bends (m).
        radius: f64,
        /// The least that it may be here (m).
        needed: f64,
    },
    /// No lane leads on from a street at a junction, or none leads into it.
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
    /// A node that is no junction has traffic lights.
    #[error("node `{node}` has traffic lights and is no junction")]
    LightsWithoutJunction { node: String },
    /// A building stands on a lane.
    #[error("building {building} stands on a lane of `{road}`")]
    BuildingOnLane {
        /// Its place in the design.
        building: usize,
        /// The street, or the node of the bend or junction.
        road: String,
    },
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
