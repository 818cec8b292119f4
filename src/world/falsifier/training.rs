use std::ops::ControlFlow;
use std::sync::Arc;

use super::TrainingRun;
use crate::av::Fault;
use crate::env::Scenario;
use base::seed::Seed;
use learn::{PpoConfig, Trained, UpdateLog};

/// Why a training or a search ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// The learner could not continue, or the observer asked to stop.
    #[error(transparent)]
    Learner(#[from] learn::TrainError),
    #[error("the driver failed again and again until update {update}; the last time it {fault}")]
    Driver { update: u64, fault: Fault },
    #[error("the controller failed in ten episodes in a row; the last time it {fault}")]
    Controller { fault: Fault },
}

impl TrainError {
    /// Whether it ended because the observer asked to stop.
    pub fn is_stopped(&self) -> bool {
        matches!(self, Self::Learner(learn::TrainError::Stopped { .. }))
    }
}

/// Trains a pedestrian in a number of environments of a scenario, each with its own stream of episodes.
///
/// An episode in which the driver fails is cut off without a reward; ten in a row end the training.
///
/// # Errors
/// A loss that is not a number, with its update; a driver that fails in ten episodes in a row; or the break of the observer.
pub fn train(
    scenario: &Arc<Scenario>,
    environments: usize,
    config: &PpoConfig,
    seed: &Seed,
    observer: &mut dyn FnMut(&UpdateLog) -> ControlFlow<()>,
) -> Result<Trained, TrainError> {
    TrainingRun::begin(std::slice::from_ref(scenario), environments, config, seed)?.carry_on(&mut |run| {
        let log = run.learning_curve().last().expect("an update has just ended");
        observer(log)
    })
}
