use std::any::Any;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use indicatif::HumanCount;

use super::bars::Bars;
use super::board::Board;
use super::counting::LINE;
use super::event_line::{About, EventLine};
use super::job::Job;
use super::showing::Showing;
use crate::cli::console;
use crate::cli::output::Output;
use crate::session::Stop;
use compile::{Campaign, ExternalProgram};
use results::campaign::{Event, Task};
use results::jobs::{KINDS, TrainingResult};

/// Least time between two updates of the display.
const GLANCE: Duration = Duration::from_millis(200);
/// Maximum number of files of a program that are named.
const MAX_NAMED: usize = 4;
/// Number of updates of the display per event for programs.
const TOLD: u64 = 5;

/// Shows the progress of a campaign.
pub struct Progress {
    board: Board,
    bars: Option<Bars>,
    lines: bool,
    events: bool,
    stop: Arc<Stop>,
    tasks: usize,
    reused: usize,
    /// What stored tasks depend on, in words.
    depends: String,
    /// The number of updates of the display.
    glances: u64,
    /// Time of the next one, since the start of the campaign.
    next: Duration,
    /// Time of the last line, since then.
    said: Duration,
}

impl Progress {
    /// Prepares for some tasks of a campaign.
    pub fn new(campaign: &Campaign, wanted: &[Task], showing: Showing, output: Output, stop: Arc<Stop>) -> Self {
        let board = Board::new(campaign, wanted, rayon::current_num_threads());
        let terminal = std::io::stderr().is_terminal();
        let showing = match showing {
            Showing::Auto if terminal => Showing::Bars,
            Showing::Auto => Showing::Lines,
            chosen => chosen,
        };
        let events = output == Output::Json;
        if events {
            EventLine::CampaignBegun {
                campaign: &board.campaign,
                jobs: KINDS.iter().map(|kind| (kind.plural, board.count(kind))).collect(),
            }
            .tell();
        }
        let bars = (showing == Showing::Bars).then(|| Bars::new(&board));
        let lines = showing == Showing::Lines;
        Self {
            board,
            bars,
            lines,
            events,
            stop,
            tasks: wanted.len(),
            reused: 0,
            depends: depends(campaign),
            glances: 0,
            next: Duration::ZERO,
            said: Duration::ZERO,
        }
    }

    /// The job of a task, which is begun now if it was not before.
    fn job(&mut self, task: Task) -> &mut Job {
        let place = self.board.place(task);
        if self.board.jobs[place].begin() && self.events {
            EventLine::TaskBegun(About::new(&self.board, &self.board.jobs[place])).tell();
        }
        &mut self.board.jobs[place]
    }

    /// Updates the display, if it is time.
    fn glance(&mut self) {
        let now = self.board.began.elapsed();
        if now < self.next {
            return;
        }
        self.next = now + GLANCE;
        if let Some(bars) = &mut self.bars {
            bars.draw(&self.board);
        }
        self.glances += 1;
        if self.glances.is_multiple_of(TOLD) && self.events {
            for job in self.board.jobs.iter().filter(|job| job.is_under_way()) {
                EventLine::Progress {
                    about: About::new(&self.board, job),
                    rate_per_s: job.rate(),
                    left_s: job.left().map(|left| left.as_secs_f64()),
                    campaign_left_s: self.board.left().map(|left| left.as_secs_f64()),
                    learning: job.learnt(),
                }
                .tell();
            }
        }
    }

    /// In a log, says how far a job is if nothing was said for a while; in a long run for a tenth of its time.
    pub fn beat(&mut self) {
        let now = self.board.began.elapsed();
        let mut under_way = self.board.jobs.iter().filter(|job| job.is_under_way());
        let Some(job) = under_way.next().filter(|_| self.lines && now >= self.said + LINE.max(now / 10)) else {
            return;
        };
        let more = under_way.count();
        let more = if more > 0 { format!("; {more} more under way") } else { String::new() };
        console::note(&format!(
            "{} {} {}: {} of {} {} ({:.1} s){more}",
            place(&self.board),
            job.kind.doing[0],
            job.name,
            HumanCount(job.done()),
            HumanCount(job.total),
            job.kind.unit,
            now.as_secs_f64()
        ));
        self.said = now;
    }

