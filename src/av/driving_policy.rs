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
    /// Slowing down smoothly for another road user.
    Yield,
    /// Braking hard for another road user.
    EmergencyStop,
    /// Standing at a red light.
    RedLight,
    /// Standing at the end of its route.
    Arrived,
    /// An external driver that does not report its mode.
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

/// The driver of a vehicle.
pub trait DrivingPolicy: Send {
    /// Forgets the last episode and gets ready for one that begins as perceived; `stream` is the policy's own.
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream);

    /// Called before [`DrivingPolicy::drive`] with the same perception. All policies of a batch are prepared before the first of
    /// them drives, so a driver that answers for the batch at once gathers its questions here.
    fn prepare(&mut self, perception: &Perception<'_>) {
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

    /// Makes another policy like this one for a batch: policies of a batch drive at the same time, each in a world of its own. None
    /// when a batch is no faster than one episode after another.
    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        None
    }

    /// The number of policies in a batch.
    fn batch_size(&self) -> usize {
        1
    }
}
