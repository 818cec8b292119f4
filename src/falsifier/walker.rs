use crate::env::PedestrianEnv;
use crate::seed::Stream;
use crate::sim::WalkCommand;

/// A pedestrian that chooses its commands.
pub trait Walker {
    /// Gets ready for an episode that has just begun; `stream` is its own.
    fn begin(&mut self, stream: Stream);

    /// Chooses the next command; it sees the environment as it stands.
    fn choose(&mut self, env: &PedestrianEnv) -> WalkCommand;

    /// Another one that chooses as this one does, for episodes that are tried at the same time; none when it cannot be in two
    /// episodes at once.
    fn clone_for_batch(&self) -> Option<Box<dyn Walker>> {
        None
    }
}
