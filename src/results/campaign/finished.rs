use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::fmt;

use super::{Part, ResultStore, Silent, Task};
use crate::jobs::{JobResult, work};
use base::seed::Seed;
use compile::Campaign;

/// The results of a campaign, except the episodes, which the result store has.
#[derive(Default)]
pub struct Finished {
    /// The results of each type as a vector.
    results: BTreeMap<TypeId, Box<dyn Any + Send + Sync>>,
    /// Whether every job whose result is here is whole.
    pub is_whole: bool,
    /// Whether a report would show nothing of them.
    pub is_empty: bool,
    /// Whether one of them ended with an error.
    pub has_failed: bool,
    /// Whether the user asked to stop.
    pub interrupted: bool,
}

/// A result that knows its own type.
pub trait Collect {
    /// Adds it to the others of its type.
    fn collect(self: Box<Self>, finished: &mut Finished);
}

impl<T: JobResult> Collect for T {
    fn collect(self: Box<Self>, finished: &mut Finished) {
        let all = finished.results.entry(TypeId::of::<T>()).or_insert_with(|| Box::new(Vec::<T>::new()));
        all.downcast_mut::<Vec<T>>().expect("the vector is of this type").push(*self);
    }
}

impl Finished {
    /// All results of a type, in the plan's order. Those of jobs that never ended are missing.
    pub fn all<T: JobResult>(&self) -> &[T] {
        let all = self.results.get(&TypeId::of::<T>()).and_then(|all| all.downcast_ref::<Vec<T>>());
        all.map_or(&[], Vec::as_slice)
    }

    /// The results of a campaign's jobs, by their places.
    pub(super) fn new(campaign: &Campaign, results: Vec<Option<Box<dyn JobResult>>>, interrupted: bool) -> Self {
        let mut finished = Self { is_whole: true, is_empty: true, interrupted, ..Self::default() };
        let reported = campaign.jobs.iter().zip(results).filter(|(job, _)| !work(job).kind().has_episodes);
        for (_, result) in reported {
            finished.is_whole &= result.as_ref().is_some_and(|result| result.is_whole());
            if let Some(result) = result {
                finished.is_empty &= !result.is_shown();
                finished.has_failed |= result.error().is_some();
                result.collect(&mut finished);
            }
        }
        finished
    }
}

impl fmt::Debug for Finished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Finished").field("interrupted", &self.interrupted).finish_non_exhaustive()
    }
}

/// Collects what a result store has of a campaign, without running anything.
pub fn collect(campaign: &Campaign, seed: &Seed, results: &dyn ResultStore) -> Finished {
    let stored = |place| read(campaign, place, seed, results);
    Finished::new(campaign, (0..campaign.jobs.len()).map(stored).collect(), false)
}

/// The stored result of a job; `None` for a job whose results are episodes.
pub(super) fn read(
    campaign: &Campaign,
    place: usize,
    seed: &Seed,
    results: &dyn ResultStore,
) -> Option<Box<dyn JobResult>> {
    let job = work(&campaign.jobs[place]);
    let ended = &Vec::new();
    let part = |part| Part { task: Task { job: place, part }, seed, results, observer: &Silent, ended };
    if job.kind().has_episodes {
        None
    } else {
        job.join((0..job.parts()).map(|number| job.read(&part(number))).collect())
    }
}
