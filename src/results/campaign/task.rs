use compile::{Campaign, Evaluation};
use world::falsifier::TrainError;

/// A task of a campaign, by its place in the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Task {
    Training(usize),
    /// Some episodes of an evaluation.
    Chunk {
        evaluation: usize,
        /// Which of its chunks, from 0.
        chunk: u32,
    },
    Search(usize),
    Estimate(usize),
    Cover(usize),
    Harden(usize),
}

/// All tasks of a campaign, in its order: trainings, chunks of evaluations, searches, estimates, covers, hardenings.
pub fn tasks(campaign: &Campaign) -> impl Iterator<Item = Task> {
    let chunks = |(evaluation, planned): (usize, &Evaluation)| {
        (0..planned.chunks()).map(move |chunk| Task::Chunk { evaluation, chunk })
    };
    (0..campaign.trainings.len())
        .map(Task::Training)
        .chain(campaign.evaluations.iter().enumerate().flat_map(chunks))
        .chain((0..campaign.searches.len()).map(Task::Search))
        .chain((0..campaign.estimations.len()).map(Task::Estimate))
        .chain((0..campaign.covers.len()).map(Task::Cover))
        .chain((0..campaign.hardenings.len()).map(Task::Harden))
}

/// The size of a task: the decisions of a training with its demonstrations, the episodes of a chunk, the most ticks of a search or an
/// estimate, the episodes of a cover, the ticks of the searches of a hardening.
pub fn units(campaign: &Campaign, task: Task) -> u64 {
    match task {
        Task::Training(place) => {
            let training = &campaign.trainings[place];
            training.demonstrations() + training.config.total_steps
        }
        Task::Chunk { evaluation, chunk } => campaign.evaluations[evaluation].chunk(chunk).len() as u64,
        Task::Search(place) => campaign.searches[place].budget,
        Task::Estimate(place) => campaign.estimations[place].budget,
        Task::Cover(place) => campaign.covers[place].budget.into(),
        Task::Harden(place) => campaign.hardenings[place].budget(),
    }
}

/// Why a task failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// A training could not continue.
    #[error(transparent)]
    Training(#[from] TrainError),
    /// The training of the pedestrian that was to be evaluated failed.
    #[error("its training failed: {0}")]
    Untrained(Box<TaskError>),
    /// The driver or the controller failed in this number of episodes in a row, so no more were run.
    #[error("not run, since the driver or the controller had failed in ten episodes in a row")]
    Hopeless,
    /// No encounter counted.
    #[error("no encounter counts: driver or pedestrian failed, or the driver never arrived")]
    NoEncounter,
    /// It reached its time limit.
    #[error("not finished within the {seconds} s that a task may take")]
    Time {
        /// The limit (s).
        seconds: u64,
    },
    /// It needs more simulator ticks than its limit.
    #[error("not finished within the {ticks} ticks that a task may use")]
    Ticks {
        /// The limit.
        ticks: u64,
    },
}
