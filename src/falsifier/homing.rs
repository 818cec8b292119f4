use super::Walker;
use crate::env::PedestrianEnv;
use crate::seed::Stream;
use crate::sim::WalkCommand;

/// Walks straight at the ego, as fast as it can: the simplest attack there is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Homing;

impl Walker for Homing {
    fn begin(&mut self, _: Stream) {}

    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand {
        env.homing()
    }
}
