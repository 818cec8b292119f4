use std::time::{Duration, Instant};

use super::job::Job;
use compile::Campaign;
use results::campaign::Task;
use results::jobs::{KINDS, Kind};

/// All jobs of a campaign that are done here.
#[derive(Debug)]
pub struct Board {
    pub campaign: String,
    /// The time of its start.
    pub began: Instant,
    /// The jobs, in the plan's order.
    pub jobs: Vec<Job>,
    threads: usize,
}

impl Board {
    /// Makes the pieces of some tasks of a campaign, for this number of threads.
    pub fn new(campaign: &Campaign, wanted: &[Task], threads: usize) -> Self {
        Self { campaign: campaign.name.clone(), began: Instant::now(), jobs: Job::all(campaign, wanted), threads }
    }

    /// The place of a task's job.
    pub fn place(&self, task: Task) -> usize {
        let place = self.jobs.binary_search_by_key(&task.job, |job| job.place);
        place.expect("only what is wanted is done")
    }

    pub fn job(&mut self, task: Task) -> &mut Job {
        let place = self.place(task);
        &mut self.jobs[place]
    }

    /// The number of jobs of a kind.
    pub fn count(&self, kind: &Kind) -> usize {
        self.jobs.iter().filter(|job| job.kind == kind).count()
    }

    /// How many jobs have ended.
    pub fn ended(&self) -> usize {
        self.jobs.iter().filter(|job| job.is_ended()).count()
    }

    /// Estimated time until all is done, from the average time of a unit of each kind. A kind without a measurement is as much slower or faster
    /// than usual as the measured ones are. `None` before the first measurement.
    pub fn left(&self) -> Option<Duration> {
        let (mut seconds, mut unknown, mut usual, mut busy) = (0.0, 0.0, 0.0, 0.0);
        for kind in KINDS {
            let of_kind = || self.jobs.iter().filter(move |job| job.kind == kind);
            let left: u64 = of_kind().filter(|job| !job.is_ended()).map(|job| job.total - job.done()).sum();
            let done: u64 = of_kind().map(|job| job.done().saturating_sub(job.before())).sum();
            let time: f64 = of_kind().map(|job| job.time().as_secs_f64()).sum();
            if done == 0 {
                unknown += left as f64 * kind.seconds;
                continue;
            }
            seconds += time / done as f64 * left as f64;
            usual += done as f64 * kind.seconds;
            busy += time;
        }
        if usual == 0.0 {
            return None;
        }
        seconds += unknown * busy / usual;
        // A job is worked on by one thread: the last ones may leave others idle.
        let last = self.jobs.iter().filter(|job| job.is_under_way()).filter_map(Job::left).max();
        Some(Duration::from_secs_f64(seconds / self.threads.max(1) as f64).max(last.unwrap_or_default()))
    }
}
