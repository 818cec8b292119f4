use std::collections::BTreeMap;

use super::run::flow;
use super::watch::watch_numbered;
use super::{Cell, CellError, EpisodeRow, Keeper, Observer, Progress};
use crate::compile::Campaign;
use crate::env::{Outcome, Recording};
use crate::judge::judge;
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Episodes of a chunk as they end: several may go on at once, so not in their order.
struct Rows {
    /// The first ones, without a gap.
    settled: Vec<EpisodeRow>,
    /// Those behind a gap.
    others: BTreeMap<u32, EpisodeRow>,
    /// Number of the episode that comes next behind the settled ones.
    next: u32,
    ticks: u64,
}

impl Rows {
    fn add(&mut self, row: EpisodeRow) {
        self.ticks += u64::from(row.outcome.ticks);
        self.others.insert(row.episode, row);
        while let Some(row) = self.others.remove(&self.next) {
            self.settled.push(row);
            self.next += 1;
        }
    }
}

/// Tries the episodes of a chunk that the keeper does not have.
pub(super) fn try_chunk(
    campaign: &Campaign,
    (index, chunk): (usize, u32),
    trained: Option<&ActorCritic>,
    seed: &Seed,
    keeper: &dyn Keeper,
    observer: &dyn Observer,
) {
    let evaluation = &campaign.evaluations[index];
    let cell = Cell::Chunk { evaluation: index, chunk };
    let wanted = evaluation.chunk(chunk);
    let first = wanted.start + keeper.episodes(index, chunk);
    if first >= wanted.end {
        return observer.reused(cell);
    }
    observer.continued(cell, first - wanted.start);
    let rows = std::cell::RefCell::new(Rows { settled: Vec::new(), others: BTreeMap::new(), next: first, ticks: 0 });
    let mut limit = None;
    let mut note = |episode: u32, outcome: &Outcome, recording: &Recording| {
        let verdict = judge(&evaluation.scenario, recording);
        rows.borrow_mut().add(EpisodeRow::new(evaluation, episode, *outcome, verdict));
    };
    let stop = || observer.stop() || keeper.stop();
    let tried = watch_numbered(evaluation, trained, first..wanted.end, seed, &mut note, &mut |_| {
        observer.tried(index, evaluation);
        let rows = rows.borrow();
        keeper.keep_episodes(index, chunk, &rows.settled, Progress::UnderWay);
        limit = keeper.limit(cell, rows.ticks);
        flow(limit.is_some() || stop())
    });
    let mut settled = rows.into_inner().settled;
    settled.truncate(tried.len());
    let error = match limit {
        _ if tried.len() == (first..wanted.end).len() => None,
        Some(limit) => Some(limit),
        None if hopeless(&settled) => Some(CellError::Hopeless),
        None => None,
    };
    keeper.keep_episodes(index, chunk, &settled, error.as_ref().map_or(Progress::Ended, Progress::Failed));
    observer.chunk_ended(index, chunk, error.as_ref());
}

/// Whether the last ten episodes are in error: then no more were tried.
fn hopeless(rows: &[EpisodeRow]) -> bool {
    rows.len() >= 10 && rows.iter().rev().take(10).all(|row| row.outcome.fault().is_some())
}
