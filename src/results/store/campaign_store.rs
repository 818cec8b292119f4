use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::index::{continues, programs};
use super::{Found, Header, Id, Ids, Index, State, Store, StoreError, task_name};
use crate::campaign::{
    Claim, CoverResult, EstimateResult, FoundInBox, HardenResult, Progress, ResultStore, SearchResult, Task, TaskError,
    tasks,
};
use crate::record::{self, Chunk, Chunks, EpisodeRow};
use compile::Campaign;
use learn::Trained;
use world::falsifier::{SearchOutcome, TrainingRun};
use world::hardening::Hardened;
use world::judge::Judged;
use world::likelihood::Estimate;

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
    /// Wall time of every training (s).
    seconds: Mutex<Vec<f64>>,
    failed: Mutex<Option<StoreError>>,
    /// The names of finished trainings that trainings of the campaign continue.
    shorter: BTreeMap<usize, String>,
}

/// A task that is being worked on.
struct InHand {
    begun: Instant,
    saved: Instant,
    /// When the user asked to stop.
    asked: Option<Instant>,
    /// Time that earlier runs spent on it (s).
    before: f64,
    /// Episodes that were stored before, as their file has them.
    bytes: Vec<u8>,
}

/// A search in the form in which it is stored.
#[derive(Serialize, Deserialize)]
struct Record {
    spent: SearchOutcome,
    judged: Vec<Option<Judged>>,
    evaluated: Vec<Judged>,
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
            seconds: Mutex::new(vec![0.0; campaign.trainings.len()]),
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

    /// Lets trainings continue finished ones that differ from them in nothing but fewer steps.
    pub fn continuing(mut self, index: &Index, seed: u64) -> Self {
        let shorter = |training| Some((training, index.shorter(self.campaign, training, seed)?.to_string()));
        self.shorter = (0..self.campaign.trainings.len()).filter_map(shorter).collect();
        self
    }

    /// Wall time of every training (s), also of earlier runs.
    pub fn training_seconds(&self) -> Vec<f64> {
        lock(&self.seconds).clone()
    }

    /// Why something could not be stored, if so.
    pub fn take_failure(&self) -> Option<StoreError> {
        lock(&self.failed).take()
    }

    fn fail(&self, error: StoreError) {
        lock(&self.failed).get_or_insert(error);
    }

    fn path(&self, task: Task) -> PathBuf {
        self.store.path(self.ids.get(task))
    }

    fn id(&self, task: Task) -> Id {
        self.ids.get(task)
    }

    /// Whether a checkpoint of a task is due. If so, the clock for the next one restarts.
    fn is_due(&self, task: Task) -> bool {
        let mut in_hand = lock(&self.in_hand);
        let Some(in_hand) = in_hand.get_mut(&task) else { return false };
        let due = in_hand.saved.elapsed() >= self.limits.checkpoint;
        if due {
            in_hand.saved = Instant::now();
        }
        due
    }

    fn seconds(&self, task: Task) -> f64 {
        lock(&self.in_hand).get(&task).map_or(0.0, |in_hand| in_hand.before + in_hand.begun.elapsed().as_secs_f64())
    }

