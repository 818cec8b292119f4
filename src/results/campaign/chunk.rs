use std::collections::BTreeMap;
use std::sync::Arc;

use super::run::Shared;
use super::watch::{flow, watch_numbered};
use super::{Event, Progress, Task, TaskError};
use crate::record::{EpisodeRow, RunKey};
use learn::ActorCritic;
use world::env::{Outcome, Trace};
use world::judge::Judged;

/// The episodes of a chunk as they end. Several may run at once, so they do not end in their order.
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

/// Runs the episodes of a chunk that the result store does not have.
pub(super) fn try_chunk(shared: Shared<'_>, evaluation: usize, chunk: u32, trained: Option<&ActorCritic>) {
    let Shared { campaign, seed, results, .. } = shared;
    let plan = &campaign.evaluations[evaluation];
    let task = Task::Chunk { evaluation, chunk };
    let wanted = plan.chunk(chunk);
    let before = results.episodes(evaluation, chunk);
    let first = wanted.start + before;
    if first >= wanted.end {
        return shared.tell_reused(task);
    }
    shared.tell(Event::Begun(task));
    shared.tell(Event::Continued { task, units: before.into() });
    let rows = std::cell::RefCell::new(Rows { settled: Vec::new(), others: BTreeMap::new(), next: first, ticks: 0 });
    let key = Arc::new(RunKey::of(plan));
    let mut limit = None;
    let mut note = |episode: u32, outcome: &Outcome, trace: &Trace| {
        let pair = trace.main_pair(&plan.scenario);
        rows.borrow_mut().add(EpisodeRow::new(&key, episode, Judged::new(outcome, &pair), &pair));
    };
    let mut tell = |_| {
        shared.tell(Event::Tried { evaluation });
        let rows = rows.borrow();
        results.keep_episodes(evaluation, chunk, &rows.settled, Progress::UnderWay);
        limit = results.limit(task, rows.ticks);
        flow(limit.is_some() || shared.stop())
    };
    let ended = watch_numbered(plan, trained, first..wanted.end, seed, &mut note, &mut tell).len();
    let mut settled = rows.into_inner().settled;
    settled.truncate(ended);
    let error = match limit {
        _ if ended as u32 == wanted.end - first => None,
        Some(limit) => Some(limit),
        None if hopeless(&settled) => Some(TaskError::Hopeless),
        None => None,
    };
    let end = match &error {
        Some(error) => Progress::Failed(error),
        None => Progress::Ended,
    };
    results.keep_episodes(evaluation, chunk, &settled, end);
    shared.tell(Event::Evaluated { evaluation, chunk, error: error.as_ref() });
}

/// Whether the last ten episodes are in error. Then no more are run.
fn hopeless(rows: &[EpisodeRow]) -> bool {
    rows.len() >= 10 && rows.iter().rev().take(10).all(|row| row.judged.outcome.fault().is_some())
}