    /// Ends a task; with the last one of a job comes what came of the job.
    fn end(&mut self, task: Task, error: Option<String>) {
        if !self.board.job(task).end_task(error) {
            return;
        }
        let job = &self.board.jobs[self.board.place(task)];
        let note = if job.is_old() || job.error.is_some() { String::new() } else { job.told() };
        let error = &job.error;
        if self.stop.is_asked() && error.is_none() && job.done() < job.total {
            return;
        }
        if self.events {
            EventLine::TaskFinished {
                about: About::new(&self.board, job),
                reused: job.before(),
                took_s: job.time().as_secs_f64(),
                rate_per_s: job.rate(),
                note: &note,
                error: error.as_deref(),
                learning: job.learnt(),
            }
            .tell();
        }
        let quiet = job.is_old() && error.is_none();
        let line = || line(&self.board, job, error.as_deref().unwrap_or(&note));
        match &self.bars {
            // On a terminal the many evaluations would push everything else away.
            Some(bars) if error.is_some() || (!job.kind.has_episodes && !quiet) => bars.say(&line()),
            None if error.is_some() || (self.lines && !quiet) => {
                console::note(&line());
                self.said = self.board.began.elapsed();
            }
            _ => {}
        }
        self.glance();
    }

    /// The learning curves grow in files of this folder.
    pub fn curves_grow(&self, folder: &Path) {
        let told = format!("the learning curves grow in {}", folder.display());
        match &self.bars {
            Some(bars) => bars.say(&told),
            None if self.lines => console::note(&told),
            None => {}
        }
        if self.events {
            EventLine::LearningCurves { campaign: &self.board.campaign, folder }.tell();
        }
    }

    /// Follows what happens in the campaign.
    pub fn follow(&mut self, event: &Event<'_>) {
        match *event {
            Event::Begun { task, units } => self.job(task).found(task.part, units),
            Event::Progress { task, units } => {
                self.board.job(task).rise(task.part, units);
                self.glance();
            }
            Event::Curve { task, curve, .. } => {
                self.board.job(task).learn(task.part, curve);
                self.glance();
            }
            Event::Reused { task, result } => {
                self.reused += 1;
                let job = self.board.job(task);
                job.found_all(task.part);
                if let Some(TrainingResult { result: Ok(trained), .. }) = (result as &dyn Any).downcast_ref() {
                    job.learn(task.part, &trained.learning_curve);
                }
                self.end(task, None);
            }
            Event::Ended { task, result } => {
                let job = self.job(task);
                job.reach(task.part, result.units());
                job.note(task.part, result.note());
                self.end(task, result.error().map(ToString::to_string));
            }
        }
    }
}

impl Drop for Progress {
    /// Removes the bars, and reports how much was stored before.
    fn drop(&mut self) {
        if let Some(bars) = &self.bars {
            bars.clear();
        }
        let reused = self.reused;
        if reused > 0 && (self.lines || self.bars.is_some()) {
            console::note(&format!("{reused} of {} tasks were there already: {}", self.tasks, self.depends));
        }
    }
}

/// What the stored tasks of a campaign depend on, in words.
fn depends(campaign: &Campaign) -> String {
    let of_program = |program: &Arc<ExternalProgram>| {
        let ExternalProgram { name, version, files, .. } = program.as_ref();
        let named = files.keys().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = files.len().saturating_sub(MAX_NAMED);
        let files = if more > 0 { format!("{named} and {more} more files") } else { named };
        let version = version.as_ref().map(|version| format!("version {version}"));
        let what: Vec<String> = version.into_iter().chain(Some(files).filter(|files| !files.is_empty())).collect();
        format!("; `{name}` is {}", what.join(", "))
    };
    let known = campaign.programs().into_iter().filter(|program| !program.is_unknown());
    format!("same scenario, seed and build{}", known.map(of_program).collect::<String>())
}

/// The line of a job that has ended, with what came of it.
fn line(board: &Board, job: &Job, note: &str) -> String {
    let note = if note.is_empty() { String::new() } else { format!(": {note}") };
    let verb = job.kind.doing[usize::from(job.error.is_none())];
    format!("{} {verb} {}{note} ({})", place(board), job.name, pace(job))
}

/// How many jobs have ended, of how many.
fn place(board: &Board) -> String {
    let total = board.jobs.len();
    format!("[{:width$}/{total}]", board.ended(), width = total.to_string().len())
}

/// How long a job took, and how fast it was.
fn pace(job: &Job) -> String {
    let time = format!("{:.1} s", job.time().as_secs_f64());
    match job.rate() {
        Some(rate) => format!("{time}, {} {}/s", HumanCount(rate.round() as u64), job.kind.unit),
        None => time,
    }
}
