//! Pedestrians that look for a collision, and trying them: one interface for trained and untrained ones.

mod walker;
mod optimizer;
mod trained;
mod random;
mod homing;
mod intercept;
mod episodes;

pub use episodes::try_walker;
pub use homing::Homing;
pub use intercept::Intercept;
pub use random::Random;
pub use trained::{Choosing, TrainedWalker, train};
pub use walker::Walker;
