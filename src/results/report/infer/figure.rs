use crate::tables::Metric;
use crate::tables::metrics::{
    COLLISION_RATE, EPISODE_LENGTH, EPISODE_REWARD, FAULT_RATE, FRONT_RATE, IMPACT_SPEED, PREVENTABLE_RATE, TOUCH_RATE,
};

/// A figure of a pedestrian that is averaged over trainings and compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    /// Collisions and bumps of all episodes.
    Touch,
    /// The share of these in the front sector.
    Front,
    /// Collisions of all episodes.
    Collision,
    /// Preventable collisions of all episodes.
    Preventable,
    /// Preventable collisions with a foreseeable pedestrian of all episodes.
    Fault,
    /// Reward of an episode.
    Reward,
    /// Length of an episode (s).
    Length,
    /// Speed of the car at a collision (m/s).
    ImpactSpeed,
}

impl Figure {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 8] = [
        Self::Touch,
        Self::Front,
        Self::Collision,
        Self::Preventable,
        Self::Fault,
        Self::Reward,
        Self::Length,
        Self::ImpactSpeed,
    ];
    /// The figures in which pedestrians are compared: rates of all episodes.
    pub const COMPARED: [Self; 3] = [Self::Collision, Self::Preventable, Self::Fault];

    /// The metric of it.
    pub fn metric(self) -> &'static Metric {
        match self {
            Self::Touch => &TOUCH_RATE,
            Self::Front => &FRONT_RATE,
            Self::Collision => &COLLISION_RATE,
            Self::Preventable => &PREVENTABLE_RATE,
            Self::Fault => &FAULT_RATE,
            Self::Reward => &EPISODE_REWARD,
            Self::Length => &EPISODE_LENGTH,
            Self::ImpactSpeed => &IMPACT_SPEED,
        }
    }

    /// The prefix of its columns.
    pub fn name(self) -> &'static str {
        self.metric().name
    }

    /// Between what it lies.
    pub fn bounds(self) -> (f64, f64) {
        match self {
            Self::Reward => (f64::NEG_INFINITY, f64::INFINITY),
            Self::Length | Self::ImpactSpeed => (0.0, f64::INFINITY),
            _ => (0.0, 1.0),
        }
    }
}
