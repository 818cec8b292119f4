//! Pedestrians that look for a collision, and methods that search for one.
//!
//! A [`Walker`] chooses commands as it goes; [`try_walker`] tries it. A [`Falsifier`] is a method with a budget of simulator
//! ticks, from walking at random to learning by PPO; a [`Simulator`] counts for it and keeps what it finds.

mod walker;
mod training;
mod training_run;
mod trained;
mod random;
mod homing;
mod intercept;
mod episodes;

mod method;
mod simulator;
mod failure;
mod walking;
mod optimizer;
mod open_loop;
mod tree_search;
mod learning;

pub use episodes::{try_walker, watch_walker};
pub use failure::{Failure, follow};
pub use homing::Homing;
pub use intercept::Intercept;
pub use learning::Learning;
pub use method::Falsifier;
pub use open_loop::OpenLoop;
pub use random::Random;
pub use simulator::{Simulator, Spent};
pub use trained::{Choosing, TrainedWalker};
pub use training::{TrainError, train};
pub use training_run::TrainingRun;
pub use tree_search::TreeSearch;
pub use walker::Walker;
pub use walking::Walking;
