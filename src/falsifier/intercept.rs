use super::Walker;
use crate::env::PedestrianEnv;
use crate::seed::Stream;
use crate::sim::WalkCommand;

/// Walks as fast as it can to where it would meet an ego that keeps its velocity: a yardstick written by hand.
#[derive(Debug, Clone, Copy, Default)]
pub struct Intercept;

impl Walker for Intercept {
    fn begin(&mut self, _: Stream) {}

    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand {
        env.intercept()
    }

    fn clone_for_batch(&self) -> Option<Box<dyn Walker>> {
        Some(Box::new(*self))
    }
}
