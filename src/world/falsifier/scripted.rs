use super::WalkPolicy;
use crate::env::Scene;
use crate::sim::WalkCommand;
use base::keys;

keys! {
    /// Walks as the test of the spawn rule (`crossing_test`, `along_test`) or its path (`given_path`) states: the nominal case
    /// beside searches.
    pub struct ScriptedKeys = "scripted" {}
}

/// The pedestrian that walks as the spawn rule states: the target of a test ([`TargetWalk`](crate::env::TargetWalk)), or along a path
/// ([`GivenPath`](crate::env::GivenPath)). In other scenarios it stands.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scripted;

impl WalkPolicy for Scripted {
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let facing = |pedestrian: usize| scene.world.pedestrians[pedestrian].state.pose.yaw;
        for (pedestrian, command) in commands.iter_mut().enumerate() {
            *command = WalkCommand { heading: facing(pedestrian), speed: 0.0 };
        }
        if let (Some(first), Some(script)) = (commands.first_mut(), scene.scenario.spawn.scripted()) {
            *first = script;
        }
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(*self))
    }
}
