use std::fmt;

use super::Survey;

/// Why no pedestrian can be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpawnError {
    /// The town has no lane to start on.
    #[error("the town has no driving lane outside junctions")]
    NoLane,
    /// A listed pose of the ego is not on a lane, or is against its direction.
    #[error(
        "the pose at ({x} m, {y} m) is {apart:.1} m from the nearest driving lane and turned by {degrees:.0} degrees from it"
    )]
    OffLane {
        /// Its x (m).
        x: f64,
        /// Its y (m).
        y: f64,
        /// Distance from the middle of the nearest lane (m).
        apart: f64,
        /// Angle from its heading to the lane's (degrees).
        degrees: f64,
    },
    /// A part of a lane is longer than the lane.
    #[error("the lane at ({x} m, {y} m) ends after {room:.1} m, before the {length} m asked for")]
    ShortLane {
        /// The x of its start (m).
        x: f64,
        /// The y of its start (m).
        y: f64,
        /// The length that was asked for (m).
        length: f64,
        /// The length of the lane (m).
        room: f64,
    },
    /// A turn of the ego's route does not exist.
    #[error("turn {number} of `ego_route` from ({x} m, {y} m) cannot be taken: {why}")]
    NoTurn {
        /// Its number, from 1.
        number: usize,
        /// The x of the ego's start (m).
        x: f64,
        /// The y of the ego's start (m).
        y: f64,
        why: &'static str,
    },
    /// Too few starts satisfy all constraints.
    #[error("{0}; at least about one in ten thousand must")]
    Crowded(Rarity),
}

/// The rate of starts that satisfy all constraints, and the constraint that most starts fail.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rarity {
    /// Starts that satisfied all.
    pub accepted: u32,
    /// Starts that were drawn.
    pub tried: u32,
    /// The constraint that most of them failed.
    pub worst: String,
    /// Drawn starts that satisfied it.
    pub worst_passed: u32,
    /// Whether enough starts satisfy all constraints when pose and place are drawn together, but none around most poses of the ego. Then
    /// the numbers count starts that were drawn as episodes draw them, and the tries for them.
    pub barren: bool,
}

impl Rarity {
    /// The numbers of a survey.
    pub(super) fn of(survey: &Survey) -> Self {
        let (worst, worst_passed) = survey.worst().unwrap_or_default();
        let (accepted, tried, worst) = (survey.accepted, survey.tried, worst.to_string());
        Self { accepted, tried, worst, worst_passed, barren: false }
    }
}

impl fmt::Display for Rarity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { accepted, tried, worst, worst_passed, barren } = self;
        if *barren {
            return write!(
                f,
                "{accepted} of them took {tried} tries, since around most poses of the ego no pedestrian can be placed; the constraint that fails most is `{worst}`"
            );
        }
        write!(
            f,
            "only {accepted} of {tried} starts satisfy all constraints; the one that fails most is `{worst}`, satisfied by {worst_passed}"
        )
    }
}
