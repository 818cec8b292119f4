//! Bars on a terminal: one for the campaign and one for each job under way, at most a screenful.

use std::time::Duration;

use indicatif::{FormattedDuration, HumanCount, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::board::Board;
use super::job::Job;
use crate::cli::console;

/// Most jobs that have a bar at a time.
const MAX_BARS: usize = 12;

/// The bars of a campaign.
#[derive(Debug)]
pub struct Bars {
    screen: MultiProgress,
    whole: ProgressBar,
    /// Bars of jobs under way, with the places of these on the board.
    shown: Vec<(usize, ProgressBar)>,
}

fn style(form: &str) -> ProgressStyle {
    ProgressStyle::with_template(form).expect("the template is fixed").progress_chars("━╸─")
}

impl Bars {
    /// Draws the bar of the campaign.
    pub fn new(board: &Board) -> Self {
        let screen = MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(5));
        let whole = screen.add(ProgressBar::new(board.jobs.len() as u64));
        whole.set_style(style(
            "{prefix:.bold} {bar:16.green/black.bright} {pos}/{len} tasks, {elapsed_precise} elapsed{wide_msg}",
        ));
        whole.set_prefix(board.campaign.clone());
        whole.enable_steady_tick(Duration::from_millis(500));
        Self { screen, whole, shown: Vec::new() }
    }

    /// Draws the pieces under way.
    pub fn draw(&mut self, board: &Board) {
        let shown = &mut self.shown;
        shown.retain(|(place, bar)| {
            let stays = board.jobs[*place].is_under_way();
            if !stays {
                self.screen.remove(bar);
            }
            stays
        });
        let under_way: Vec<usize> = (0..board.jobs.len()).filter(|place| board.jobs[*place].is_under_way()).collect();
        for place in &under_way {
            if shown.len() < MAX_BARS && shown.iter().all(|(other, _)| other != place) {
                let job = &board.jobs[*place];
                let bar = self.screen.add(ProgressBar::new(job.total));
                bar.set_style(style("  {bar:16.cyan/black.bright} {wide_msg}"));
                shown.push((*place, bar));
            }
        }
        for (place, bar) in shown.iter() {
            let job = &board.jobs[*place];
            bar.set_position(job.done());
            bar.set_message(told(job));
        }
        let hidden = under_way.len() - shown.len();
        let more = if hidden > 0 { format!(", {hidden} more under way") } else { String::new() };
        let left = board.left().map_or(String::new(), |left| format!(", {} left", clock(left)));
        self.whole.set_message(format!("{left}{more}"));
        self.whole.set_position(board.ended() as u64);
    }

    /// Prints a line above the bars.
    pub fn say(&self, line: &str) {
        self.screen.suspend(|| console::note(line));
    }

    /// Removes the bars.
    pub fn clear(&self) {
        self.whole.finish_and_clear();
        let _ = self.screen.clear();
    }
}

/// How far a job has come.
fn told(job: &Job) -> String {
    let kind = job.kind;
    let rate = job.rate().map_or(String::new(), |rate| format!(" {}/s", HumanCount(rate.round() as u64)));
    let left = job.left().map_or(String::new(), |left| format!(" {} left", clock(left)));
    let learnt = job.learnt().and_then(|learnt| learnt.told()).map_or(String::new(), |told| format!(": {told}"));
    let share = (job.done() * 100).checked_div(job.total).unwrap_or(0);
    let closing = if job.done() >= job.total { kind.closing } else { "" };
    format!("{share:3} %{left}{rate}  {} {}{learnt}{closing}", kind.doing[0], job.name)
}

/// A time for people, to the second.
fn clock(time: Duration) -> FormattedDuration {
    FormattedDuration(Duration::from_secs(time.as_secs_f64().ceil() as u64))
}
