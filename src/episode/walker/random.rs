use rand::RngExt;

use super::WalkPolicy;
use crate::Scene;
use base::keys;
use base::seed::Stream;
use world::sim::WalkCommand;

keys! {
    /// Draws every command uniformly: the floor that every search must beat.
    pub struct RandomKeys = "random" {}
}

/// Draws every action uniformly from its bounds: the baseline that a trained pedestrian must beat.
#[derive(Debug, Clone, Default)]
pub struct Random {
    stream: Option<Stream>,
    action: Vec<f64>,
}

impl WalkPolicy for Random {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    fn reseed(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        let stream = self.stream.as_mut().expect("an episode has started");
        self.action.clear();
        self.action.extend(scene.bounds().iter().map(|(low, high)| low + (high - low) * stream.random::<f64>()));
        scene.write_commands(&self.action, commands);
    }

    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.clone()))
    }
}
