use crate::Pair;

/// Judges a touch of the ego and a pedestrian: was it a fault of the driver?
///
/// A scenario has one if its reward depends on the judgement. It must be a pure function of the episode.
pub trait TestOracle: Send + Sync {
    /// Judges the touch that ended an episode. The pair must have touched.
    fn judge(&self, pair: &Pair<'_>) -> Judgement;
}

/// The judgement of a touch, as numbers for a reward.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Judgement {
    /// Whether a careful human would have avoided it.
    pub preventable: bool,
    /// Whether it counts against the driver.
    pub fault: bool,
    /// Share of careful drivers that would have avoided it, 0 to 1.
    pub preventability: f64,
    /// Part of the impact speed that a careful human would have avoided (m/s); negative when it would have collided faster.
    pub avoidable_speed: f64,
    /// Least gap that a careful human would have kept (m); 0 when it hits.
    pub margin: f64,
    /// Time from the start of the danger to the touch (s).
    pub warning: f64,
    /// Time before the touch in which the pedestrian could be seen without a break (s).
    pub seen: f64,
}
