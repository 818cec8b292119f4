use super::{Fault, Perception};
use crate::sim::Control;
use base::choice;
use base::seed::Stream;

choice! {
    /// The present manoeuvre of a driver, for tables and replays.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, serde::Serialize, serde::Deserialize)]
    pub enum DrivingMode {
        /// Along its route, at the speed it wants.
        #[default]
        Cruise = "cruise",
        /// Through a turn, slower.
        Turn = "turn",
        /// Behind another vehicle.
        Follow = "follow",
        /// Slowing down smoothly for another road user.
        Yield = "yield",
        /// Braking hard for another road user.
        EmergencyStop = "emergency_stop",
        /// Standing at a red light.
        RedLight = "red_light",
        /// Slowing down for a stop or yield sign, or standing there.
        GiveWay = "give_way",
        /// Standing at the end of its route.
        Arrived = "arrived",
        /// An external driver that does not report its mode.
        Unknown = "unknown",
    }
}

impl DrivingMode {
    /// Its name in texts for people.
    pub fn shown(self) -> &'static str {
        if self == Self::Unknown { "not stated" } else { self.name() }
    }
}

/// The driver of a vehicle.
pub trait DrivingPolicy: Send {
    /// Forgets the last episode and prepares for one that starts with this perception; `stream` is the policy's own.
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream);

    /// The speed limit at which it drives this speed (m/s) on a free, straight road; the driver holds a test speed that way. A driver whose
    /// speed does not follow the limit returns the speed.
    fn speed_limit_for(&self, speed: f64) -> f64 {
        speed
    }

    /// Called before [`DrivingPolicy::drive`] with the same perception. All policies of a batch are prepared before the first of
    /// them drives. A driver that answers a whole batch at once collects its requests here.
    fn prepare(&mut self, perception: &Perception<'_>) {
        let _ = perception;
    }

    /// Chooses the pedals and the wheel for the next tick.
    fn drive(&mut self, perception: &Perception<'_>) -> Control;

    /// Its manoeuvre in the last [`DrivingPolicy::drive`].
    fn mode(&self) -> DrivingMode;

    /// The fault since the last [`DrivingPolicy::reset`], for drivers that can fail; an episode with a fault is void.
    fn fault(&self) -> Option<Fault> {
        None
    }

    /// The name of the driver of another simulator that it stands for: that drives there instead of it.
    fn world_driver(&self) -> Option<&str> {
        None
    }

    /// A copy in its present state, with its memory; `None` for a driver whose memory is elsewhere, as in another process.
    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        None
    }

    /// Draws all that it draws from now on from another stream; its memory stays. It does nothing for a driver that draws nothing after
    /// [`DrivingPolicy::reset`], and for one whose random numbers are elsewhere, as in another process.
    fn reseed(&mut self, stream: Stream) {
        let _ = stream;
    }

    /// Makes another policy like this one for a batch. Policies of a batch drive at the same time, each in its own world. None
    /// when a batch is no faster than one episode after another.
    fn clone_for_batch(&self) -> Option<Box<dyn DrivingPolicy>> {
        None
    }

    /// The number of policies in a batch.
    fn batch_size(&self) -> usize {
        1
    }
}
