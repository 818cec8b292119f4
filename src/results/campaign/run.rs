use std::collections::VecDeque;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use rayon::Yield;

use super::finished::read;
use super::part::Results;
use super::queue::{Next, Queue};
use super::{Event, Finished, Observer, Part, ResultStore, Task, tasks};
use crate::jobs::{JobResult, work};
use base::seed::Seed;
use compile::{Campaign, Job};

/// How long a thread without a task looks out for parts of the tasks of others after it has done one. The parts of a training follow each other within
/// less, and a thread that sleeps between them misses all.
const SPIN_TIME: Duration = Duration::from_millis(1);

/// Runs a campaign on the present rayon pool.
///
/// Every job has its own seed. The seed depends only on names such as those of its town, policy, reward and run, so other
/// entries of the campaign do not change it. Results that the store already has are not computed again; this does not change any number.
pub fn run(campaign: &Campaign, seed: &Seed, results: &dyn ResultStore, observer: &dyn Observer) -> Finished {
    run_tasks(campaign, &tasks(campaign).collect::<Vec<_>>(), seed, results, observer)
}

/// Runs some tasks of a campaign as [`run`] runs all. The tasks of the jobs that they need are among them.
pub fn run_tasks(
    campaign: &Campaign,
    wanted: &[Task],
    seed: &Seed,
    results: &dyn ResultStore,
    observer: &dyn Observer,
) -> Finished {
    let mut ready = VecDeque::new();
    let mut waiting = vec![Vec::new(); campaign.jobs.len()];
    for task in wanted.iter().copied() {
        match campaign.jobs[task.job].origin().needs {
            Some(needed) => waiting[needed].push(task),
            None => ready.push_back(task),
        }
    }
    let later = waiting.iter().map(Vec::len).sum();
    let open = |job| wanted.iter().filter(|task| task.job == job).count();
    let parts = |(job, planned): (usize, &Job)| {
        let results = (0..planned.planned().parts()).map(|_| None).collect();
        Mutex::new(Parts { results, open: open(job) })
    };
    let workers = Workers {
        campaign,
        seed,
        results,
        observer,
        queue: Queue::new(ready, later),
        waiting,
        parts: campaign.jobs.iter().enumerate().map(parts).collect(),
        ended: campaign.jobs.iter().map(|_| OnceLock::new()).collect(),
    };
    rayon::broadcast(|_| workers.carry_on());
    let interrupted = observer.stop();
    // While this process stopped, another one may have finished a job.
    let ended = workers.ended.into_iter().enumerate().map(|(job, ended)| {
        let ended = ended.into_inner();
        let is_missing = interrupted && !ended.as_ref().is_some_and(|result| result.is_whole());
        is_missing.then(|| read(campaign, job, seed, results)).flatten().or(ended)
    });
    Finished::new(campaign, ended.collect(), interrupted)
}

/// The state of the workers.
struct Workers<'a> {
    campaign: &'a Campaign,
    seed: &'a Seed,
    results: &'a dyn ResultStore,
    observer: &'a dyn Observer,
    queue: Queue,
    /// The tasks that wait for each job.
    waiting: Vec<Vec<Task>>,
    parts: Vec<Mutex<Parts>>,
    ended: Results,
}

/// The parts of a job.
struct Parts {
    /// What came of each.
    results: Vec<Option<Box<dyn JobResult>>>,
    /// The number of those that have not ended.
    open: usize,
}

/// Ends all workers when one of them panics, so that none waits for it.
struct Alarm<'a>(&'a Queue);

impl Drop for Alarm<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.end();
        }
    }
}

impl Workers<'_> {
    /// Works until no task is left or the user asks to stop. A worker without work helps with the trainings of others.
    fn carry_on(&self) {
        let _alarm = Alarm(&self.queue);
        let mut helped = Instant::now();
        loop {
            if self.observer.stop() || self.results.stop() {
                self.queue.end();
            }
            match self.queue.next() {
                Next::Work(task) => match self.results.claim(task) {
                    Some(_claim) => {
                        let is_last = self.work_on(task);
                        self.queue.done(if is_last { &self.waiting[task.job] } else { &[] });
                    }
                    None => self.queue.put_aside(task),
                },
                Next::Wait => {
                    if rayon::yield_now() == Some(Yield::Executed) {
                        helped = Instant::now();
                    } else if helped.elapsed() > SPIN_TIME {
                        self.queue.wait();
                    } else {
                        std::hint::spin_loop();
                    }
                }
                Next::End => return,
            }
        }
    }

    /// Works on a task, and returns whether it was the last of its job.
    fn work_on(&self, task: Task) -> bool {
        let Self { campaign, seed, results, observer, ended, .. } = self;
        let job = work(&campaign.jobs[task.job]);
        let part = Part { task, seed, results: *results, observer: *observer, ended };
        if let Some(result) = job.read(&part) {
            observer.event(&Event::Reused { task, result: result.as_ref() });
            return self.end(task, Some(result));
        }
        let result = if part.stop() { None } else { job.run(&part) };
        if let Some(result) = &result {
            if result.is_whole()
                && let Some(bytes) = result.encode()
            {
                part.finish(result.units(), bytes);
            }
            observer.event(&Event::Ended { task, result: result.as_ref() });
        }
        self.end(task, result)
    }

    /// Keeps what came of a task; the last one of a job ends the job. Returns whether it was the last.
    fn end(&self, task: Task, result: Option<Box<dyn JobResult>>) -> bool {
        let mut parts = self.parts[task.job].lock().unwrap_or_else(PoisonError::into_inner);
        parts.results[task.part as usize] = result;
        parts.open -= 1;
        if parts.open > 0 {
            return false;
        }
        if let Some(whole) = work(&self.campaign.jobs[task.job]).join(std::mem::take(&mut parts.results)) {
            let _ = self.ended[task.job].set(whole);
        }
        true
    }
}
