use super::{BudgetedSimulation, Falsifier, TrainError, WalkPolicy, play};
use base::seed::Seed;

/// A walk policy that does not learn, as a falsifier: it runs one episode from every start.
#[derive(Debug, Clone, Copy)]
pub struct Walking<W> {
    walker: W,
}

impl<W> Walking<W> {
    /// Makes a falsifier of a walk policy.
    pub fn new(walker: W) -> Self {
        Self { walker }
    }
}

impl<W: WalkPolicy + Clone + std::fmt::Debug + Send + Sync + 'static> Falsifier for Walking<W> {
    fn search(
        &self,
        simulator: &mut BudgetedSimulation<'_>,
        seed: &Seed,
    ) -> Result<Option<Box<dyn WalkPolicy>>, TrainError> {
        let mut walker = self.walker.clone();
        for start in 0.. {
            if !simulator.begin(start) {
                break;
            }
            walker.begin(seed.index(start).stream());
            play(simulator, &mut walker, &mut ());
        }
        Ok(Some(Box::new(walker)))
    }

    fn walk_policy(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.walker.clone()))
    }
}
