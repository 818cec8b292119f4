use super::{Estimate, Event, Importance, MonteCarlo, SubsetSimulation, TestBed};
use crate::falsifier::SearchOutcome;
use base::seed::Seed;

/// When an estimator stops.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// The event that the relative error is about.
    pub event: Event,
    /// The relative error at which it is good enough.
    pub relative_error: f64,
    /// The most ticks that it may use. A batch that has begun is finished.
    pub budget: u64,
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Hears the ticks that were used since the last report.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// A method that estimates a probability.
#[derive(Debug, Clone)]
pub enum Estimator {
    MonteCarlo(MonteCarlo),
    SubsetSimulation(SubsetSimulation),
    Importance(Importance),
}

impl Estimator {
    /// Estimates how likely each event is. `make` makes test beds, one for each worker; `found` is what the falsifier of an [`Importance`] found, and
    /// the seed of its starts.
    ///
    /// The result does not depend on the number of threads.
    pub fn estimate<B: TestBed>(
        &self,
        make: &(dyn Fn() -> B + Sync),
        found: Option<(&SearchOutcome, &Seed)>,
        seed: &Seed,
        limits: Limits<'_>,
    ) -> Estimate {
        match self {
            Self::MonteCarlo(method) => method.estimate(make, seed, limits),
            Self::SubsetSimulation(method) => method.estimate(make, seed, limits),
            Self::Importance(method) => method.estimate(make, found, seed, limits),
        }
    }
}
