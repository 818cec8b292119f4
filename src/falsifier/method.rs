use super::{Simulator, Walker};
use crate::rl::TrainError;
use crate::seed::Seed;

/// A method that looks for failures of a driver, with a budget of simulator ticks.
///
/// It begins episodes and walks in a [`Simulator`] as it likes until that is spent. What it finds on the way the simulator
/// writes down. Beginning 0, 1, 2, … are the same for every falsifier of a scenario and run.
pub trait Falsifier: std::fmt::Debug + Send + Sync {
    /// Looks for failures until the budget is spent; random numbers come from `seed` alone.
    ///
    /// Gives the pedestrian that it ends up with, when it has one, to be tried on other beginnings.
    ///
    /// # Errors
    /// A training whose numbers are not finite.
    fn search(&self, simulator: &mut Simulator<'_>, seed: &Seed) -> Result<Option<Box<dyn Walker>>, TrainError>;
}
