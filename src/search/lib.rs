//! Methods that search for collisions, what learns, and what is counted and improved by many episodes.
//!
//! A [`Falsifier`] is a method with a budget of simulator ticks, from random walks to learning by PPO; a [`BudgetedSimulation`] counts the ticks and
//! stores what the method finds. All of them know an environment by the dimensions of its states and actions, not by the number of its pedestrians.

mod crossing;
mod crossings;
pub mod driving;
mod training;
mod start_set;
mod failure;
mod budgeted_simulation;
mod method;
mod optimizer;
mod controlled;
mod open_loop;
mod tree_search;
mod exhaustive;
mod archive;
mod learning;
pub mod likelihood;
pub mod hardening;

pub use archive::{Archive, ArchiveSearch};
pub use budgeted_simulation::{BudgetedSimulation, SearchOutcome};
pub use controlled::{Controlled, ControlledKeys};
pub use crossing::{Crossing, Goal};
pub use crossings::evaluate_crossings;
pub use exhaustive::{Exhaustive, crossings};
pub use failure::Failure;
pub use learning::{Learning, LearningKeys};
pub use method::{Falsifier, Searched};
pub use open_loop::OpenLoop;
pub use start_set::StartSet;
pub use training::{HardStarts, PedestrianEnv, StartBank, TrainError, TrainingRun, first_networks};
pub use tree_search::TreeSearch;
