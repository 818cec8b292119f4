use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use super::bars::Bars;
use super::board::Board;
use super::events::Event;
use super::job::{Job, Kind, amount};
use super::learnt::Learnt;
use super::lines::line;
use super::showing::Showing;
use crate::cli::console;
use crate::cli::output::Output;
use crate::session::Stop;
use compile::{Campaign, Evaluation, Training};
use learn::UpdateLog;
use results::campaign::{Observer, SearchResult, Task, TaskError, TrainingResult};

/// Least time between two updates of the display (ms).
const GLANCE: u64 = 200;
/// Number of updates of the display per event for programs.
const TOLD: u64 = 5;

/// Observes a campaign and shows its progress.
pub struct Progress<'a> {
    board: Board<'a>,
    bars: Option<Bars>,
    lines: bool,
    events: bool,
    stop: Arc<Stop>,
    tasks: usize,
    reused: AtomicUsize,
    glances: AtomicU64,
    /// Time of the next update, since the start of the campaign (ms).
    next: AtomicU64,
}

impl<'a> Progress<'a> {
    /// Prepares for some tasks of a campaign.
    pub fn new(campaign: &'a Campaign, wanted: &[Task], showing: Showing, output: Output, stop: Arc<Stop>) -> Self {
        let board = Board::new(campaign, wanted, rayon::current_num_threads());
        let terminal = std::io::stderr().is_terminal();
        let showing = match showing {
            Showing::Auto if terminal => Showing::Bars,
            Showing::Auto => Showing::Lines,
            chosen => chosen,
        };
        let events = output == Output::Json;
        if events {
            Event::campaign_begun(&board).tell();
        }
        let bars = (showing == Showing::Bars).then(|| Bars::new(&board));
        let lines = showing == Showing::Lines;
        let (reused, glances, next) = (AtomicUsize::new(0), AtomicU64::new(0), AtomicU64::new(0));
        Self { board, bars, lines, events, stop, tasks: wanted.len(), reused, glances, next }
    }

    /// The job of a task, which is begun now if it was not before.
    fn job(&self, task: Task) -> &Job {
        let job = self.board.job(task);
        if job.begin() && self.events {
            Event::begun(&self.board, job).tell();
        }
        job
    }

    /// Updates the display, if it is time.
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
            for job in self.board.jobs.iter().filter(|job| job.is_under_way()) {
                Event::progress(&self.board, job).tell();
            }
        }
    }

    /// Ends a task; with the last one of a job comes what came of the job.
    fn end(&self, task: Task, result: Result<String, String>) {
        let job = self.board.job(task);
        let (note, error) = match result {
            Ok(note) => (note, None),
            Err(error) => (String::new(), Some(error)),
        };
        if !job.end_task(error) {
            return;
        }
        let error = job.error();
        if self.stop.is_asked() && error.is_none() && job.done() < job.total {
            return;
        }
        if self.events {
            Event::finished(&self.board, job, &note, error.as_deref()).tell();
        }
        let quiet = job.is_old() && error.is_none();
        let line = || line(&self.board, job, error.as_deref().unwrap_or(&note));
        match &self.bars {
            // On a terminal the many evaluations would push everything else away.
            Some(bars) if error.is_some() || (job.kind != Kind::Evaluation && !quiet) => bars.say(&line()),
            None if error.is_some() || (self.lines && !quiet) => console::note(&line()),
            _ => {}
        }
        self.glance();
    }
}

impl Drop for Progress<'_> {
    /// Removes the bars, and reports how much was stored before.
    fn drop(&mut self) {
        if let Some(bars) = &self.bars {
            bars.clear();
        }
        let reused = *self.reused.get_mut();
        if reused > 0 && (self.lines || self.bars.is_some()) {
            console::note(&format!("{reused} of {} tasks were there already", self.tasks));
        }
    }
}

impl Observer for Progress<'_> {
    fn training_begun(&self, training: usize) {
        self.job(Task::Training(training));
    }

    fn curves_grow(&self, folder: &Path) {
        let told = format!("the learning curves grow in {}", folder.display());
        match &self.bars {
            Some(bars) => bars.say(&told),
            None if self.lines => console::note(&told),
            None => {}
        }
        if self.events {
            Event::curves_grow(&self.board, folder).tell();
        }
    }

    fn curve_before(&self, training: usize, _: &Training, curve: &[UpdateLog]) {
        self.board.job(Task::Training(training)).learn(curve);
    }

    fn deciding(&self, training: usize, decisions: u64) {
        let job = self.board.job(Task::Training(training));
        job.rise(job.before() + decisions);
        self.glance();
    }

    fn trained(&self, training: usize, _: &Training, curve: &[UpdateLog]) {
        let job = self.board.job(Task::Training(training));
        job.learn(curve);
        job.rise(curve.last().map_or(0, |log| log.steps));
        self.glance();
    }

    fn training_ended(&self, training: usize, result: &TrainingResult) {
        let told = match &result.result {
            Ok(trained) => {
                let learnt = Learnt::of(&trained.learning_curve);
                Ok(learnt.told().unwrap_or_else(|| "no episode ended".into()))
            }
            Err(error) => Err(error.to_string()),
        };
        self.end(Task::Training(training), told);
    }

    fn tried(&self, evaluation: usize, _: &Evaluation) {
        self.job(Task::Chunk { evaluation, chunk: 0 }).advance(1);
        self.glance();
    }

    fn chunk_ended(&self, evaluation: usize, chunk: u32, error: Option<&TaskError>) {
        self.end(Task::Chunk { evaluation, chunk }, error.map_or(Ok(String::new()), |error| Err(error.to_string())));
    }

    fn reused(&self, task: Task) {
        self.reused.fetch_add(1, Ordering::Relaxed);
        self.board.job(task).found(amount(self.board.campaign, task));
        self.end(task, Ok(String::new()));
    }

    fn continued(&self, task: Task, units: u64) {
        self.job(task).found(units);
    }

    fn search_begun(&self, search: usize) {
        self.job(Task::Search(search));
    }

    fn searching(&self, search: usize, ticks: u64) {
        self.board.job(Task::Search(search)).rise(ticks);
        self.glance();
    }

    fn searched(&self, search: usize, result: &SearchResult) {
        let spent = &result.spent;
        self.job(Task::Search(search)).reach(spent.ticks);
        let told = match &result.error {
            Some(error) => Err(error.to_string()),
            None => {
                let (failures, episodes) = (spent.failures.len(), spent.episodes);
                Ok(format!("{failures} {} in {episodes} episodes", if failures == 1 { "failure" } else { "failures" }))
            }
        };
        self.end(Task::Search(search), told);
    }
}
