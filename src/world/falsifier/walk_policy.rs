use crate::av::Fault;
use crate::env::{Scenario, Scene};
use crate::sim::WalkCommand;
use base::seed::Stream;

/// A policy that chooses the commands of pedestrians.
pub trait WalkPolicy: Send {
    /// Checks whether it can walk in a scenario.
    ///
    /// # Errors
    /// Why it cannot, as a part of a sentence.
    fn fits(&self, scenario: &Scenario) -> Result<(), &'static str> {
        let _ = scenario;
        Ok(())
    }

    /// Prepares for an episode that has just started; `stream` holds its random numbers.
    fn begin(&mut self, stream: Stream) {
        let _ = stream;
    }

    /// Chooses the next decision: one command for each pedestrian, in the order of their numbers.
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]);

    /// Why the last choice failed; the commands of that choice mean nothing, and the episode is in error. `None` for policies of this crate,
    /// which cannot fail.
    fn fault(&self) -> Option<Fault> {
        None
    }

    /// Another policy that chooses as this one does, for episodes that run at the same time. `None` if this policy cannot be in two
    /// episodes at once.
    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        None
    }
}
