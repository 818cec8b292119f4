use super::{Simulator, WalkPolicy};
use crate::rl::TrainError;
use crate::seed::Seed;

/// A method that looks for failures of a driver, with a budget of simulator ticks.
///
/// It starts episodes and takes decisions in a [`Simulator`] until the budget is spent. The simulator stores what it finds. Starts
/// 0, 1, 2, … are the same for every falsifier of a scenario and run.
pub trait Falsifier: std::fmt::Debug + Send + Sync {
    /// Looks for failures until the budget is spent; random numbers come from `seed` alone.
    ///
    /// Gives the walk policy that it ends up with, if any, to be evaluated on other starts.
    ///
    /// # Errors
    /// A training whose numbers are not finite.
    fn search(&self, simulator: &mut Simulator<'_>, seed: &Seed) -> Result<Option<Box<dyn WalkPolicy>>, TrainError>;
}
