use super::WalkPolicy;
use crate::Scene;
use base::keys;
use world::sim::WalkCommand;

keys! {
    /// Walks as the test of the spawn rule (`crossing_test`, `along_test`) or its path (`given_path`) states: the nominal case
    /// beside searches.
    pub struct ScriptedKeys = "scripted" {}
}

/// The pedestrian that walks as the spawn rule states: the target of a test ([`TargetWalk`](crate::TargetWalk)), or along a path
/// ([`GivenPath`](crate::GivenPath)). In other scenarios it stands.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scripted;

impl WalkPolicy for Scripted {
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let script = scene.scenario.spawn.scripted();
        for (pedestrian, _) in scene.controlled() {
            let stands = WalkCommand { heading: scene.world.pedestrians[pedestrian].state.pose.yaw, speed: 0.0 };
            commands[pedestrian] = script.filter(|_| pedestrian == 0).unwrap_or(stands);
        }
    }

    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(*self))
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(*self))
    }
}
