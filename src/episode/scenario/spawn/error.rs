use std::fmt;

/// Why no pedestrian can be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpawnError {
    #[error("the town has no driving lane outside junctions")]
    NoLane,
    #[error(
        "the pose at ({x} m, {y} m) is {apart:.1} m from the nearest driving lane and turned by {degrees:.0} degrees from it"
    )]
    OffLane { x: f64, y: f64, apart: f64, degrees: f64 },
    #[error("the lane at ({x} m, {y} m) ends after {room:.1} m, before the {length} m asked for")]
    ShortLane { x: f64, y: f64, length: f64, room: f64 },
    #[error("turn {number} of `ego_route` from ({x} m, {y} m) cannot be taken: {why}")]
    NoTurn { number: usize, x: f64, y: f64, why: &'static str },
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

impl fmt::Display for Rarity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { accepted, tried, worst, worst_passed, barren } = self;
        if *barren {
            return write!(
                f,
                "{accepted} of them took {tried} tries, since around most poses of the ego no pedestrian can be placed; the constraint that fails most is `{worst}`"
            );
        }
        write!(f, "{accepted} of {tried} do; the constraint that fails most is `{worst}`, which {worst_passed} satisfy")
    }
}
