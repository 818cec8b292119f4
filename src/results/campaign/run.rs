use std::collections::VecDeque;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rayon::Yield;

use super::chunk::try_chunk;
use super::cover;
use super::estimate::estimate;
use super::harden;
use super::queue::{Next, Queue};
use super::search::search;
use super::{
    CoverResult, EstimateResult, Event, HardenResult, Observer, Progress, ResultStore, SearchResult, Task, TaskError,
    tasks, units,
};
use base::seed::Seed;
use compile::{Campaign, Training, TrainingKey};
use learn::Trained;
use world::falsifier::{TrainError, TrainingRun};

/// Number of decisions of a training between two reports to the observer.
const GLANCE: u64 = 16;

/// How long a thread without a task looks out for parts of the tasks of others after it has done one. The parts of a training follow each other within
/// less, and a thread that sleeps between them hears of none.
const ATTENTION: Duration = Duration::from_millis(1);

/// The result of a training.
#[derive(Debug, Clone)]
pub struct TrainingResult {
    pub key: TrainingKey,
    /// The trained networks, or the error that ended the training.
    pub result: Result<Trained, TaskError>,
}

/// The results of a campaign, except the episodes, which the result store has.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The trainings, in the plan's order. Trainings that never started are missing.
    pub trainings: Vec<TrainingResult>,
    /// The searches, in the plan's order. Searches that never started are missing.
    pub searches: Vec<SearchResult>,
    /// The estimates, in the plan's order. Those that never ended are missing.
    pub estimates: Vec<EstimateResult>,
    /// The covers, in the plan's order. Covers that never started are missing.
    pub covers: Vec<CoverResult>,
    /// The hardenings, in the plan's order. Those that never ended are missing.
    pub hardened: Vec<HardenResult>,
    /// Whether the user asked to stop.
    pub interrupted: bool,
}

/// Runs a campaign on the present rayon pool.
///
/// Every training and every evaluation has its own seed. The seed depends only on the names of its town, policy, reward and run, so other
/// entries of the campaign do not change it. Results that the store already has are not computed again; this does not change any number.
pub fn run(campaign: &Campaign, seed: &Seed, results: &dyn ResultStore, observer: &dyn Observer) -> Finished {
    run_tasks(campaign, &tasks(campaign).collect::<Vec<_>>(), seed, results, observer)
}

/// Runs some tasks of a campaign as [`run`] runs all. A chunk that needs a training brings that training with it.
pub fn run_tasks(
    campaign: &Campaign,
    wanted: &[Task],
    seed: &Seed,
    results: &dyn ResultStore,
    observer: &dyn Observer,
) -> Finished {
    let mut ready = VecDeque::new();
    let mut waiting = vec![Vec::new(); campaign.trainings.len()];
    for task in wanted.iter().copied() {
        match training_of(campaign, task) {
            Some(training) => waiting[training].push(task),
            None => ready.push_back(task),
        }
    }
    let later = waiting.iter().map(Vec::len).sum();
    let work = Work {
        shared: Shared { campaign, seed, results, observer },
        queue: Queue::new(ready, later),
        waiting,
        trainings: campaign.trainings.iter().map(|_| OnceLock::new()).collect(),
        searches: campaign.searches.iter().map(|_| OnceLock::new()).collect(),
        estimates: campaign.estimations.iter().map(|_| OnceLock::new()).collect(),
        covers: campaign.covers.iter().map(|_| OnceLock::new()).collect(),
        hardened: campaign.hardenings.iter().map(|_| OnceLock::new()).collect(),
    };
    rayon::broadcast(|_| work.carry_on());
    Finished {
        trainings: work.trainings.into_iter().filter_map(OnceLock::into_inner).collect(),
        searches: work.searches.into_iter().filter_map(OnceLock::into_inner).collect(),
        estimates: work.estimates.into_iter().filter_map(OnceLock::into_inner).collect(),
        covers: work.covers.into_iter().filter_map(OnceLock::into_inner).collect(),
        hardened: work.hardened.into_iter().filter_map(OnceLock::into_inner).collect(),
        interrupted: observer.stop(),
    }
}

