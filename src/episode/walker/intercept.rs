use super::WalkPolicy;
use crate::Scene;
use base::keys;
use world::sim::WalkCommand;

keys! {
    /// Walks to where it would meet an ego that keeps its velocity.
    pub struct InterceptKeys = "intercept" {}
}

/// Walks at its greatest speed to where it would meet an ego that keeps its velocity: a baseline without learning.
#[derive(Debug, Clone, Copy, Default)]
pub struct Intercept;

impl WalkPolicy for Intercept {
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        for (pedestrian, _) in scene.controlled() {
            commands[pedestrian] = scene.intercept(pedestrian);
        }
    }

    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(Self))
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(*self))
    }
}
