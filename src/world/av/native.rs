use super::cruise::{Cruise, CruiseKeys};
use super::{DrivingMode, DrivingPolicy, Perception};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// A driver that belongs to another simulator, for evaluations in that `world` alone. Up to the start of the episode the kind `cruise` drives, with
    /// its defaults.
    pub struct NativeKeys = "native" {
        /// Its name there, such as `IDMPolicy`.
        name: String,
    }
}

/// Stands for a driver that belongs to another simulator, and drives the run-up.
pub struct Native {
    name: String,
    run_up: Cruise,
}

impl Native {
    pub fn new(keys: NativeKeys) -> Self {
        Self { name: keys.name, run_up: Cruise::new(CruiseKeys::default()) }
    }
}

impl DrivingPolicy for Native {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.run_up.speed_limit_for(speed)
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.run_up.reset(perception, stream);
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.run_up.drive(perception)
    }

    fn mode(&self) -> DrivingMode {
        self.run_up.mode()
    }

    fn world_driver(&self) -> Option<&str> {
        Some(&self.name)
    }
}
