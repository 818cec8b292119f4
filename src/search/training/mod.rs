//! Trainings of pedestrians and of drivers: simulations as environments of the learner.

mod train_error;
mod start_bank;
mod agents;
mod pedestrian_env;
mod training_ground;
mod hard_start;
mod training_run;

pub(super) use agents::Agents;
pub use pedestrian_env::PedestrianEnv;
pub use start_bank::{HardStarts, StartBank};
pub use train_error::TrainError;
pub use training_run::{TrainingRun, first_networks};
