//! When a training ends.

use base::choice;
use serde::Serialize;

use super::log::UpdateLog;

choice! {
    /// What ends a training before or at its last decision.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Until {
        /// The number of decisions.
        #[default]
        Steps = "steps",
        /// A plateau of the mean reward, or the number of decisions.
        Plateau = "plateau",
    }
}

/// The parts of a training whose mean rewards are compared.
const PARTS: u64 = 20;

/// The number of parts in a row without a better one that are a plateau: half of the training. A reward that is paid seldom does not rise at first: with a
/// quarter, trainings of 200,000 decisions ended before they had learnt anything.
const MAX_PARTS_WITHOUT_GAIN: usize = 10;

/// The standard errors by which a part is better.
const CLEARLY: f64 = 2.0;

/// Whether the mean reward of episodes has stopped rising.
///
/// The decisions of the whole training are parts of a twentieth each. The mean reward of a part is better if it is above
/// that of the best part so far by two standard errors of their difference. After ten parts in a row that are not, there is a plateau. It is looked for at
/// the first update of a part, when the one before is over; at other updates the answer is no.
pub(super) fn is_plateau(curve: &[UpdateLog], total_steps: u64) -> bool {
    let size = (total_steps / PARTS).max(1);
    let part = |log: &UpdateLog| (log.steps.saturating_sub(1) / size) as usize;
    if let [.., before, last] = curve
        && part(before) == part(last)
    {
        return false;
    }
    let mut parts: Vec<Vec<f64>> = Vec::new();
    for (log, part) in curve.iter().map(|log| (log, part(log))) {
        parts.resize(parts.len().max(part + 1), Vec::new());
        parts[part].extend(log.finished.iter().map(|episode| episode.reward));
    }
    // The last part is not over.
    parts.pop();
    let mut best: Option<(f64, f64)> = None;
    let mut waited = 0;
    for (mean, variance) in parts.iter().filter_map(|rewards| mean_and_its_variance(rewards)) {
        match best {
            Some((highest, its)) if mean - highest <= CLEARLY * (variance + its).sqrt() => waited += 1,
            _ => (best, waited) = (Some((mean, variance)), 0),
        }
    }
    waited >= MAX_PARTS_WITHOUT_GAIN
}

/// The mean of numbers and the variance of that mean; `None` for fewer than two.
fn mean_and_its_variance(values: &[f64]) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (values.len() > 1).then(|| (mean, squares / (n - 1.0) / n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::FinishedEpisode;

    /// Updates of 100 decisions with ten episodes each, whose rewards are this of the update's number, and one more or less.
    fn curve(updates: u64, reward: impl Fn(u64) -> f64) -> Vec<UpdateLog> {
        let episode = |update, place| FinishedEpisode {
            reward: reward(update) + if place % 2 == 0 { 1.0 } else { -1.0 },
            ..FinishedEpisode::default()
        };
        let log = |update| UpdateLog {
            update,
            steps: 100 * update,
            finished: (0..10).map(|place| episode(update, place)).collect(),
            ..UpdateLog::default()
        };
        (1..=updates).map(log).collect()
    }

    #[test]
    fn a_reward_that_stays_is_a_plateau_after_half_and_one_that_rises_is_none() {
        let first = |reward: fn(u64) -> f64| (1..=100).find(|updates| is_plateau(&curve(*updates, reward), 10_000));
        // The best part is the first one; ten others are over with the first update of the twelfth.
        assert_eq!(first(|_| 0.5), Some(56));
        assert_eq!(first(|update| update as f64), None);
        // It rises for twenty updates: the fifth part is the last better one.
        assert_eq!(first(|update| update.min(20) as f64), Some(76));
        // Steps smaller than the noise are no rise.
        assert_eq!(first(|update| 0.001 * update as f64), Some(56));
    }
}
