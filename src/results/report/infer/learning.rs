use std::fmt;

use super::CellEvidence;
use super::common_starts::{CommonStarts, MetricByRun};
use crate::record::CellKey;
use base::choice;
use base::statistics::{Sample, holm, normal_below, normal_quantile};
use compile::UNTRAINED;

/// The greatest probability of a difference by chance that still counts as one.
const SIGNIFICANT: f64 = 0.05;
/// Trainings disagree if they differ by more than this number of times what their episodes explain,
const BEYOND_EPISODES: f64 = 2.0;
/// and by more than this share of what they gained on average.
const OF_THE_GAIN: f64 = 0.5;

/// Whether the trainings of a cell beat untrained pedestrians, by the reward that they were trained for.
///
/// It is about these trainings: episodes are their only source of error. The comparisons of a campaign ask the other question, what further
/// trainings would show, and with a few trainings they seldom have an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Learning {
    /// Mean reward of an episode, of each training with a value.
    pub rewards: Vec<f64>,
    /// The untrained pedestrians of the place that have the same reward, in the order of the place.
    pub baselines: Vec<Baseline>,
    /// Standard deviation of the trainings' rewards that their episodes explain; `None` for a single training.
    pub by_episodes: Option<f64>,
}

/// An untrained controller that met the same starts as some trainings.
#[derive(Debug, Clone, PartialEq)]
pub struct Baseline {
    pub controller: String,
    /// Its mean reward of an episode.
    pub reward: f64,
    /// The mean of the trainings less its reward, with a 95 % interval over episodes.
    pub difference: (f64, (f64, f64)),
    /// Each training less it.
    pub trainings: Vec<TrainingDifference>,
}

/// The mean reward of a training less that of an untrained pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainingDifference {
    pub difference: f64,
    /// Probability of at least such a difference by chance, two-sided.
    pub p: f64,
    /// The same, adjusted for all such differences of the campaign by Holm's method.
    pub holm: f64,
}

choice! {
    /// The answer.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum BeatsUntrained {
        /// Each training is significantly above an untrained pedestrian, and none is below one.
        Yes = "yes",
        /// A training is significantly below an untrained pedestrian.
        No = "no",
        /// Neither is shown, or there is no untrained controller to compare with.
        Unclear = "unclear",
    }
}

impl Learning {
    /// Measures the rewards of the trainings of a cell; `None` for an untrained pedestrian, and for a cell without a value.
    pub(super) fn new(place: &CommonStarts, measured: &MetricByRun, cell: usize) -> Option<Self> {
        let key = &place.runs(cell)[0].key;
        if !key.is_trained() {
            return None;
        }
        let own = place.sample(measured, cell, None)?;
        let untrained = (0..place.cells.len()).filter(|other| {
            let other = &place.runs(*other)[0].key;
            !other.is_trained() && other.reward == key.reward && other.policy == key.policy
        });
        let baseline = |other: usize| {
            let sample = place.sample(measured, cell, Some(other))?;
            Some(Baseline::new(place.runs(other)[0].key.controller.clone(), &sample))
        };
        let baselines = untrained.filter_map(baseline).collect();
        Some(Self { by_episodes: by_episodes(&own), rewards: own.values, baselines })
    }

    /// Whether they beat untrained pedestrians.
    pub fn beats_untrained(&self) -> BeatsUntrained {
        if !self.below().is_empty() {
            BeatsUntrained::No
        } else if self.baselines.is_empty() || self.unclear() > 0 {
            BeatsUntrained::Unclear
        } else {
            BeatsUntrained::Yes
        }
    }

    /// The untrained pedestrians that are significantly above any training, each with the number of these trainings.
    fn below(&self) -> Vec<(&Baseline, usize)> {
        let count = |baseline: &Baseline| baseline.trainings.iter().filter(|each| each.is_below()).count();
        self.baselines.iter().map(|baseline| (baseline, count(baseline))).filter(|(_, count)| *count > 0).collect()
    }

    /// The number of trainings that are significantly above no untrained controller.
    fn unclear(&self) -> usize {
        let is_above =
            |training: &usize| self.baselines.iter().any(|baseline| baseline.trainings[*training].is_above());
        (0..self.rewards.len()).filter(|training| !is_above(training)).count()
    }

