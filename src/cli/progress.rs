//! Progress on the error stream: bars on a terminal, one line for each finished piece elsewhere.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::interrupt;
use crate::campaign::{Cell, CellError, Observer, SearchResult, TrainingResult, cells};
use crate::compile::{Campaign, Evaluation, Training};
use crate::rl::UpdateLog;
use crate::store::cell_name;

/// Hears a campaign and draws bars.
pub struct Progress<'a> {
    campaign: &'a Campaign,
    bars: MultiProgress,
    trainings: ProgressBar,
    episodes: ProgressBar,
    done: Vec<AtomicU64>,
    reused: AtomicU64,
    quiet: bool,
}

impl<'a> Progress<'a> {
    /// Gets ready for a campaign.
    pub fn new(campaign: &'a Campaign) -> Self {
        let quiet = !std::io::stderr().is_terminal();
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(5) };
        let bars = MultiProgress::with_draw_target(target);
        let bar = |length: u64, what: &str| {
            let bar = bars.add(ProgressBar::new(length));
            let form = "{msg:9} {wide_bar:.cyan/blue} {human_pos}/{human_len} {rate} {eta} left";
            let rate = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{:.0}/s", state.per_sec());
            };
            bar.set_style(ProgressStyle::with_template(form).expect("the template is fixed").with_key("rate", rate));
            bar.set_message(what.to_string());
            bar
        };
        let decisions = campaign.trainings.iter().map(|training| training.config.total_steps).sum();
        let episodes = campaign.evaluations.iter().map(|evaluation| u64::from(evaluation.episodes)).sum();
        Self {
            campaign,
            trainings: bar(decisions, "training"),
            episodes: bar(episodes, "trying"),
            done: campaign.trainings.iter().map(|_| AtomicU64::new(0)).collect(),
            reused: AtomicU64::new(0),
            quiet,
            bars,
        }
    }

    /// Removes the bars, and says how much was there before.
    pub fn finish(self) {
        self.trainings.finish_and_clear();
        self.episodes.finish_and_clear();
        let (reused, all) = (self.reused.into_inner(), cells(self.campaign).count());
        if reused > 0 {
            anstream::eprintln!("{reused} of {all} cells were there already");
        }
    }

    fn line(&self, text: &str) {
        if self.quiet {
            anstream::eprintln!("{text}");
        } else {
            self.bars.suspend(|| anstream::eprintln!("{text}"));
        }
    }
}

impl Observer for Progress<'_> {
    fn trained(&self, training: usize, _: &Training, log: &UpdateLog) {
        let before = self.done[training].swap(log.steps, Ordering::Relaxed);
        self.trainings.inc(log.steps.saturating_sub(before));
    }

    fn training_ended(&self, _: usize, result: &TrainingResult) {
        let key = &result.key;
        let name = format!("trained {} in {} against {}, run {}", key.reward, key.town, key.policy, key.run);
        match &result.result {
            Ok(trained) => {
                let reward = trained.learning_curve.last().and_then(|log| log.mean_reward);
                let reward = reward.map_or("no episode ended".into(), |reward| format!("mean reward {reward:.3}"));
                self.line(&format!("{name}: {reward}"));
            }
            Err(error) => self.line(&format!("{name}: {error}")),
        }
    }

    fn tried(&self, _: usize, _: &Evaluation) {
        self.episodes.inc(1);
    }

    fn chunk_ended(&self, evaluation: usize, chunk: u32, error: Option<&CellError>) {
        if let Some(error) = error {
            let name = cell_name(self.campaign, Cell::Chunk { evaluation, chunk });
            self.line(&format!("{name}: {error}"));
        }
    }

    fn reused(&self, cell: Cell) {
        self.reused.fetch_add(1, Ordering::Relaxed);
        match cell {
            Cell::Training(index) => self.trainings.dec_length(self.campaign.trainings[index].config.total_steps),
            Cell::Chunk { evaluation, chunk } => {
                self.episodes.dec_length(self.campaign.evaluations[evaluation].chunk(chunk).len() as u64);
            }
            Cell::Search(_) => {}
        }
    }

    fn continued(&self, _: Cell, episodes: u32) {
        self.episodes.dec_length(episodes.into());
    }

    fn searched(&self, _: usize, result: &SearchResult) {
        let (key, spent) = (&result.key, &result.spent);
        let name = format!("searched {} in {} against {}, run {}", key.falsifier, key.town, key.policy, key.run);
        match &result.error {
            Some(error) => self.line(&format!("{name}: {error}")),
            None => self.line(&format!("{name}: {} failures in {} episodes", spent.failures.len(), spent.episodes)),
        }
    }

    fn stop(&self) -> bool {
        interrupt::asked()
    }
}
