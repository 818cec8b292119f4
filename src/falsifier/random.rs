use rand::RngExt;

use super::Walker;
use crate::env::PedestrianEnv;
use crate::seed::Stream;
use crate::sim::WalkCommand;

/// Draws every command uniformly from all that it could do: the floor that a trained pedestrian must beat.
#[derive(Debug, Clone, Default)]
pub struct Random {
    stream: Option<Stream>,
}

impl Walker for Random {
    fn begin(&mut self, stream: Stream) {
        self.stream = Some(stream);
    }

    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand {
        let stream = self.stream.as_mut().expect("an episode has begun");
        let bounds = env.scenario().adversary.action_bounds();
        env.command(bounds.map(|(low, high)| low + (high - low) * stream.random::<f64>()))
    }

    fn clone_for_batch(&self) -> Option<Box<dyn Walker>> {
        Some(Box::new(self.clone()))
    }
}
