use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::index::{continues, programs};
use super::{Found, Header, Id, Ids, Index, Store, StoreError, task_name};
use crate::campaign::{Claim, ResultStore, State, Stored, Task, TaskError, tasks};
use crate::record::{self, Chunk, Chunks};
use compile::Campaign;

/// Time beyond its limit, or after the user asked to stop, in which a training may finish an update.
const GRACE: Duration = Duration::from_millis(800);

/// The limits of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Time between two checkpoints of a task.
    pub checkpoint: Duration,
    /// Time limit of a task (s).
    pub seconds: Option<u64>,
    /// Limit of simulator ticks of a task.
    pub ticks: Option<u64>,
}

/// The tasks of one campaign in a store.
pub struct CampaignStore<'a> {
    store: &'a Store,
    campaign: &'a Campaign,
    ids: Ids,
    limits: Limits,
    in_hand: Mutex<BTreeMap<Task, InHand>>,
    /// The tasks whose files cannot be read. They may be whole, so they are not written either.
    unread: Mutex<BTreeSet<Task>>,
    /// The tasks whose stored results are not used, until they are made again.
    renewed: Mutex<BTreeSet<Task>>,
    /// The tasks of which this process has stored something, and those of which it found something that it has not stored.
    made: Mutex<BTreeSet<Id>>,
    reused: Mutex<BTreeSet<Task>>,
    /// Wall time of every job (s).
    seconds: Mutex<Vec<f64>>,
    failed: Mutex<Option<StoreError>>,
    /// The names of finished tasks that tasks of the campaign continue.
    shorter: BTreeMap<Task, String>,
}

/// A task that is being worked on.
struct InHand {
    begun: Instant,
    saved: Instant,
    /// When the user asked to stop.
    asked: Option<Instant>,
    /// Time that earlier runs spent on it (s).
    before: f64,
}

impl<'a> CampaignStore<'a> {
    /// Finds the tasks of a campaign.
    pub fn new(store: &'a Store, campaign: &'a Campaign, seed: u64, limits: Limits) -> Self {
        Self {
            store,
            campaign,
            ids: Ids::new(campaign, seed),
            limits,
            in_hand: Mutex::default(),
            unread: Mutex::default(),
            renewed: Mutex::default(),
            made: Mutex::default(),
            reused: Mutex::default(),
            seconds: Mutex::new(vec![0.0; campaign.jobs.len()]),
            failed: Mutex::default(),
            shorter: BTreeMap::new(),
        }
    }

    /// Uses no stored results of tasks that depend on programs without declared files or version, which may have changed. What other processes
    /// store from now on is used.
    pub fn renewing(self) -> Self {
        let is_unknown = |task: &Task| programs(self.campaign, *task).any(|program| program.is_unknown());
        let stored = |task: &Task| self.store.head(self.id(*task)).is_some();
        let renewed = tasks(self.campaign).filter(is_unknown).filter(stored).collect();
        Self { renewed: Mutex::new(renewed), ..self }
    }

    /// The number of tasks whose stored results are not used.
    pub fn renewed(&self) -> usize {
        lock(&self.renewed).len()
    }

    /// Lets tasks continue finished ones that differ from them in nothing but fewer units.
    pub fn continuing(mut self, index: &Index, seed: u64) -> Self {
        let shorter = |task| Some((task, index.shorter(self.campaign, task, seed)?.to_string()));
        self.shorter = tasks(self.campaign).filter_map(shorter).collect();
        self
    }

    /// The number of tasks of which something was found that this process has not made.
    pub fn reused(&self) -> usize {
        lock(&self.reused).len()
    }

    /// Wall time of every job (s), also of earlier runs.
    pub fn seconds(&self) -> Vec<f64> {
        lock(&self.seconds).clone()
    }

    /// Why something could not be stored, if so.
    pub fn take_failure(&self) -> Option<StoreError> {
        lock(&self.failed).take()
    }

    fn fail(&self, error: StoreError) {
        lock(&self.failed).get_or_insert(error);
    }

    fn id(&self, task: Task) -> Id {
        self.ids.get(task)
    }

    /// Reads a task. One that cannot be read ends the run, and counts as absent until then.
    fn read(&self, task: Task) -> Found {
        if lock(&self.renewed).contains(&task) {
            return Found::Nothing;
        }
        self.store.read(self.id(task)).unwrap_or_else(|error| {
            lock(&self.unread).insert(task);
            self.fail(error);
            Found::Nothing
        })
    }

