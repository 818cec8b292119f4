use super::{Fault, Perception};
use crate::seed::Stream;
use crate::sim::Control;

/// What a driver is doing, for tables and replays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, serde::Serialize, serde::Deserialize)]
pub enum DrivingMode {
    /// Along its route, as fast as it wants.
    #[default]
    Cruise,
    /// Through a turn, slower.
    Turn,
    /// Behind another vehicle.
    Follow,
    /// Slowing down smoothly for somebody.
    Yield,
    /// Braking hard for somebody.
    EmergencyStop,
    /// Standing at a red light.
    RedLight,
    /// Standing at the end of its route.
    Arrived,
    /// Known to the driver alone: it came from outside and does not tell.
    Unknown,
}

impl DrivingMode {
    /// All of them.
    const ALL: [Self; 8] = [
        Self::Cruise,
        Self::Turn,
        Self::Follow,
        Self::Yield,
        Self::EmergencyStop,
        Self::RedLight,
        Self::Arrived,
        Self::Unknown,
    ];

    /// The one with this name in tables.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cruise => "cruise",
            Self::Turn => "turn",
            Self::Follow => "follow",
            Self::Yield => "yield",
            Self::EmergencyStop => "emergency_stop",
            Self::RedLight => "red_light",
            Self::Arrived => "arrived",
            Self::Unknown => "unknown",
        }
    }
}

/// A car under test.
pub trait DrivingPolicy: Send {
    /// Forgets the last episode and gets ready for one that begins as perceived; `stream` is the policy's own.
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream);

    /// Announces that [`DrivingPolicy::drive`] will be called with the same perception, once all that drive together have
    /// announced theirs; who answers for many at once gathers the questions here.
    fn announce(&mut self, perception: &Perception<'_>) {
        let _ = perception;
    }

    /// Chooses the pedals and the wheel for the coming tick.
    fn drive(&mut self, perception: &Perception<'_>) -> Control;

    /// What it was doing in its last [`DrivingPolicy::drive`].
    fn mode(&self) -> DrivingMode;

    /// What went wrong since the last [`DrivingPolicy::reset`], for drivers that can fail; what such a driver did is void.
    fn fault(&self) -> Option<Fault> {
        None
    }

    /// Makes another one like it that gains from driving at the same time, each in a world of its own; none when there is
    /// nothing to gain.
    fn twin(&self) -> Option<Box<dyn DrivingPolicy>> {
        None
    }

    /// How many of its kind should drive at the same time.
    fn company(&self) -> usize {
        1
    }
}