/// Collects what a result store has of a campaign, without running anything.
pub fn collect(campaign: &Campaign, results: &dyn ResultStore) -> Finished {
    let training = |(index, training): (usize, &Training)| {
        let trained = results.training(index)?;
        Some(TrainingResult { key: training.key.clone(), result: Ok(trained) })
    };
    Finished {
        trainings: campaign.trainings.iter().enumerate().filter_map(training).collect(),
        searches: (0..campaign.searches.len()).filter_map(|index| results.search(index)).collect(),
        estimates: (0..campaign.estimations.len()).filter_map(|index| results.estimate(index)).collect(),
        covers: (0..campaign.covers.len()).filter_map(|index| results.cover(index)).collect(),
        hardened: (0..campaign.hardenings.len()).filter_map(|index| results.hardened(index)).collect(),
        interrupted: false,
    }
}

/// Adds the trainings that the store has by now: while this process stopped, another one may have finished them.
pub fn complete(finished: Finished, campaign: &Campaign, results: &dyn ResultStore) -> Finished {
    let mut trainings = finished.trainings;
    for (index, training) in campaign.trainings.iter().enumerate() {
        let place = trainings.iter().position(|result| result.key == training.key);
        if place.is_some_and(|place| trainings[place].result.is_ok()) {
            continue;
        }
        let Some(trained) = results.training(index) else { continue };
        let result = TrainingResult { key: training.key.clone(), result: Ok(trained) };
        match place {
            Some(place) => trainings[place] = result,
            None => trainings.push(result),
        }
    }
    trainings.sort_by_key(|result| campaign.trainings.iter().position(|training| training.key == result.key));
    Finished { trainings, ..finished }
}

/// The seed of a training.
pub(super) fn training_seed(seed: &Seed, key: &TrainingKey) -> Seed {
    seed.child("train").child(&key.town).child(&key.policy).child(&key.reward).index(key.run.into())
}

/// The training that a task waits for.
pub(super) fn training_of(campaign: &Campaign, task: Task) -> Option<usize> {
    match task {
        Task::Chunk { evaluation, .. } => campaign.evaluations[evaluation].training(),
        _ => None,
    }
}

/// What all tasks of a campaign share.
#[derive(Clone, Copy)]
pub(super) struct Shared<'a> {
    pub campaign: &'a Campaign,
    /// The user's seed.
    pub seed: &'a Seed,
    pub results: &'a dyn ResultStore,
    pub observer: &'a dyn Observer,
}

impl Shared<'_> {
    pub fn tell(&self, event: Event<'_>) {
        self.observer.event(&event);
    }

    pub fn tell_reused(&self, task: Task) {
        self.tell(Event::Reused { task, units: units(self.campaign, task) });
    }

    /// Whether no further work starts.
    pub fn stop(&self) -> bool {
        self.observer.stop() || self.results.stop()
    }
}

/// The state of the workers.
struct Work<'a> {
    shared: Shared<'a>,
    queue: Queue,
    /// The tasks that wait for each training.
    waiting: Vec<Vec<Task>>,
    trainings: Vec<OnceLock<TrainingResult>>,
    searches: Vec<OnceLock<SearchResult>>,
    estimates: Vec<OnceLock<EstimateResult>>,
    covers: Vec<OnceLock<CoverResult>>,
    hardened: Vec<OnceLock<HardenResult>>,
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

