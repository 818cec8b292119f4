use crate::Outcome;
use crate::requirement::Degree;

/// What counts as a failure of an episode. Whether it counts against the driver is asked of a judged episode.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Criterion {
    /// The moving ego touches a pedestrian.
    #[default]
    Collision,
    /// A requirement is violated, by its place among those of the scenario.
    Violation(usize),
}

impl Criterion {
    /// The place of the requirement that is to be violated; `None` for collisions.
    pub const fn requirement(self) -> Option<usize> {
        match self {
            Self::Collision => None,
            Self::Violation(place) => Some(place),
        }
    }

    /// Whether an episode with this outcome and these degrees of its requirements is a failure.
    pub fn is_met(self, outcome: &Outcome, degrees: &[Degree]) -> bool {
        match self {
            Self::Collision => outcome.is_collision(),
            Self::Violation(place) => degrees.get(place).is_some_and(Degree::is_violated),
        }
    }

    /// How far an episode is from a failure: the robustness of the requirement, or the least gap (m), and below it −1 − *v* for a touch at
    /// *v* m/s. `None` without a degree.
    pub fn margin(self, outcome: &Outcome, degrees: &[Degree]) -> Option<f64> {
        match self {
            Self::Collision => Some(outcome.impact_speed().map_or(outcome.least_gap, |speed| -1.0 - speed)),
            Self::Violation(place) => degrees.get(place).map(|degree| degree.robustness),
        }
    }
}
