//! Policies of pedestrians that aim at a collision, and methods that search for collisions.
//!
//! A [`WalkPolicy`] chooses commands decision by decision; [`evaluate`] evaluates it. A [`Falsifier`] is a method with a budget of
//! simulator ticks, from random walks to learning by PPO; a [`BudgetedSimulation`] counts the ticks and stores what the method finds. All of
//! them know an environment by the dimensions of its states and actions, not by the number of its pedestrians.

mod walk_policy;
mod fault_streak;
mod training;
mod trained;
mod random;
mod homing;
mod intercept;
mod natural;
mod social_force;
mod recorded_walking;
mod scripted;
mod outside;
mod controlled;
mod drive;
mod episodes;

mod method;
mod start_set;
mod budgeted_simulation;
mod failure;
pub(crate) mod optimizer;
mod open_loop;
mod tree_search;
mod crossing;
mod crossings;
mod archive;
mod exhaustive;
mod learning;

pub use archive::{Archive, ArchiveSearch};
pub use budgeted_simulation::{BudgetedSimulation, SearchOutcome};
pub use controlled::{Controlled, ControlledKeys, Controller};
pub use crossing::{Crossing, Goal};
pub use crossings::evaluate_crossings;
pub use drive::play;
pub(crate) use drive::{advance, place};
pub use episodes::{evaluate, evaluate_observed};
pub use exhaustive::{Exhaustive, crossings};
pub(crate) use failure::Recorded;
pub use failure::{Failure, follow, recorded_commands, walk_again};
pub use fault_streak::FaultStreak;
pub use homing::{Homing, HomingKeys};
pub use intercept::{Intercept, InterceptKeys};
pub use learning::{Learning, LearningKeys};
pub use method::{Falsifier, Searched};
pub use natural::{Forces, Gaps, Natural, NaturalKeys, Recording, log_likelihood};
pub use open_loop::OpenLoop;
pub use outside::{
    Networked, NetworkedKeys, PROTOCOL, Programmed, ProgrammedKeys, UnsuitableNetwork, network_differs, network_fits,
};
pub use random::{Random, RandomKeys};
pub use recorded_walking::RecordedWalking;
pub use scripted::{Scripted, ScriptedKeys};
pub use start_set::StartSet;
pub use trained::{ActionMode, TrainedWalker};
pub use training::{HardStarts, PedestrianEnv, StartBank, TrainError, TrainingRun, first_networks};
pub use tree_search::TreeSearch;
pub use walk_policy::WalkPolicy;
