use std::time::{Duration, Instant};

use super::piece::{Kind, Piece};
use crate::campaign::Task;
use crate::compile::Campaign;

/// All pieces of a campaign that are done here: trainings, evaluations, searches.
#[derive(Debug)]
pub struct Board<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// When it began.
    pub began: Instant,
    /// The pieces, in the plan's order.
    pub pieces: Vec<Piece>,
    threads: usize,
}

impl<'a> Board<'a> {
    /// Lays some tasks of a campaign out, for this number of threads.
    pub fn new(campaign: &'a Campaign, wanted: &[Task], threads: usize) -> Self {
        Self { campaign, began: Instant::now(), pieces: Piece::all(campaign, wanted), threads }
    }

    /// The piece of a task.
    pub fn piece(&self, task: Task) -> &Piece {
        let place = self.pieces.binary_search_by_key(&Piece::of(task), |piece| (piece.kind, piece.place));
        &self.pieces[place.expect("only what is wanted is done")]
    }

    /// How many pieces have ended.
    pub fn ended(&self) -> usize {
        self.pieces.iter().filter(|piece| piece.is_ended()).count()
    }

    /// Time until all is done, from what a unit of each kind has taken until now; none while a kind that is left has not been
    /// measured.
    pub fn left(&self) -> Option<Duration> {
        let mut seconds = 0.0;
        for kind in [Kind::Training, Kind::Evaluation, Kind::Search] {
            let of_kind = || self.pieces.iter().filter(move |piece| piece.kind == kind);
            let units: u64 = of_kind().filter(|piece| !piece.is_ended()).map(|piece| piece.total - piece.done()).sum();
            if units == 0 {
                continue;
            }
            let done: u64 = of_kind().map(|piece| piece.done().saturating_sub(piece.before())).sum();
            let busy: f64 = of_kind().map(|piece| piece.time().as_secs_f64()).sum();
            if done == 0 {
                return None;
            }
            seconds += busy / done as f64 * units as f64;
        }
        // A piece is worked on by one thread: the last ones may leave others idle.
        let last = self.pieces.iter().filter(|piece| piece.is_under_way()).filter_map(Piece::left).max();
        Some(Duration::from_secs_f64(seconds / self.threads.max(1) as f64).max(last.unwrap_or_default()))
    }
}
