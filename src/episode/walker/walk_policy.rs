use crate::{Cast, EpisodeRule, Scene};
use base::seed::Stream;
use world::av::Fault;
use world::sim::WalkCommand;

/// A policy that chooses the commands of pedestrians.
pub trait WalkPolicy: Send {
    /// Checks whether it can move the pedestrians of a cast that are left to the user of the environment.
    ///
    /// # Errors
    /// Why it cannot, as a part of a sentence.
    fn fits(&self, cast: &Cast, rule: &EpisodeRule) -> Result<(), &'static str> {
        let _ = (cast, rule);
        Ok(())
    }

    /// How its training differs from episodes of such a cast in which it can walk, as a part of a sentence.
    fn differs(&self, cast: &Cast, rule: &EpisodeRule) -> Option<String> {
        let _ = (cast, rule);
        None
    }

    /// Prepares for an episode that has just started; `stream` holds its random numbers.
    fn begin(&mut self, stream: Stream) {
        let _ = stream;
    }

    /// Draws from another stream from now on; nothing for a policy that draws nothing.
    fn reseed(&mut self, stream: Stream) {
        let _ = stream;
    }

    /// Chooses the next decision. There is one command for each pedestrian, in the order of their numbers; those of [`Scene::controlled`] count.
    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]);

    /// Why the last choice failed; the commands of that choice mean nothing, and the episode is in error. `None` for policies of this crate,
    /// which cannot fail.
    fn fault(&self) -> Option<Fault> {
        None
    }

    /// A copy in the present state; `None` if that cannot be copied.
    fn snapshot(&self) -> Option<Box<dyn WalkPolicy>> {
        None
    }

    /// Another policy that chooses as this one does, for episodes that run at the same time. `None` if this policy cannot be in two
    /// episodes at once.
    fn clone_for_batch(&self) -> Option<Box<dyn WalkPolicy>> {
        None
    }
}
