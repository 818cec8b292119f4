use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::bars::Bars;
use super::board::Board;
use super::events::Event;
use super::lines::line;
use super::piece::{Kind, Piece};
use crate::campaign::{Observer, SearchResult, TrainingResult};
use crate::cli::args::{Output, RunOptions, Showing};
use crate::cli::interrupt;
use crate::compile::{Campaign, Evaluation, Training};
use crate::rl::UpdateLog;

/// Least time between two looks at how far everything is (ms).
const GLANCE: u64 = 200;
/// Every how many glances programs are told.
const TOLD: u64 = 5;

/// Hears a campaign, shows how far it is and takes times.
pub struct Progress {
    board: Board,
    bars: Option<Bars>,
    lines: bool,
    events: bool,
    glances: AtomicU64,
    /// Time of the next glance, since the campaign began (ms).
    next: AtomicU64,
}

impl Progress {
    /// Gets ready for a campaign.
    pub fn new(campaign: &Campaign, options: &RunOptions) -> Self {
        let board = Board::new(campaign, rayon::current_num_threads());
        let terminal = std::io::stderr().is_terminal();
        let showing = match options.progress {
            Showing::Auto if terminal => Showing::Bars,
            Showing::Auto => Showing::Lines,
            chosen => chosen,
        };
        let events = options.format == Output::Json;
        if events {
            Event::campaign_begun(&board).tell();
        }
        let bars = (showing == Showing::Bars).then(|| Bars::new(&board));
        let lines = showing == Showing::Lines;
        Self { board, bars, lines, events, glances: AtomicU64::new(0), next: AtomicU64::new(0) }
    }

    /// Removes the bars and gives the wall time of every training.
    pub fn finish(self) -> Vec<Duration> {
        if let Some(bars) = &self.bars {
            bars.clear();
        }
        let trainings = self.board.pieces.iter().filter(|piece| piece.kind == Kind::Training);
        trainings.map(Piece::time).collect()
    }

    fn begin(&self, piece: &Piece) {
        if piece.begin() && self.events {
            Event::begun(&self.board, piece).tell();
        }
    }

    /// Shows how far everything is, if it is time for that.
    fn glance(&self) {
        let now = self.board.began.elapsed().as_millis() as u64;
        let next = self.next.load(Ordering::Relaxed);
        if now < next || self.next.compare_exchange(next, now + GLANCE, Ordering::Relaxed, Ordering::Relaxed).is_err() {
            return;
        }
        if let Some(bars) = &self.bars {
            bars.draw(&self.board);
        }
        if self.glances.fetch_add(1, Ordering::Relaxed) % TOLD == TOLD - 1 && self.events {
            for piece in self.board.pieces.iter().filter(|piece| piece.is_under_way()) {
                Event::progress(&self.board, piece).tell();
            }
        }
    }

    /// Ends a piece, with what came of it.
    fn end(&self, piece: &Piece, result: Result<String, String>) {
        if !piece.end() {
            return;
        }
        let (note, error) = match &result {
            Ok(note) => (note.as_str(), None),
            Err(error) => ("", Some(error.as_str())),
        };
        if self.events {
            Event::finished(&self.board, piece, note, error).tell();
        }
        match &self.bars {
            // On a terminal the many evaluations would push everything else away.
            Some(bars) if error.is_some() || piece.kind != Kind::Evaluation => {
                bars.say(&line(&self.board, piece, error.unwrap_or(note)));
            }
            None if self.lines || error.is_some() => {
                anstream::eprintln!("{}", line(&self.board, piece, error.unwrap_or(note)));
            }
            _ => {}
        }
        self.glance();
    }
}

impl Observer for Progress {
    fn training_begun(&self, training: usize) {
        self.begin(self.board.piece(Kind::Training, training));
    }

    fn trained(&self, training: usize, _: &Training, log: &UpdateLog) {
        self.board.piece(Kind::Training, training).reach(log.steps);
        self.glance();
    }

    fn training_ended(&self, training: usize, result: &TrainingResult) {
        let told = match &result.result {
            Ok(trained) => {
                let reward = trained.learning_curve.last().and_then(|log| log.mean_reward);
                Ok(reward.map_or("no episode ended".into(), |reward| format!("mean reward {reward:.3}")))
            }
            Err(error) => Err(error.to_string()),
        };
        self.end(self.board.piece(Kind::Training, training), told);
    }

    fn tried(&self, evaluation: usize, _: &Evaluation) {
        let piece = self.board.piece(Kind::Evaluation, evaluation);
        self.begin(piece);
        piece.advance(1);
        self.glance();
        if piece.done() >= piece.total {
            self.end(piece, Ok(String::new()));
        }
    }

    fn searched(&self, search: usize, result: &SearchResult) {
        let piece = self.board.piece(Kind::Search, search);
        let spent = &result.spent;
        piece.reach(spent.ticks);
        let told = match &result.error {
            Some(error) => Err(error.to_string()),
            None => Ok(format!("{} failures in {} episodes", spent.failures.len(), spent.episodes)),
        };
        self.end(piece, told);
    }

    fn stop(&self) -> bool {
        interrupt::asked()
    }
}
