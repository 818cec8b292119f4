//! How likely failures are: the probability of an event in an encounter with a pedestrian who walks as people do.
//!
//! An encounter is drawn by a [`Lot`]: tapes of random words. So it is a point that can be moved, and the methods need no density of
//! starts, commands or sensors. What is estimated is a [`TestBed`]: begin, step, level, outcome, mark. Our simulator is one ([`Encounters`]); a
//! test with a known answer is another.
//!
//! Beside it, [`cover`] shows how much of a [`BoxOfStarts`] can fail where a picture of it says that it passes.
//!
//! | method | what it does | when |
//! |---|---|---|
//! | [`MonteCarlo`] | fresh encounters | wherever it sees anything |
//! | [`SubsetSimulation`] | populations that climb from level to level | where it sees nothing |
//! | [`Importance`] | fresh encounters near those in which a falsifier found failures, weighted | where it knows all ways to fail |

mod box_of_starts;
mod cover;
mod encounters;
mod estimate;
mod estimator;
mod event;
mod importance;
mod lot;
mod monte_carlo;
mod moves;
mod subset_simulation;
mod test_bed;

#[cfg(test)]
mod tests;

pub use box_of_starts::BoxOfStarts;
pub use cover::{CoverConfig, Coverage, Look, Picture, Point, Sampled, cover};
pub use encounters::{Encounters, Question};
pub use estimate::{Estimate, Likelihood};
pub use estimator::{Estimator, Limits};
pub use event::{Event, Events};
pub use importance::{Importance, ImportanceKeys};
pub use lot::Lot;
pub use monte_carlo::{MonteCarlo, MonteCarloKeys};
pub use subset_simulation::{SubsetSimulation, SubsetSimulationKeys};
pub use test_bed::{TestBed, Trial};
