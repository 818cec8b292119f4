use std::collections::BTreeMap;
use std::sync::Arc;

use super::watch::{flow, watch_numbered};
use super::{Observer, Progress, ResultStore, Task, TaskError};
use crate::record::{EpisodeRow, RunKey};
use base::seed::Seed;
use compile::Campaign;
use learn::ActorCritic;
use world::env::{Outcome, Trace};

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
        self.ticks += u64::from(row.outcome.ticks) + u64::from(row.outcome.run_up);
        self.others.insert(row.episode, row);
        while let Some(row) = self.others.remove(&self.next) {
            self.settled.push(row);
            self.next += 1;
        }
    }
}

/// Runs the episodes of a chunk that the result store does not have.
pub(super) fn try_chunk(
    campaign: &Campaign,
    (index, chunk): (usize, u32),
    trained: Option<&ActorCritic>,
    seed: &Seed,
    results: &dyn ResultStore,
    observer: &dyn Observer,
) {
    let evaluation = &campaign.evaluations[index];
    let task = Task::Chunk { evaluation: index, chunk };
    let wanted = evaluation.chunk(chunk);
    let before = results.episodes(index, chunk);
    let first = wanted.start + before.episodes;
    if before.enough || first >= wanted.end {
        return observer.reused(task);
    }
    observer.continued(task, before.episodes.into());
    let rows = std::cell::RefCell::new(Rows { settled: Vec::new(), others: BTreeMap::new(), next: first, ticks: 0 });
    let key = Arc::new(RunKey::of(evaluation));
    let mut limit = None;
    let mut note = |episode: u32, outcome: &Outcome, trace: &Trace| {
        let pair = trace.main_pair(&evaluation.scenario);
        rows.borrow_mut().add(EpisodeRow::new(&key, episode, outcome, &pair));
    };
    let stop = || observer.stop() || results.stop();
    let mut tell = |_| {
        observer.tried(index, evaluation);
        let rows = rows.borrow();
        results.keep_episodes(index, chunk, &rows.settled, Progress::UnderWay);
        limit = results.limit(task, rows.ticks);
        flow(limit.is_some() || stop())
    };
    let rule = evaluation.rule();
    let looks = if evaluation.halfwidth.is_some() { rule.looks() } else { vec![wanted.end] };
    let (mut next, mut enough) = (first, false);
    for look in looks.into_iter().filter(|look| *look > first) {
        let tried = watch_numbered(evaluation, trained, next..look, seed, &mut note, &mut tell).len() as u32;
        next += tried;
        let mut all = before;
        rows.borrow().settled.iter().for_each(|row| all.add(row));
        enough = next == look && evaluation.halfwidth.is_some() && rule.is_met(all.collisions, all.valid);
        if enough || next < look {
            break;
        }
    }
    let mut settled = rows.into_inner().settled;
    settled.truncate((next - first) as usize);
    let error = match limit {
        _ if enough || next == wanted.end => None,
        Some(limit) => Some(limit),
        None if hopeless(&settled) => Some(TaskError::Hopeless),
        None => None,
    };
    let end = match &error {
        Some(error) => Progress::Failed(error),
        None if enough => Progress::Enough,
        None => Progress::Ended,
    };
    results.keep_episodes(index, chunk, &settled, end);
    observer.chunk_ended(index, chunk, error.as_ref());
}

/// Whether the last ten episodes are in error. Then no more are run.
fn hopeless(rows: &[EpisodeRow]) -> bool {
    rows.len() >= 10 && rows.iter().rev().take(10).all(|row| row.outcome.fault().is_some())
}
