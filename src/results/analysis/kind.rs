use std::fmt;

use crate::failure::Failure;
use world::av::DrivingMode;
use world::env::Impact;
use world::judge::Label;

/// The class of a collision, by fixed rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kind {
    /// The side of the car that was hit.
    pub impact: Impact,
    /// The verdict: which reference drivers would have avoided it.
    pub verdict: Label,
    /// Whether the pedestrian came into sight too late for a careful human.
    pub occluded: bool,
    /// What the driver did at the touch.
    pub mode: DrivingMode,
}

impl Kind {
    /// That of a collision; `None` without a verdict.
    pub fn of(failure: &Failure) -> Option<Self> {
        let mode = failure.driving_mode.unwrap_or(DrivingMode::Unknown);
        Some(Self { impact: failure.impact?, verdict: failure.verdict?, occluded: failure.occluded, mode })
    }
}

/// Names it for people: `front, preventable, cruise`, and `occluded` if it was.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = self.verdict.name().replace('_', " ");
        let occluded = if self.occluded { ", occluded" } else { "" };
        write!(f, "{}, {verdict}{occluded}, {}", self.impact.name(), self.mode.name().replace('_', " "))
    }
}
