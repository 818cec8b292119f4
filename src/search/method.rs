use super::{BudgetedSimulation, TrainError};
use base::seed::Seed;
use episode::walker::WalkPolicy;

/// The walk policy that a search ends up with, if any.
pub type Searched = Result<Option<Box<dyn WalkPolicy>>, TrainError>;

/// A method that searches for failures of a driver, with a budget of simulator ticks.
///
/// It starts episodes and takes decisions in a [`BudgetedSimulation`] until the budget is used up. The simulator stores the failures. Starts 0, 1,
/// 2, … are the same for every falsifier of a scenario and run.
pub trait Falsifier: std::fmt::Debug + Send + Sync {
    /// Searches for failures until the budget is used up; all random numbers come from `seed`.
    ///
    /// Returns the walk policy that it ends up with, if any, to be evaluated on other starts.
    ///
    /// # Errors
    /// A training whose numbers are not finite, or a controller that fails in ten episodes in a row.
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched;

    /// The walk policy that it evaluates once from each start *k*, with the stream `seed.index(k)` of its seed; `None` for a method that
    /// chooses its commands in another way.
    fn walk_policy(&self) -> Option<Box<dyn WalkPolicy>> {
        None
    }
}