    /// Whether the trainings disagree: the standard deviation of their rewards is more than twice what their episodes explain, and more
    /// than half of what they gained over `random` (over 0 without it). `None` for a single training.
    pub fn disagree(&self) -> Option<bool> {
        let by_episodes = self.by_episodes?;
        let n = self.rewards.len() as f64;
        let mean = self.rewards.iter().sum::<f64>() / n;
        let variance = self.rewards.iter().map(|reward| (reward - mean) * (reward - mean)).sum::<f64>() / (n - 1.0);
        let random = self.baselines.iter().find(|baseline| baseline.controller == "random");
        let gain = random.map_or(mean, |random| random.difference.0);
        let spread = variance.sqrt();
        Some(spread > BEYOND_EPISODES * by_episodes && spread > OF_THE_GAIN * gain.abs())
    }

    /// The reasons to doubt these trainings.
    fn reasons(&self) -> Vec<Reason> {
        let (rewards, of) = (self.rewards.clone(), self.rewards.len());
        let most =
            |a: &(&Baseline, usize), b: &(&Baseline, usize)| a.1.cmp(&b.1).then(a.0.reward.total_cmp(&b.0.reward));
        let learnt = match (self.below().into_iter().max_by(most), self.unclear()) {
            (Some((baseline, count)), _) => Some(Reason::Below { count, of, than: baseline.into(), rewards }),
            (None, 0) => None,
            (None, count) => {
                let least = self.baselines.iter().min_by(|a, b| a.reward.total_cmp(&b.reward));
                least.map(|baseline| Reason::NotAbove { count, of, than: baseline.into(), rewards })
            }
        };
        // Of trainings that are all doubtful it says nothing more that they disagree.
        let all = matches!(&learnt, Some(Reason::Below { count, .. } | Reason::NotAbove { count, .. }) if *count == of);
        let disagree =
            (!all && self.disagree() == Some(true)).then(|| Reason::Disagree { rewards: self.rewards.clone() });
        learnt.into_iter().chain(disagree).collect()
    }
}

impl TrainingDifference {
    fn is_significant(&self) -> bool {
        self.holm < SIGNIFICANT
    }

    fn is_below(&self) -> bool {
        self.is_significant() && self.difference < 0.0
    }

    fn is_above(&self) -> bool {
        self.is_significant() && self.difference > 0.0
    }
}

impl Baseline {
    /// From the rewards of trainings and of the runs of an untrained pedestrian.
    fn new(controller: String, sample: &Sample) -> Self {
        let (trained, all) = (sample.first, sample.values.len());
        let reward = sample.values[trained..].iter().sum::<f64>() / (all - trained) as f64;
        let own = |member: usize| if member < trained { 0.0 } else { -1.0 / (all - trained) as f64 };
        let each = |training: usize| {
            let weight = |member: usize| if member == training { 1.0 } else { own(member) };
            let difference = sample.values[training] - reward;
            let p = 2.0 * normal_below(-(difference / error(sample, weight)).abs());
            TrainingDifference { difference, p, holm: p }
        };
        let mean = sample.estimate();
        let weight = |member: usize| if member < trained { 1.0 / trained as f64 } else { own(member) };
        let half = normal_quantile(0.975) * error(sample, weight);
        Self {
            controller,
            reward,
            difference: (mean, (mean - half, mean + half)),
            trainings: (0..trained).map(each).collect(),
        }
    }
}

/// The standard error, over episodes, of a sum of values with these weights. Without any spread, that of a single episode.
fn error(sample: &Sample, weight: impl Fn(usize) -> f64) -> f64 {
    let n = sample.values.len();
    let variance: f64 = sample.covariance.iter().enumerate().map(|(i, c)| weight(i / n) * weight(i % n) * c).sum();
    variance.max(0.0).sqrt().max(1.0 / sample.episodes.effective_size().max(1.0))
}

/// The standard deviation between the values of a sample that follows from the draw of episodes alone.
fn by_episodes(sample: &Sample) -> Option<f64> {
    let n = sample.values.len();
    let own: f64 = (0..n).map(|i| sample.covariance[i * n + i]).sum();
    let all: f64 = sample.covariance.iter().sum();
    (n > 1).then(|| ((own - all / n as f64) / (n - 1) as f64).max(0.0).sqrt())
}

