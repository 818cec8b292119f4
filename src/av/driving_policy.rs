use super::Perception;
use crate::seed::Stream;
use crate::sim::Control;

/// What a driver is doing, for tables and replays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
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
}

impl DrivingMode {
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
        }
    }
}

/// A car under test.
pub trait DrivingPolicy: Send {
    /// Forgets the last episode and gets ready for one that begins as perceived; `stream` is the policy's own.
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream);

    /// Chooses the pedals and the wheel for the coming tick.
    fn drive(&mut self, perception: &Perception<'_>) -> Control;

    /// What it was doing in its last [`DrivingPolicy::drive`].
    fn mode(&self) -> DrivingMode;
}
