use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::learnt::Learnt;
use compile::Campaign;
use learn::UpdateLog;
use results::campaign::Task;
use results::jobs::{Kind, work};

/// Units of a part of a job.
#[derive(Debug)]
struct Part {
    done: u64,
    total: u64,
}

/// A job of a campaign, and how far it is.
#[derive(Debug)]
pub struct Job {
    pub kind: &'static Kind,
    /// Its place in the campaign.
    pub place: usize,
    /// Its place among those of its kind.
    pub number: usize,
    /// Controller, town and driver.
    pub name: String,
    /// The amount to do in this run, in units of its kind.
    pub total: u64,
    /// The first error of its tasks.
    pub error: Option<String>,
    parts: BTreeMap<u32, Part>,
    before: u64,
    /// The number of its tasks that have not ended.
    open: usize,
    begun: Option<Instant>,
    took: Option<Duration>,
    /// What the trainings of its parts have learnt.
    learnt: BTreeMap<u32, Learnt>,
    /// What came of its parts, for people.
    notes: BTreeMap<u32, String>,
}

impl Job {
    /// Makes the jobs of a campaign, in the plan's order, of which only some tasks are done here; those without any are left out.
    pub fn all(campaign: &Campaign, wanted: &[Task]) -> Vec<Self> {
        let mut jobs: Vec<Self> = Vec::new();
        for task in wanted {
            if jobs.last().is_none_or(|last| last.place != task.job) {
                jobs.push(Self::new(campaign, task.job));
            }
            let job = jobs.last_mut().expect("one was put there");
            job.total += task.units(campaign);
            job.parts.insert(task.part, Part { done: 0, total: task.units(campaign) });
            job.open += 1;
        }
        jobs
    }

    fn new(campaign: &Campaign, place: usize) -> Self {
        let job = work(&campaign.jobs[place]);
        let kind = job.kind();
        let is_same = |other: &&compile::Job| work(other).kind() == kind;
        Self {
            kind,
            place,
            number: campaign.jobs[..place].iter().filter(is_same).count(),
            name: job.title(),
            total: 0,
            error: None,
            parts: BTreeMap::new(),
            before: 0,
            open: 0,
            begun: None,
            took: None,
            learnt: BTreeMap::new(),
            notes: BTreeMap::new(),
        }
    }

    /// Starts it, if it has not started; returns whether it starts now.
    pub fn begin(&mut self) -> bool {
        let first = self.begun.is_none();
        self.begun.get_or_insert_with(Instant::now);
        first
    }

    /// Counts units of a part that were done before it started.
    pub fn found(&mut self, part: u32, units: u64) {
        self.before += units;
        self.rise(part, units);
    }

    /// All of a part was done before it started.
    pub fn found_all(&mut self, part: u32) {
        self.found(part, self.parts[&part].total);
    }

    /// Raises the number of units that are done of a part. Its threads report it in any order.
    pub fn rise(&mut self, part: u32, units: u64) {
        self.reach(part, self.parts[&part].done.max(units));
    }

    /// Sets the number of units that are done of a part.
    pub fn reach(&mut self, part: u32, units: u64) {
        if let Some(part) = self.parts.get_mut(&part) {
            part.done = units;
        }
    }

    /// Notes the learning curve of a part, a training, up to now.
    pub fn learn(&mut self, part: u32, curve: &[UpdateLog]) {
        self.learnt.entry(part).or_default().follow(curve);
    }

    /// What the last of its trainings has learnt up to now; `None` for other jobs and before the first update.
    pub fn learnt(&self) -> Option<Learnt> {
        self.learnt.values().rfind(|learnt| learnt.updates > 0).copied()
    }

    /// Notes what came of a part.
    pub fn note(&mut self, part: u32, note: String) {
        self.notes.insert(part, note);
    }

    /// What came of its parts up to now.
    pub fn told(&self) -> String {
        let learnt = self.learnt().map(|learnt| learnt.told().unwrap_or_else(|| "no episode ended".into()));
        let notes = self.notes.values().filter(|note| !note.is_empty()).cloned();
        learnt.into_iter().chain(notes).collect::<Vec<_>>().join(", ")
    }

    /// Ends one of its tasks; returns whether that was the last.
    pub fn end_task(&mut self, error: Option<String>) -> bool {
        self.open = self.open.saturating_sub(1);
        self.error = self.error.take().or(error);
        let last = self.open == 0 && self.took.is_none();
        if last {
            self.took = Some(self.time());
        }
        last
    }

    /// The number of units that are done.
    pub fn done(&self) -> u64 {
        self.parts.values().map(|part| part.done).sum::<u64>().min(self.total)
    }

    /// The number of units that were done before this run of the program.
    pub fn before(&self) -> u64 {
        self.before.min(self.total)
    }

    /// Whether it has started and not ended.
    pub fn is_under_way(&self) -> bool {
        self.begun.is_some() && self.took.is_none()
    }

    pub fn is_ended(&self) -> bool {
        self.took.is_some()
    }

    /// Its time, up to now or to its end.
    pub fn time(&self) -> Duration {
        self.took.or_else(|| self.begun.map(|begun| begun.elapsed())).unwrap_or_default()
    }

    /// Whether all of it was done before this run of the program.
    pub fn is_old(&self) -> bool {
        self.before() >= self.total
    }

    /// Units per second; `None` before the first measurement.
    pub fn rate(&self) -> Option<f64> {
        let units = self.done().saturating_sub(self.before()) as f64;
        let time = self.time().as_secs_f64();
        (units > 0.0 && time > 0.0).then(|| units / time)
    }

    /// Estimated time until it ends at this rate.
    pub fn left(&self) -> Option<Duration> {
        self.rate().map(|rate| Duration::from_secs_f64((self.total - self.done()) as f64 / rate))
    }
}
