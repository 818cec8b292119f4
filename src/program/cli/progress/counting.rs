use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::showing::Showing;
use crate::cli::console;

/// Least time between two lines in a log.
pub(super) const LINE: Duration = Duration::from_secs(10);

/// Shows how many episodes of a stage of known size are done: a bar on a terminal, a line now and then elsewhere.
#[derive(Debug)]
pub struct Counting {
    /// What is done to how many of what, as half a sentence.
    doing: &'static str,
    bar: Option<ProgressBar>,
    lines: bool,
    began: Instant,
    last: Instant,
    done: u64,
    all: u64,
}

impl Counting {
    /// Begins a stage.
    pub fn new(doing: &'static str, all: u64, showing: Showing) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bars = showing == Showing::Bars || showing == Showing::Auto && terminal;
        let lines = showing == Showing::Lines || showing == Showing::Auto && !terminal;
        let bar = bars.then(|| {
            let form = "{prefix:.bold} {bar:16.green/black.bright} {human_pos}/{human_len}, {elapsed_precise} elapsed, {eta_precise} left";
            let style = ProgressStyle::with_template(form).expect("the template is fixed").progress_chars("━╸─");
            let bar = ProgressBar::with_draw_target(Some(all), ProgressDrawTarget::stderr_with_hz(5));
            bar.set_style(style);
            bar.set_prefix(doing);
            bar
        });
        let now = Instant::now();
        Self { doing, bar, lines: lines && all > 0, began: now, last: now, done: 0, all }
    }

    /// Says how far it is, if nothing was said for a while.
    pub fn beat(&mut self) {
        self.reach(self.done);
    }

    /// Notes a number of finished episodes; an older, smaller number is passed over.
    pub fn reach(&mut self, done: u64) {
        self.done = self.done.max(done);
        if let Some(bar) = &self.bar {
            bar.set_position(self.done);
        }
        let is_over = self.done == self.all;
        if self.lines && (is_over || self.last.elapsed() >= LINE) {
            self.last = Instant::now();
            let took = self.began.elapsed().as_secs_f64();
            console::note(&format!(
                "{}: {} of {} ({took:.1} s{})",
                self.doing,
                HumanCount(self.done),
                HumanCount(self.all),
                left(took, self.done, self.all)
            ));
            self.lines = !is_over;
        }
    }
}

/// How long the rest takes at the pace so far; empty where nothing is left or known.
fn left(took: f64, done: u64, all: u64) -> String {
    match done {
        0 => String::new(),
        done if done >= all => String::new(),
        done => format!(", {:.0} s left", took * (all - done) as f64 / done as f64),
    }
}

impl Drop for Counting {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