    /// A finished task that is shorter than this one, if this one continues it.
    fn shorter(&self, task: Task) -> Option<(Header, Vec<u8>)> {
        let name = self.shorter.get(&task)?;
        if programs(self.campaign, task).any(|program| program.is_unknown()) {
            return None;
        }
        let Ok(Found::Whole(header, bytes)) = self.store.read_named(name) else { return None };
        continues(&header, self.campaign, task).then_some((header, bytes))
    }
}

impl ResultStore for CampaignStore<'_> {
    fn claim(&self, task: Task) -> Option<Claim> {
        let claim = match self.store.claim(self.id(task)) {
            Ok(claim) => claim?,
            Err(error) => {
                self.fail(error);
                Box::new(())
            }
        };
        let now = Instant::now();
        lock(&self.in_hand).insert(task, InHand { begun: now, saved: now, asked: None, before: 0.0 });
        Some(claim)
    }

    fn get(&self, task: Task) -> Option<Stored> {
        let (header, bytes) = match self.read(task) {
            Found::Whole(header, bytes) if header.state != State::Failed => (header, bytes),
            _ => {
                let (header, bytes) = self.shorter(task)?;
                (Header { state: State::Begun, ..header }, bytes)
            }
        };
        if !lock(&self.made).contains(&self.id(task)) {
            lock(&self.reused).insert(task);
        }
        if let Some(in_hand) = lock(&self.in_hand).get_mut(&task) {
            in_hand.before = header.seconds;
        }
        lock(&self.seconds)[task.job] = header.seconds;
        let Header { state, done, error, .. } = header;
        Some(Stored { state, done, error, bytes })
    }

    fn put(&self, task: Task, stored: &Stored) {
        if lock(&self.unread).contains(&task) {
            return;
        }
        let in_hand = |in_hand: &InHand| in_hand.before + in_hand.begun.elapsed().as_secs_f64();
        let seconds = lock(&self.in_hand).get(&task).map_or(0.0, in_hand);
        lock(&self.seconds)[task.job] = seconds;
        lock(&self.renewed).remove(&task);
        lock(&self.made).insert(self.id(task));
        let Stored { state, done, error, bytes } = stored;
        let what = task_name(self.campaign, task);
        let header =
            Header { task: String::new(), what, state: *state, done: *done, error: error.clone(), seconds, length: 0 };
        if let Err(error) = self.store.write(self.id(task), &header, bytes) {
            self.fail(error);
        }
    }

    fn damaged(&self, task: Task) {
        self.store.damaged(self.id(task));
        if let Some(in_hand) = lock(&self.in_hand).get_mut(&task) {
            in_hand.before = 0.0;
        }
    }

    fn is_due(&self, task: Task) -> bool {
        let mut in_hand = lock(&self.in_hand);
        let Some(in_hand) = in_hand.get_mut(&task) else { return false };
        let due = in_hand.saved.elapsed() >= self.limits.checkpoint;
        if due {
            in_hand.saved = Instant::now();
        }
        due
    }

    fn limit(&self, task: Task, ticks: u64) -> Option<TaskError> {
        if let Some(limit) = self.limits.ticks.filter(|limit| ticks > *limit) {
            return Some(TaskError::Ticks { ticks: limit });
        }
        let seconds = self.limits.seconds?;
        let begun = lock(&self.in_hand).get(&task).map(|in_hand| in_hand.begun)?;
        (begun.elapsed().as_secs() >= seconds).then_some(TaskError::Time { seconds })
    }

    fn is_overdue(&self, task: Task, stop: bool) -> bool {
        if !stop && self.limits.seconds.is_none() {
            return false;
        }
        let mut in_hand = lock(&self.in_hand);
        let Some(in_hand) = in_hand.get_mut(&task) else { return stop };
        let asked = stop.then(|| *in_hand.asked.get_or_insert_with(Instant::now));
        asked.is_some_and(|asked| asked.elapsed() >= GRACE)
            || self.limits.seconds.is_some_and(|limit| in_hand.begun.elapsed() >= Duration::from_secs(limit) + GRACE)
    }

    fn stop(&self) -> bool {
        lock(&self.failed).is_some()
    }
}

impl Chunks for CampaignStore<'_> {
    fn chunk(&self, task: Task) -> Option<Chunk> {
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        let outcomes = record::decode(&bytes).inspect_err(|_| self.store.damaged(self.id(task))).ok()?;
        Some(Chunk { outcomes, error: header.error })
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
