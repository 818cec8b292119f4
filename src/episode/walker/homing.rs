use super::WalkPolicy;
use crate::Scene;
use base::keys;
use world::sim::WalkCommand;

keys! {
    /// Walks straight at the ego, as fast as it can.
    pub struct HomingKeys = "homing" {}
}

/// Walks straight at the ego at its greatest speed: the simplest attack.
#[derive(Debug, Clone, Copy, Default)]
pub struct Homing;

impl WalkPolicy for Homing {
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        for (pedestrian, _) in scene.controlled() {
            commands[pedestrian] = scene.homing(pedestrian);
        }
    }

    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(Self))
    }
}
