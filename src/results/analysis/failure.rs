use std::fmt;

use super::Approach;
use base::choice;
use world::av::DrivingMode;
use world::judge::Label;

choice! {
    /// The side of the car that was hit.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Impact {
        /// Within the front sector.
        Front = "front",
        /// Beside it, to the car's left.
        Left = "left",
        /// Beside it, to the car's right.
        Right = "right",
        /// Within 60° of straight behind.
        Rear = "rear",
    }
}

impl Impact {
    /// The side where a pedestrian hit the car, from whether it was within the front sector and from its bearing from the car's centre
    /// (rad).
    pub fn new(front: bool, bearing: f64) -> Self {
        match bearing {
            _ if front => Self::Front,
            b if b.abs() >= 120_f64.to_radians() => Self::Rear,
            b if b > 0.0 => Self::Left,
            _ => Self::Right,
        }
    }
}

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

/// Names it for people: `front, preventable, cruise`, and `occluded` if it was.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = self.verdict.name().replace('_', " ");
        let occluded = if self.occluded { ", occluded" } else { "" };
        write!(f, "{}, {verdict}{occluded}, {}", self.impact.name(), self.mode.name().replace('_', " "))
    }
}

/// A collision.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    pub run: u32,
    pub episode: u32,
    /// Its class.
    pub kind: Kind,
    /// Speed of the car at the touch (m/s).
    pub impact_speed: f64,
    /// Time from the start of the episode to the touch (s).
    pub length: f64,
    /// The approach before the touch, if it is known.
    pub approach: Option<Approach>,
}
