//! Pedestrians that look for a collision, and trying them: one interface for trained and untrained ones.

mod walker;
mod training_run;
mod trained;
mod random;
mod intercept;
mod episodes;

pub use episodes::{try_walker, watch_walker};
pub use intercept::Intercept;
pub use random::Random;
pub use trained::{Choosing, TrainedWalker, train};
pub use training_run::TrainingRun;
pub use walker::Walker;
