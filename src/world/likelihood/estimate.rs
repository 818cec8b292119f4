use super::Event;
use base::statistics::{clopper_pearson, student_quantile};

/// The probability of an event in an encounter, with a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Likelihood {
    pub event: Event,
    /// The probability, 0 to 1.
    pub probability: f64,
    /// The 95 % interval. Where the event was never seen it begins at 0, and its end is a one-sided bound.
    pub low: f64,
    pub high: f64,
    /// Standard error of the probability as a share of it; none where the event was never seen.
    pub relative_error: Option<f64>,
    /// Number of fresh encounters whose share has the same error.
    pub effective: f64,
    /// Encounters, populations or draws in which it was seen.
    pub seen: u64,
}

/// The least effective number of weights of a sum that has an interval, and the greatest share of a single one.
pub(super) const SOUND: (f64, f64) = (50.0, 0.1);

/// The result of an estimator.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    /// One for each event, in the order of [`Event`].
    pub likelihoods: Vec<Likelihood>,
    /// Encounters that were simulated, whole or in part.
    pub encounters: u64,
    pub ticks: u64,
    /// Share of fresh encounters that count; probabilities are among these.
    pub counting: f64,
    /// Encounters of the plain kind among them: fresh ones, each from a start of its own.
    pub fresh: u64,
    /// The levels that the populations climbed, from the first to 0; empty for other methods.
    pub levels: Vec<f64>,
    /// The probability of a failure by each population; empty for other methods.
    pub populations: Vec<f64>,
    /// The greatest share of a single encounter in the sum of the weights; 0 for methods without weights.
    pub greatest_weight: f64,
    /// Whether it ended before the relative error was reached.
    pub short: bool,
    /// Whether it was stopped from outside.
    pub stopped: bool,
}

impl Likelihood {
    /// Of a number of independent encounters, in some of which the event was seen.
    pub fn of_share(event: Event, seen: u64, encounters: u64) -> Self {
        // Where nothing was seen the bound is one-sided.
        let alpha = if seen == 0 { 0.1 } else { 0.05 };
        let (low, high) = clopper_pearson(seen, encounters, alpha);
        let probability = seen as f64 / (encounters.max(1)) as f64;
        let relative_error = (seen > 0).then(|| ((1.0 - probability) / seen as f64).sqrt());
        Self { event, probability, low, high, relative_error, effective: encounters as f64, seen }
    }

    /// Of independent estimates without bias, one of each population. `fresh` is the number of fresh encounters among all, which bounds what was never
    /// seen.
    pub fn of_estimates(event: Event, estimates: &[f64], fresh: u64) -> Self {
        let count = estimates.len() as f64;
        let mean = estimates.iter().sum::<f64>() / count.max(1.0);
        let seen = estimates.iter().filter(|each| **each > 0.0).count() as u64;
        if seen == 0 {
            return Self { effective: fresh as f64, seen, ..Self::of_share(event, 0, fresh) };
        }
        let squares: f64 = estimates.iter().map(|each| (each - mean) * (each - mean)).sum();
        let error = (squares / (count * (count - 1.0))).sqrt() / mean;
        let (low, high) = around(mean, error, student_quantile(count - 1.0));
        let effective = (1.0 - mean) / (mean * error * error);
        Self { event, probability: mean, low, high, relative_error: Some(error), effective, seen }
    }

    /// The same event among the encounters that count, where all others were asked too.
    pub fn among(self, counting: f64) -> Self {
        let share = |value: f64| (value / counting).min(1.0);
        Self { probability: share(self.probability), low: share(self.low), high: share(self.high), ..self }
    }
}

/// An interval about a probability with a relative error, equally wide in orders of magnitude: estimates of a small probability are skewed.
pub(super) fn around(probability: f64, error: f64, quantile: f64) -> (f64, f64) {
    let factor = libm::exp(quantile * error);
    (probability / factor, (probability * factor).min(1.0))
}

impl Estimate {
    pub fn of(&self, event: Event) -> &Likelihood {
        self.likelihoods.iter().find(|each| each.event == event).expect("each event has one")
    }

    /// Whether a few encounters are most of a sum of weights.
    pub fn is_degenerate(&self) -> bool {
        let few = |each: &Likelihood| each.seen > 0 && each.effective < SOUND.0;
        self.greatest_weight > SOUND.1 || self.greatest_weight > 0.0 && self.likelihoods.iter().any(few)
    }

    /// Whether the populations disagree: the greatest says more than ten times the median.
    pub fn populations_disagree(&self) -> bool {
        let mut sorted = self.populations.clone();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        sorted.last().is_some_and(|greatest| *greatest > 10.0 * middle)
    }
}
