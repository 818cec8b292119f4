use world::av::Fault;

/// Why a training or a search ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// The learner could not continue, or the observer asked to stop.
    #[error(transparent)]
    Learner(#[from] learn::TrainError),
    #[error("the driver failed again and again until update {update}; the last time it {fault}")]
    Driver { update: u64, fault: Fault },
    #[error("the pedestrian failed in ten episodes in a row; the last time it {fault}")]
    Controller { fault: Fault },
}

impl TrainError {
    /// Whether it ended because the observer asked to stop.
    pub fn is_stopped(&self) -> bool {
        matches!(self, Self::Learner(learn::TrainError::Stopped { .. }))
    }
}
