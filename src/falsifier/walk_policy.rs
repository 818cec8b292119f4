use crate::env::PedestrianEnv;
use crate::seed::Stream;
use crate::sim::WalkCommand;

/// A policy that chooses the commands of pedestrians.
pub trait WalkPolicy {
    /// Gets ready for an episode that has just started; `stream` is its own.
    fn begin(&mut self, stream: Stream);

    /// Chooses the next decision: one command for each pedestrian, in the order of their numbers. It may read all of the
    /// environment's present state.
    fn choose(&mut self, env: &PedestrianEnv, commands: &mut [WalkCommand]);

    /// Another policy that chooses as this one does, for episodes that run at the same time; none when it cannot be in two
    /// episodes at once.
    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        None
    }
}
