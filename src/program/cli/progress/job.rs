use std::time::{Duration, Instant};

use super::learnt::Learnt;
use compile::{Campaign, ControllerKind, Evaluation, NO_REWARD};
use learn::UpdateLog;
use results::campaign::{Task, units};

/// What a job of work is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A training.
    Training,
    /// An evaluation.
    Evaluation,
    /// A search.
    Search,
    /// An estimate.
    Estimate,
    /// A cover.
    Cover,
    /// A hardening.
    Harden,
}

impl Kind {
    /// The verb for a piece under way.
    pub fn doing(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Evaluation => "trying",
            Self::Search => "searching",
            Self::Estimate => "estimating",
            Self::Cover => "covering",
            Self::Harden => "hardening",
        }
    }

    /// The verb for a finished piece.
    pub fn done(self) -> &'static str {
        match self {
            Self::Training => "trained",
            Self::Evaluation => "tried",
            Self::Search => "searched",
            Self::Estimate => "estimated",
            Self::Cover => "covered",
            Self::Harden => "hardened",
        }
    }

    /// The unit that is counted.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Training => "decisions",
            Self::Evaluation | Self::Cover => "episodes",
            Self::Search | Self::Estimate | Self::Harden => "ticks",
        }
    }
}

/// A job of a campaign's work: a training, an evaluation, a search or a cover.
#[derive(Debug)]
pub struct Job {
    /// What it is.
    pub kind: Kind,
    /// Its place among those of its kind.
    pub place: usize,
    /// Controller, town and driver.
    pub name: String,
    /// The amount to do in this run, in units of its kind.
    pub total: u64,
    /// The first error of its tasks.
    pub error: Option<String>,
    done: u64,
    before: u64,
    /// The number of its tasks that have not ended.
    open: usize,
    begun: Option<Instant>,
    took: Option<Duration>,
    learnt: Learnt,
}

impl Job {
    /// Makes the jobs of a campaign, in the plan's order, of which only some tasks are done here; those without any are left out.
    pub fn all(campaign: &Campaign, wanted: &[Task]) -> Vec<Self> {
        let mut jobs: Vec<Self> = Vec::new();
        for task in wanted {
            let (kind, place) = Self::of(*task);
            if jobs.last().is_none_or(|last| (last.kind, last.place) != (kind, place)) {
                jobs.push(Self::new(campaign, kind, place));
            }
            let job = jobs.last_mut().expect("one was put there");
            job.total += units(campaign, *task);
            job.open += 1;
        }
        jobs
    }

    /// The job that a task belongs to.
    pub fn of(task: Task) -> (Kind, usize) {
        match task {
            Task::Training(place) => (Kind::Training, place),
            Task::Chunk { evaluation, .. } => (Kind::Evaluation, evaluation),
            Task::Search(place) => (Kind::Search, place),
            Task::Estimate(place) => (Kind::Estimate, place),
            Task::Cover(place) => (Kind::Cover, place),
            Task::Harden(place) => (Kind::Harden, place),
        }
    }

    fn new(campaign: &Campaign, kind: Kind, place: usize) -> Self {
        let name = match kind {
            Kind::Training => campaign.trainings[place].key.to_string(),
            Kind::Evaluation => evaluation(&campaign.evaluations[place]),
            Kind::Search => campaign.searches[place].key.to_string(),
            Kind::Estimate => campaign.estimations[place].key.to_string(),
            Kind::Cover => campaign.covers[place].key.to_string(),
            Kind::Harden => campaign.hardenings[place].key.to_string(),
        };
        Self {
            kind,
            place,
            name,
            total: 0,
            error: None,
            done: 0,
            before: 0,
            open: 0,
            begun: None,
            took: None,
            learnt: Learnt::default(),
        }
    }

    /// Starts it, if it has not started; returns whether it starts now.
    pub fn begin(&mut self) -> bool {
        let first = self.begun.is_none();
        self.begun.get_or_insert_with(Instant::now);
        first
    }

    /// Counts units that were done before it started.
    pub fn found(&mut self, units: u64) {
        self.before += units;
        self.done += units;
    }

    /// Counts a unit.
    pub fn advance(&mut self) {
        self.done += 1;
    }

    /// Sets the number of units that are done.
    pub fn reach(&mut self, units: u64) {
        self.done = units;
    }

    /// Raises the number of units that are done. Several parts of a search report their ticks in any order.
    pub fn rise(&mut self, units: u64) {
        self.done = self.done.max(units);
    }

    /// Notes the learning curve of a training up to now.
    pub fn learn(&mut self, curve: &[UpdateLog]) {
        self.learnt.follow(curve);
    }

    /// What a training has learnt up to now; none for other jobs and before the first update.
    pub fn learnt(&self) -> Option<Learnt> {
        Some(self.learnt).filter(|learnt| learnt.updates > 0)
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
        self.done.min(self.total)
    }

    /// The number of units that were done before this run of the program.
    pub fn before(&self) -> u64 {
        self.before.min(self.total)
    }

    /// Whether it has started and not ended.
    pub fn is_under_way(&self) -> bool {
        self.begun.is_some() && self.took.is_none()
    }

    /// Whether it has ended.
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

    /// Units per second; none before the first measurement.
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

/// Controller, town and driver of an evaluation.
fn evaluation(evaluation: &Evaluation) -> String {
    let key = &evaluation.trained;
    let here = (&*evaluation.town, &*evaluation.policy);
    let who = match &evaluation.controller {
        ControllerKind::Trained(_) if (key.town.as_str(), key.policy.as_str()) == here => key.reward.clone(),
        ControllerKind::Trained(_) => format!("{} of {} and {}", key.reward, key.town, key.policy),
        ControllerKind::Stochastic(_) => format!("stochastic {} of {} and {}", key.reward, key.town, key.policy),
        other if key.reward == NO_REWARD => other.name().to_string(),
        other => format!("{} ({})", other.name(), key.reward),
    };
    format!("{who} in {} against {}, run {}", here.0, here.1, key.run)
}