/// Adjusts p for the number of differences of a campaign.
pub fn adjust(cells: &mut [CellEvidence]) {
    let baselines = cells.iter_mut().filter_map(|cell| cell.learning.as_mut()).flat_map(|each| &mut each.baselines);
    let mut all: Vec<&mut TrainingDifference> = baselines.flat_map(|baseline| &mut baseline.trainings).collect();
    let adjusted = holm(&all.iter().map(|each| each.p).collect::<Vec<_>>());
    all.iter_mut().zip(adjusted).for_each(|(each, holm)| each.holm = holm);
}

/// A reason to doubt the trainings of a cell. `Display` gives a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    pub key: CellKey,
    pub reason: Reason,
}

/// An untrained controller with its mean reward of an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Untrained {
    pub controller: String,
    pub reward: f64,
}

impl From<&Baseline> for Untrained {
    fn from(baseline: &Baseline) -> Self {
        Self { controller: baseline.controller.clone(), reward: baseline.reward }
    }
}

/// Why trainings are doubtful.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// The reward of some is below that of an untrained pedestrian.
    Below {
        count: usize,
        /// The number of trainings.
        of: usize,
        /// The pedestrian that most of them are below.
        than: Untrained,
        /// The mean reward of each training.
        rewards: Vec<f64>,
    },
    /// The reward of some is above that of no untrained controller.
    NotAbove {
        count: usize,
        /// The number of trainings.
        of: usize,
        /// The pedestrian with the lowest reward.
        than: Untrained,
        /// The mean reward of each training.
        rewards: Vec<f64>,
    },
    /// The trainings disagree.
    Disagree {
        /// The mean reward of each training.
        rewards: Vec<f64>,
    },
}

impl Reason {
    /// What to try.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Below { .. } | Self::NotAbove { .. } => {
                "train for more `steps`, evaluate more `episodes`, guide learning with a `potential`, or spawn the pedestrian where collisions are easier"
            }
            Self::Disagree { .. } => "train for more `steps`, and more `runs` to see which result is usual",
        }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let listed = |rewards: &[f64]| {
            let each: Vec<String> = rewards.iter().map(|reward| format!("{reward:.3}")).collect();
            each.join(", ")
        };
        let named = |controller: &str| match controller {
            UNTRAINED => "the untrained network".to_string(),
            other => format!("`{other}`"),
        };
        write!(f, "{}: ", self.key)?;
        match &self.reason {
            Reason::Below { count, of, than: Untrained { controller, reward }, rewards } => write!(
                f,
                "{count} of {of} trainings got less reward than {} beyond chance: {} an episode, and `{controller}` {reward:.3}",
                named(controller),
                listed(rewards)
            ),
            Reason::NotAbove { count, of, than: Untrained { controller, reward }, rewards } => write!(
                f,
                "no sign of learning in {count} of {of} trainings: rewards of {} an episode, not beyond chance above the {reward:.3} of {}",
                listed(rewards),
                named(controller)
            ),
            Reason::Disagree { rewards } => {
                write!(f, "the trainings disagree: rewards of {} an episode", listed(rewards))
            }
        }?;
        write!(f, "; {}", self.reason.advice())
    }
}

/// The doubts about the trainings of a campaign, in the order of the cells. Trainings without an untrained pedestrian to compare with give
/// none.
///
/// A training is judged where it was trained: in its town, against its driver, in our simulator. One that was evaluated only elsewhere is judged there.
pub fn doubts(cells: &[CellEvidence]) -> Vec<Doubt> {
    let is_home = |key: &CellKey| key.town == key.train_town && key.policy == key.train_policy && !key.is_elsewhere();
    let same = |a: &CellKey, b: &CellKey| {
        (&a.controller, &a.reward, &a.train_town, &a.train_policy)
            == (&b.controller, &b.reward, &b.train_town, &b.train_policy)
    };
    let has_home = |key: &CellKey| cells.iter().any(|cell| same(&cell.key, key) && is_home(&cell.key));
    let judged = cells.iter().filter(|cell| is_home(&cell.key) || !has_home(&cell.key));
    let reasons = judged.filter_map(|cell| Some((&cell.key, cell.learning.as_ref()?)));
    let doubt = |(key, reason): (&CellKey, Reason)| Doubt { key: key.clone(), reason };
    reasons
        .flat_map(|(key, learning)| learning.reasons().into_iter().map(move |reason| (key, reason)))
        .map(doubt)
        .collect()
}
