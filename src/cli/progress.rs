//! Progress on the error stream: bars on a terminal, one line for each finished piece elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::interrupt;
use crate::campaign::{Observer, SearchResult, TrainingResult};
use crate::compile::{Campaign, Evaluation, Training};
use crate::rl::UpdateLog;

/// Hears a campaign, draws bars and takes times.
pub struct Progress {
    trainings: ProgressBar,
    episodes: ProgressBar,
    done: Vec<AtomicU64>,
    times: Mutex<Vec<(Option<Instant>, Duration)>>,
    quiet: bool,
}

impl Progress {
    /// Gets ready for a campaign.
    pub fn new(campaign: &Campaign) -> Self {
        let quiet = !std::io::stderr().is_terminal();
        let target = || if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(5) };
        let bar = |length: u64, what: &str| {
            let bar = ProgressBar::with_draw_target(Some(length), target());
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
            trainings: bar(decisions, "training"),
            episodes: bar(episodes, "trying"),
            done: campaign.trainings.iter().map(|_| AtomicU64::new(0)).collect(),
            times: Mutex::new(vec![(None, Duration::ZERO); campaign.trainings.len()]),
            quiet,
        }
    }

    /// Removes the bars and gives the wall time of every training.
    pub fn finish(self) -> Vec<Duration> {
        self.trainings.finish_and_clear();
        self.episodes.finish_and_clear();
        let times = self.times.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        times.into_iter().map(|(_, time)| time).collect()
    }

    fn line(&self, text: &str) {
        if self.quiet {
            anstream::eprintln!("{text}");
        } else {
            self.trainings.suspend(|| anstream::eprintln!("{text}"));
        }
    }
}

impl Observer for Progress {
    fn training_begun(&self, training: usize) {
        let mut times = self.times.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        times[training].0 = Some(Instant::now());
    }

    fn trained(&self, training: usize, _: &Training, log: &UpdateLog) {
        let before = self.done[training].swap(log.steps, Ordering::Relaxed);
        self.trainings.inc(log.steps.saturating_sub(before));
        let mut times = self.times.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (begun, time) = &mut times[training];
        *time = begun.map_or(Duration::ZERO, |begun| begun.elapsed());
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
        if self.episodes.position() == 0 {
            self.trainings.finish_and_clear();
            self.episodes.reset_elapsed();
        }
        self.episodes.inc(1);
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