impl Work<'_> {
    /// Works until no task is left or the user asks to stop. A worker without work helps with the trainings of others.
    fn carry_on(&self) {
        let _alarm = Alarm(&self.queue);
        let mut helped = Instant::now();
        loop {
            if self.shared.stop() {
                self.queue.end();
            }
            match self.queue.next() {
                Next::Work(task) => match self.shared.results.claim(task) {
                    Some(_claim) => {
                        self.work_on(task);
                        let released =
                            if let Task::Training(index) = task { self.waiting[index].as_slice() } else { &[] };
                        self.queue.done(released);
                    }
                    None => self.queue.put_aside(task),
                },
                Next::Wait => {
                    if rayon::yield_now() == Some(Yield::Executed) {
                        helped = Instant::now();
                    } else if helped.elapsed() > ATTENTION {
                        self.queue.wait();
                    } else {
                        std::hint::spin_loop();
                    }
                }
                Next::End => return,
            }
        }
    }

    fn work_on(&self, task: Task) {
        match task {
            Task::Training(index) => drop(self.trainings[index].set(self.train(index))),
            Task::Chunk { evaluation, chunk } => self.evaluate(evaluation, chunk),
            Task::Search(index) => {
                if let Some(result) = self.search(index) {
                    let _ = self.searches[index].set(result);
                }
            }
            Task::Estimate(index) => {
                if let Some(result) = self.estimate(index) {
                    let _ = self.estimates[index].set(result);
                }
            }
            Task::Cover(index) => {
                if let Some(result) = self.cover(index) {
                    let _ = self.covers[index].set(result);
                }
            }
            Task::Harden(index) => {
                if let Some(result) = self.harden(index) {
                    let _ = self.hardened[index].set(result);
                }
            }
        }
    }

    fn train(&self, index: usize) -> TrainingResult {
        let plan = &self.shared.campaign.trainings[index];
        let key = plan.key.clone();
        if let Some(trained) = self.shared.results.training(index) {
            self.shared.tell(Event::CurveBefore { training: index, plan, curve: &trained.learning_curve });
            self.shared.tell_reused(Task::Training(index));
            return TrainingResult { key, result: Ok(trained) };
        }
        self.shared.tell(Event::Begun(Task::Training(index)));
        let result = TrainingResult { key, result: self.carry_out(index, plan) };
        self.shared.tell(Event::Trained { training: index, result: &result });
        result
    }

    fn carry_out(&self, index: usize, plan: &Training) -> Result<Trained, TaskError> {
        let Shared { seed, results, .. } = self.shared;
        let task = Task::Training(index);
        let key = &plan.key;
        let scenarios = plan.scenarios();
        let seed = training_seed(seed, key);
        let (environments, config) = (plan.environments, &plan.config);
        let watch = |share: f64| {
            let decisions = (share * plan.demonstrations() as f64) as u64;
            self.shared.tell(Event::Deciding { training: index, decisions });
            results.is_overdue(task, self.shared.stop())
        };
        let begin = || match &plan.drive {
            None => TrainingRun::begin(&scenarios, environments, config, &seed),
            Some(rule) => TrainingRun::begin_driving(&scenarios, rule, environments, config, &seed, &watch),
        };
        let resume = |state: Vec<u8>| {
            TrainingRun::resume(&state, &scenarios, plan.drive.as_ref(), environments, config, &seed).ok()
        };
        // A stop that the user did not ask for is the limit of the task.
        let ended = |error: TrainError| {
            let limited = error.is_stopped() && !self.shared.stop();
            limited.then(|| results.limit(task, 0)).flatten().unwrap_or(TaskError::Training(error))
        };
        // A state that does not fit counts as missing: the training restarts.
        let begun = results.begun(index).and_then(resume);
        let taken = |run: &TrainingRun| plan.demonstrations() + run.learning_curve().last().map_or(0, |log| log.steps);
        let before = begun.as_ref().map_or(0, taken);
        self.shared.tell(Event::Continued { task, units: before });
        let mut run = match begun {
            Some(run) => run,
            None => {
                // An imitation is not begun for nothing.
                if let Some(limit @ TaskError::Ticks { .. }) = results.limit(task, plan.ticks(0)) {
                    return Err(limit);
                }
                begin().map_err(ended)?
            }
        };
        self.shared.tell(Event::CurveBefore { training: index, plan, curve: run.learning_curve() });
        let decisions = AtomicU64::new(taken(&run) - before);
        while !run.is_done() {
            // A slow driver may need minutes for an update. Then the work of the update is lost.
            let overdue = || {
                let taken = decisions.fetch_add(1, Ordering::Relaxed);
                if taken.is_multiple_of(GLANCE) {
                    self.shared.tell(Event::Deciding { training: index, decisions: taken });
                }
                results.is_overdue(task, self.shared.stop())
            };
            run.update_unless(&overdue).map_err(ended)?;
            let log = run.learning_curve().last().expect("an update has just ended");
            self.shared.tell(Event::Updated { training: index, plan, curve: run.learning_curve() });
            let update = log.update;
            if let Some(limit) = results.limit(task, plan.ticks(log.steps)).filter(|_| !run.is_done()) {
                results.checkpoint(index, &run, true);
                return Err(limit);
            }
            let stop = self.shared.stop() && !run.is_done();
            results.checkpoint(index, &run, stop);
            if stop {
                return Err(TaskError::Training(learn::TrainError::Stopped { update }.into()));
            }
        }
        results.keep_training(index, &run);
        Ok(run.finish())
    }

    fn evaluate(&self, evaluation: usize, chunk: u32) {
        let plan = &self.shared.campaign.evaluations[evaluation];
        let trained = match plan.training().and_then(|training| self.trainings[training].get()) {
            Some(TrainingResult { result: Ok(trained), .. }) => Some(&trained.actor_critic),
            // A training that was stopped continues in a later run.
            Some(TrainingResult { result: Err(TaskError::Training(error)), .. }) if error.is_stopped() => return,
            Some(TrainingResult { result: Err(error), .. }) => {
                let error = TaskError::Untrained(Box::new(error.clone()));
                self.shared.results.keep_episodes(evaluation, chunk, &[], Progress::Failed(&error));
                return self.shared.tell(Event::Evaluated { evaluation, chunk, error: Some(&error) });
            }
            None => None,
        };
        try_chunk(self.shared, evaluation, chunk, trained);
    }

    fn search(&self, index: usize) -> Option<SearchResult> {
        if let Some(result) = self.shared.results.search(index) {
            self.shared.tell_reused(Task::Search(index));
            return Some(result);
        }
        let result = search(self.shared, index)?;
        if result.error.is_none() && !result.spent.stopped {
            self.shared.results.keep_search(index, &result);
        }
        self.shared.tell(Event::Searched { search: index, result: &result });
        Some(result)
    }

    fn estimate(&self, index: usize) -> Option<EstimateResult> {
        if let Some(result) = self.shared.results.estimate(index) {
            self.shared.tell_reused(Task::Estimate(index));
            return Some(result);
        }
        let result = estimate(self.shared, index)?;
        if result.error.is_none() {
            self.shared.results.keep_estimate(index, &result);
        }
        self.shared.tell(Event::Estimated { estimation: index, result: &result });
        Some(result)
    }

    fn cover(&self, index: usize) -> Option<CoverResult> {
        if let Some(result) = self.shared.results.cover(index) {
            self.shared.tell_reused(Task::Cover(index));
            return Some(result);
        }
        let result = cover::carry_out(self.shared, index)?;
        if result.error.is_none() && !result.found.coverage.stopped {
            self.shared.results.keep_cover(index, &result);
        }
        self.shared.tell(Event::Covered { cover: index, result: &result });
        Some(result)
    }

    fn harden(&self, index: usize) -> Option<HardenResult> {
        if let Some(result) = self.shared.results.hardened(index) {
            self.shared.tell_reused(Task::Harden(index));
            return Some(result);
        }
        let result = harden::carry_out(self.shared, index)?;
        if result.error.is_none() {
            self.shared.results.keep_hardened(index, &result);
        }
        self.shared.tell(Event::Hardened { harden: index, result: &result });
        Some(result)
    }
}
