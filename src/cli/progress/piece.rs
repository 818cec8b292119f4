use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::compile::{Evaluation, Pedestrian, Search, Training};

/// What a piece of work is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A training.
    Training,
    /// An evaluation.
    Evaluation,
    /// A search.
    Search,
}

impl Kind {
    /// What it does, while it does it.
    pub fn doing(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Evaluation => "trying",
            Self::Search => "searching",
        }
    }

    /// What it has done.
    pub fn done(self) -> &'static str {
        match self {
            Self::Training => "trained",
            Self::Evaluation => "tried",
            Self::Search => "searched",
        }
    }

    /// What is counted.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Training => "decisions",
            Self::Evaluation => "episodes",
            Self::Search => "ticks",
        }
    }
}

/// A piece of a campaign's work: a training, an evaluation or a search.
#[derive(Debug)]
pub struct Piece {
    /// What it is.
    pub kind: Kind,
    /// Its place among those of its kind.
    pub place: usize,
    /// Who, where, against whom.
    pub name: String,
    /// How much it is, in units of its kind.
    pub total: u64,
    done: AtomicU64,
    before: AtomicU64,
    times: Mutex<Times>,
}

#[derive(Debug, Default)]
struct Times {
    begun: Option<Instant>,
    took: Option<Duration>,
}

impl Piece {
    /// Makes the piece of a training.
    pub fn training(place: usize, training: &Training) -> Self {
        let key = &training.key;
        let name = format!("{} in {} against {}, run {}", key.reward, key.town, key.policy, key.run);
        Self::new(Kind::Training, place, name, training.config.total_steps)
    }

    /// Makes the piece of an evaluation.
    pub fn evaluation(place: usize, evaluation: &Evaluation) -> Self {
        let (key, here) = (&evaluation.trained, (&evaluation.town, &evaluation.policy));
        let who = match evaluation.pedestrian {
            Pedestrian::Trained(_) if (&key.town, &key.policy) == here => key.reward.clone(),
            Pedestrian::Trained(_) => format!("{} of {} and {}", key.reward, key.town, key.policy),
            Pedestrian::Sampled(_) => format!("sampled {} of {} and {}", key.reward, key.town, key.policy),
            other => format!("{} ({})", other.name(), key.reward),
        };
        let name = format!("{who} in {} against {}, run {}", here.0, here.1, key.run);
        Self::new(Kind::Evaluation, place, name, evaluation.episodes.into())
    }

    /// Makes the piece of a search.
    pub fn search(place: usize, search: &Search) -> Self {
        let key = &search.key;
        let name = format!("{} in {} against {}, run {}", key.falsifier, key.town, key.policy, key.run);
        Self::new(Kind::Search, place, name, search.budget)
    }

    fn new(kind: Kind, place: usize, name: String, total: u64) -> Self {
        let (done, before, times) = (AtomicU64::new(0), AtomicU64::new(0), Mutex::default());
        Self { kind, place, name, total, done, before, times }
    }

    fn times(&self) -> MutexGuard<'_, Times> {
        self.times.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins, where it has not; says whether it had not.
    pub fn begin(&self) -> bool {
        let mut times = self.times();
        let first = times.begun.is_none();
        times.begun.get_or_insert_with(Instant::now);
        first
    }

    /// Counts what was there before it began.
    pub fn found(&self, units: u64) {
        self.before.fetch_add(units, Ordering::Relaxed);
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Counts what was done.
    pub fn advance(&self, units: u64) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Says how much is done by now.
    pub fn reach(&self, units: u64) {
        self.done.store(units, Ordering::Relaxed);
    }

    /// Ends; says whether it had not ended before.
    pub fn end(&self) -> bool {
        let mut times = self.times();
        let first = times.took.is_none();
        let took = times.begun.map_or(Duration::ZERO, |begun| begun.elapsed());
        times.took.get_or_insert(took);
        first
    }

    /// How much is done.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed).min(self.total)
    }

    /// How much of it was done before this run of the program.
    pub fn before(&self) -> u64 {
        self.before.load(Ordering::Relaxed).min(self.total)
    }

    /// Whether it has begun and not ended.
    pub fn is_under_way(&self) -> bool {
        let times = self.times();
        times.begun.is_some() && times.took.is_none()
    }

    /// Whether it has ended.
    pub fn is_ended(&self) -> bool {
        self.times().took.is_some()
    }

    /// How long it took, or takes by now.
    pub fn time(&self) -> Duration {
        let times = self.times();
        times.took.or_else(|| times.begun.map(|begun| begun.elapsed())).unwrap_or_default()
    }

    /// Units a second; none before there is anything to measure.
    pub fn rate(&self) -> Option<f64> {
        let (units, time) = (self.done().saturating_sub(self.before()) as f64, self.time().as_secs_f64());
        (units > 0.0 && time > 0.0).then(|| units / time)
    }

    /// Time until it ends at this rate.
    pub fn left(&self) -> Option<Duration> {
        self.rate().map(|rate| Duration::from_secs_f64((self.total - self.done()) as f64 / rate))
    }
}
