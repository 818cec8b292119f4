use std::collections::BTreeMap;
use std::sync::Arc;

use super::episodes::{flow, watch_numbered};
use super::{JobResult, Kind, TrainingResult, Work, result};
use crate::campaign::{Part, State, Stored, TaskError};
use crate::record::{self, EpisodeRow, RunKey};
use compile::{Evaluation, Planned};
use episode::{Outcome, Trace};
use learn::ActorCritic;
use verdict::Judged;

pub(super) const KIND: Kind = Kind {
    doing: ["trying", "tried"],
    unit: "episodes",
    seconds: 3e-3,
    has_episodes: true,
    ..Kind::new::<Evaluation>("evaluation", "evaluations", "evaluate")
};

/// What came of a part of an evaluation. Its episodes are in the store.
#[derive(Debug, Clone)]
struct PartResult {
    /// Those that ended, of earlier runs, too.
    episodes: u64,
    error: Option<TaskError>,
}

impl JobResult for PartResult {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn units(&self) -> u64 {
        self.episodes
    }
}

impl Work for Evaluation {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn what(&self) -> String {
        let key = RunKey::of(self);
        format!("{}, run {}", key.cell.in_full(), key.run)
    }

    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>> {
        result(PartResult { episodes: record::decode(bytes).ok()?.height() as u64, error: None })
    }

    fn read(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let stored = part.results.get(part.task)?;
        let episodes = self.units(part.task.part);
        if stored.done < episodes { None } else { result(PartResult { episodes, error: None }) }
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let trained = match self.origin.needs.map(|training| part.result_of::<TrainingResult>(training)) {
            None => None,
            Some(Some(TrainingResult { result: Ok(trained), .. })) => Some(trained.policies.as_slice()),
            // A training that was stopped continues in a later run.
            Some(None) => return None,
            Some(Some(TrainingResult { result: Err(TaskError::Training(error)), .. })) if error.is_stopped() => {
                return None;
            }
            Some(Some(TrainingResult { result: Err(error), .. })) => {
                let error = TaskError::Untrained(Box::new(error.clone()));
                store(part, &[], &[], State::Failed, Some(&error));
                return result(PartResult { episodes: 0, error: Some(error) });
            }
        };
        result(run_episodes(self, part, trained))
    }
}

/// The episodes of a part as they end. Several may run at once, so they do not end in their order.
struct Rows {
    /// The first ones, without a gap.
    settled: Vec<EpisodeRow>,
    /// The rows after a gap.
    others: BTreeMap<u32, EpisodeRow>,
    /// Number of the episode that follows the settled ones.
    next: u32,
    ticks: u64,
}

impl Rows {
    fn add(&mut self, row: EpisodeRow) {
        self.ticks += u64::from(row.judged.outcome.ticks) + u64::from(row.judged.outcome.run_up);
        self.others.insert(row.episode, row);
        while let Some(row) = self.others.remove(&self.next) {
            self.settled.push(row);
            self.next += 1;
        }
    }
}

/// Runs the episodes of a part that the store does not have.
fn run_episodes(plan: &Evaluation, part: &Part<'_>, trained: Option<&[ActorCritic]>) -> PartResult {
    let wanted = plan.chunk(part.task.part);
    let (earlier, before) = match part.results.get(part.task).map(|stored| stored.bytes) {
        None => (Vec::new(), 0),
        Some(bytes) => match record::decode(&bytes) {
            Ok(episodes) => (bytes, episodes.height() as u32),
            Err(_) => {
                part.results.damaged(part.task);
                (Vec::new(), 0)
            }
        },
    };
    part.begin(before.into());
    let first = wanted.start + before;
    let rows = std::cell::RefCell::new(Rows { settled: Vec::new(), others: BTreeMap::new(), next: first, ticks: 0 });
    let key = Arc::new(RunKey::of(plan));
    let mut limit = None;
    let mut note = |episode: u32, outcome: &Outcome, trace: &Trace| {
        let pair = trace.main_pair(&plan.scenario);
        rows.borrow_mut().add(EpisodeRow::new(&key, episode, Judged::new(outcome, &pair), &pair));
    };
    let mut done = u64::from(before);
    let mut tell = |_| {
        done += 1;
        part.progress(done);
        let rows = rows.borrow();
        if part.results.is_due(part.task) && !rows.settled.iter().any(is_faulty) {
            store(part, &earlier, &rows.settled, State::Begun, None);
        }
        limit = part.limit(rows.ticks);
        flow(limit.is_some() || part.stop())
    };
    let ended = watch_numbered(plan, trained, first..wanted.end, part.seed, &mut note, &mut tell).len();
    let mut settled = rows.into_inner().settled;
    settled.truncate(ended);
    let is_whole = ended as u32 == wanted.end - first;
    let error = match limit {
        _ if is_whole => None,
        Some(limit) => Some(limit),
        None if is_hopeless(&settled) => Some(TaskError::Hopeless),
        None => None,
    };
    let state = match &error {
        // A driver that failed may succeed another time.
        _ if settled.iter().any(is_faulty) => State::Failed,
        // The limit belongs to this run: a later run may continue the task.
        Some(TaskError::Time { .. } | TaskError::Ticks { .. }) => State::Begun,
        Some(_) => State::Failed,
        None if is_whole => State::Finished,
        None => State::Begun,
    };
    store(part, &earlier, &settled, state, error.as_ref());
    PartResult { episodes: u64::from(before) + ended as u64, error }
}

/// Stores episodes of a part after those that are there already.
fn store(part: &Part<'_>, earlier: &[u8], rows: &[EpisodeRow], state: State, error: Option<&TaskError>) {
    let earlier = Some(earlier).filter(|bytes| !bytes.is_empty());
    // Earlier episodes with other columns are of no use.
    let Ok((bytes, done)) = record::encode(earlier, rows) else { return part.results.damaged(part.task) };
    part.put(&Stored { state, done, error: error.map(ToString::to_string).unwrap_or_default(), bytes });
}

fn is_faulty(row: &EpisodeRow) -> bool {
    row.judged.outcome.fault().is_some()
}

/// Whether the last ten episodes are in error. Then no more are run.
fn is_hopeless(rows: &[EpisodeRow]) -> bool {
    rows.len() >= 10 && rows.iter().rev().take(10).all(is_faulty)
}
