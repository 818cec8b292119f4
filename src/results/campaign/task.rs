use compile::{Campaign, Job};
use search::TrainError;

/// A task of a campaign: a part of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Task {
    /// The place of the job in [`Campaign::jobs`].
    pub job: usize,
    /// Which of its parts, from 0.
    pub part: u32,
}

impl Task {
    /// Its size, in units of its kind.
    pub fn units(self, campaign: &Campaign) -> u64 {
        campaign.jobs[self.job].planned().units(self.part)
    }
}

/// All tasks of a campaign, in its order.
pub fn tasks(campaign: &Campaign) -> impl Iterator<Item = Task> {
    campaign.jobs.iter().enumerate().flat_map(|(job, planned)| parts(job, planned))
}

pub(super) fn parts(place: usize, job: &Job) -> impl Iterator<Item = Task> + use<> {
    (0..job.planned().parts()).map(move |part| Task { job: place, part })
}

/// Why a task failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// A training could not continue.
    #[error(transparent)]
    Training(#[from] TrainError),
    #[error("its training failed: {0}")]
    Untrained(Box<TaskError>),
    #[error("not run, since the driver or the pedestrian had failed in ten episodes in a row")]
    Hopeless,
    #[error("no episode counts: driver or pedestrian failed, or the driver never arrived")]
    NoEncounter,
    #[error(
        "refused: a car that never brakes failed in none of {points} starts of the box, so it says nothing of drivers that brake; give the `episode` more \
         `ticks`, or the box starts from which the pedestrian reaches the car"
    )]
    CannotFail { points: u64 },
    #[error("not finished within the {seconds} s that a task may take")]
    Time {
        /// The limit (s).
        seconds: u64,
    },
    #[error("not finished within the {ticks} ticks that a task may use")]
    Ticks { ticks: u64 },
}
