use super::{BudgetedSimulation, Falsifier, Searched, TrainError};
use base::keys;
use base::seed::Seed;
use base::signature::DeclarationId;
use episode::play;
use episode::walker::{Controller, FaultStreak, WalkPolicy};

keys! {
    /// Walks as a `pedestrian` does, such as a program of your own: one episode from every start.
    pub struct ControlledKeys = "controlled" {
        /// The pedestrian.
        pedestrian: DeclarationId as Reference("pedestrian"),
    }
}

/// A pedestrian as a search method: it runs one episode from every start.
#[derive(Debug, Clone)]
pub struct Controlled(pub Controller);

impl Falsifier for Controlled {
    fn search(&self, simulator: &mut BudgetedSimulation<'_>, seed: &Seed) -> Searched {
        let mut walker = self.0.walk_policy();
        let mut faults = FaultStreak::default();
        for start in 0.. {
            if !simulator.begin(start) {
                break;
            }
            walker.begin(seed.index(start).stream());
            play(simulator, walker.as_mut(), &mut ());
            faults.count(walker.fault());
            if let Some(fault) = faults.hopeless() {
                return Err(TrainError::Controller { fault });
            }
        }
        Ok(Some(walker))
    }

    fn walk_policy(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(self.0.walk_policy())
    }
}