    fn take_over(&self, task: Task, seconds: f64, bytes: Vec<u8>) {
        if let Some(in_hand) = lock(&self.in_hand).get_mut(&task) {
            (in_hand.before, in_hand.bytes) = (seconds, bytes);
        }
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

    fn write(&self, task: Task, state: State, done: u64, error: String, bytes: &[u8]) {
        if lock(&self.unread).contains(&task) {
            return;
        }
        let seconds = self.seconds(task);
        if let Task::Training(index) = task {
            lock(&self.seconds)[index] = seconds;
        }
        lock(&self.renewed).remove(&task);
        let what = task_name(self.campaign, task);
        let header = Header { what, state, done, error, seconds, length: 0 };
        if let Err(error) = self.store.write(self.id(task), &header, bytes) {
            self.fail(error);
        }
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
        let in_hand = InHand { begun: now, saved: now, asked: None, before: 0.0, bytes: Vec::new() };
        lock(&self.in_hand).insert(task, in_hand);
        Some(claim)
    }

    fn training(&self, training: usize) -> Option<Trained> {
        let task = Task::Training(training);
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        if header.state != State::Finished {
            return None;
        }
        let trained = Trained::from_safetensors(&bytes);
        if trained.is_err() {
            self.store.damaged(self.id(task));
        }
        lock(&self.seconds)[training] = header.seconds;
        trained.ok()
    }

    fn begun(&self, training: usize) -> Option<Vec<u8>> {
        let task = Task::Training(training);
        let own = match self.read(task) {
            Found::Whole(header, bytes) => Some((header, bytes)).filter(|(header, _)| header.state == State::Begun),
            _ => None,
        };
        let shorter = || {
            let name = self
                .shorter
                .get(&training)
                .filter(|_| programs(self.campaign, task).all(|program| !program.is_unknown()))?;
            let Ok(Found::Whole(header, bytes)) = self.store.read_named(name) else { return None };
            continues(&header, self.campaign, task).then_some((header, bytes))
        };
        let (header, bytes) = own.or_else(shorter)?;
        self.take_over(task, header.seconds, Vec::new());
        Some(bytes)
    }

    fn checkpoint(&self, training: usize, run: &TrainingRun, last: bool) {
        let task = Task::Training(training);
        if last || (!run.is_done() && self.is_due(task)) {
            let updates = run.learning_curve().len() as u64;
            self.write(task, State::Begun, updates, String::new(), &run.state(&BTreeMap::new()));
        }
    }

    fn keep_training(&self, training: usize, run: &TrainingRun) {
        let updates = run.learning_curve().len() as u64;
        // The whole state, from which a training with more steps continues. The networks and the curve are read from it, too.
        self.write(Task::Training(training), State::Finished, updates, String::new(), &run.state(&BTreeMap::new()));
    }

    fn episodes(&self, evaluation: usize, chunk: u32) -> u32 {
        let task = Task::Chunk { evaluation, chunk };
        let Found::Whole(header, bytes) = self.read(task) else { return 0 };
        if header.state == State::Failed {
            return 0;
        }
        let planned = &self.campaign.evaluations[evaluation];
        if header.done >= planned.chunk(chunk).len() as u64 {
            return header.done as u32;
        }
        match record::decode(&bytes) {
            Ok(episodes) => {
                self.take_over(task, header.seconds, bytes);
                episodes.height() as u32
            }
            Err(_) => {
                self.store.damaged(self.id(task));
                0
            }
        }
    }

    fn keep_episodes(&self, evaluation: usize, chunk: u32, rows: &[EpisodeRow], end: Progress<'_>) {
        let task = Task::Chunk { evaluation, chunk };
        if end == Progress::UnderWay && !self.is_due(task) {
            return;
        }
        let before = match end {
            Progress::UnderWay => lock(&self.in_hand).get(&task).map(|in_hand| in_hand.bytes.clone()),
            _ => lock(&self.in_hand).get_mut(&task).map(|in_hand| std::mem::take(&mut in_hand.bytes)),
        };
        let before = before.filter(|bytes| !bytes.is_empty());
        let (bytes, done) = match record::encode(before.as_deref(), rows) {
            Ok(encoded) => encoded,
            Err(source) => {
                let source = std::io::Error::other(source.to_string());
                return self.fail(StoreError::File { path: self.path(task), source });
            }
        };
        let faulty = rows.iter().any(|row| row.judged.outcome.fault().is_some());
        let whole = done == self.campaign.evaluations[evaluation].chunk(chunk).len() as u64;
        let (state, error) = match end {
            // The limit belongs to this run: a later run may continue the task.
            Progress::Failed(error @ (TaskError::Time { .. } | TaskError::Ticks { .. })) if !faulty => {
                (State::Begun, error.to_string())
            }
            Progress::Failed(error) => (State::Failed, error.to_string()),
            // A driver that failed may succeed another time.
            Progress::Ended if faulty => (State::Failed, String::new()),
            Progress::Ended if whole => (State::Finished, String::new()),
            Progress::UnderWay if faulty => return,
            _ => (State::Begun, String::new()),
        };
        self.write(task, state, done, error, &bytes);
    }

    fn search(&self, search: usize) -> Option<SearchResult> {
        let task = Task::Search(search);
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        if header.state != State::Finished {
            return None;
        }
        let planned = &self.campaign.searches[search];
        let record: Option<Record> = serde_json::from_slice(&bytes).ok();
        if record.is_none() {
            self.store.damaged(self.id(task));
        }
        let Record { spent, judged, evaluated } = record?;
        Some(SearchResult { judged, evaluated, ..SearchResult::new(planned, spent, None) })
    }

    fn keep_search(&self, search: usize, result: &SearchResult) {
        let SearchResult { spent, judged, evaluated, .. } = result.clone();
        let record = Record { spent, judged, evaluated };
        // An episode in error, or a reward that is not a number, cannot be stored. Such a search is run again.
        let Ok(bytes) = serde_json::to_vec(&record) else { return };
        if serde_json::from_slice::<Record>(&bytes).is_ok_and(|read| read.spent == record.spent) {
            let task = Task::Search(search);
            self.write(task, State::Finished, record.spent.episodes, String::new(), &bytes);
        }
    }

    fn estimate(&self, estimation: usize) -> Option<EstimateResult> {
        let task = Task::Estimate(estimation);
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        if header.state != State::Finished {
            return None;
        }
        let estimate = serde_json::from_slice(&bytes).ok();
        if estimate.is_none() {
            self.store.damaged(self.id(task));
        }
        Some(EstimateResult::new(&self.campaign.estimations[estimation], Ok(estimate?)))
    }

    fn keep_estimate(&self, estimation: usize, result: &EstimateResult) {
        let Some(estimate) = &result.estimate else { return };
        let Ok(bytes) = serde_json::to_vec(estimate) else { return };
        if serde_json::from_slice::<Estimate>(&bytes).is_ok_and(|read| read == *estimate) {
            self.write(Task::Estimate(estimation), State::Finished, estimate.ticks, String::new(), &bytes);
        }
    }

    fn cover(&self, cover: usize) -> Option<CoverResult> {
        let task = Task::Cover(cover);
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        if header.state != State::Finished {
            return None;
        }
        let found: Option<FoundInBox> = serde_json::from_slice(&bytes).ok();
        if found.is_none() {
            self.store.damaged(self.id(task));
        }
        Some(CoverResult::new(&self.campaign.covers[cover], found?, None))
    }

    fn keep_cover(&self, cover: usize, result: &CoverResult) {
        // An episode in error may end otherwise another time. Such a cover is run again.
        if result.found.errors > 0 {
            return;
        }
        let Ok(bytes) = serde_json::to_vec(&result.found) else { return };
        let episodes = result.found.coverage.points.len() as u64;
        self.write(Task::Cover(cover), State::Finished, episodes, String::new(), &bytes);
    }

    fn hardened(&self, harden: usize) -> Option<HardenResult> {
        let task = Task::Harden(harden);
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        if header.state != State::Finished {
            return None;
        }
        let found: Option<Hardened> = serde_json::from_slice(&bytes).ok();
        if found.is_none() {
            self.store.damaged(self.id(task));
        }
        Some(HardenResult::new(&self.campaign.hardenings[harden], Ok(found?)))
    }

    fn keep_hardened(&self, harden: usize, result: &HardenResult) {
        let Some(found) = &result.found else { return };
        // An episode in error may end otherwise another time. Such a hardening is run again.
        let errors =
            found.traffic.iter().map(|traffic| traffic.errors).chain(found.tests.iter().map(|test| test.errors));
        if errors.sum::<u64>() > 0 {
            return;
        }
        let Ok(bytes) = serde_json::to_vec(found) else { return };
        if serde_json::from_slice::<Hardened>(&bytes).is_ok_and(|read| read == *found) {
            self.write(Task::Harden(harden), State::Finished, found.ticks, String::new(), &bytes);
        }
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
    fn chunk(&self, evaluation: usize, chunk: u32) -> Option<Chunk> {
        let task = Task::Chunk { evaluation, chunk };
        let Found::Whole(header, bytes) = self.read(task) else { return None };
        let outcomes = record::decode(&bytes).inspect_err(|_| self.store.damaged(self.id(task))).ok()?;
        Some(Chunk { outcomes, error: header.error })
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
