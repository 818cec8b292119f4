use std::fmt;

use super::CellEvidence;
use super::place::{Measured, Place};
use crate::record::CellKey;
use crate::statistics::{Sample, holm, normal_below, normal_quantile};

/// The greatest probability of a difference by chance that still counts as one.
const SIGNIFICANT: f64 = 0.05;
/// Trainings disagree if they differ by more than this number of times what their episodes explain,
const BEYOND_EPISODES: f64 = 2.0;
/// and by more than this share of what they gained on average.
const OF_THE_GAIN: f64 = 0.5;

/// Whether the trainings of a cell learnt, by the reward that they were trained for.
///
/// It is about these trainings: episodes are their only source of error. The comparisons of a campaign ask the other question, what further
/// trainings would show, and with a few trainings they seldom have an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Learning {
    /// Mean reward of an episode, of each training with a value.
    pub rewards: Vec<f64>,
    /// The difference from each untrained controller of the place that has the same reward, in the order of the place.
    pub differences: Vec<RewardDifference>,
    /// Standard deviation of the trainings' rewards that their episodes explain; none for a single training.
    pub by_episodes: Option<f64>,
}

/// The mean reward of some trainings less that of an untrained controller, from the same starts.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardDifference {
    /// The untrained controller.
    pub controller: String,
    /// Its mean reward of an episode.
    pub theirs: f64,
    /// Ours less theirs.
    pub difference: f64,
    /// 95 % interval over episodes.
    pub interval: (f64, f64),
    /// Probability of at least such a difference by chance, two-sided.
    pub p: f64,
    /// The same, adjusted for all such differences of the campaign by Holm's method.
    pub holm: f64,
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Learnt {
    /// They are significantly above an untrained controller and below none.
    Yes,
    /// They are significantly below an untrained controller.
    No,
    /// Neither is shown, or there is no untrained controller to compare with.
    Unclear,
}

impl Learnt {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::No => "no",
            Self::Unclear => "unclear",
        }
    }
}

impl RewardDifference {
    /// Whether it is too large to be chance.
    fn is_significant(&self) -> bool {
        self.holm < SIGNIFICANT
    }
}

impl Learning {
    /// Measures the rewards of the trainings of a cell; none for an untrained controller, and for a cell without a value.
    pub(super) fn new(place: &Place, measured: &Measured, cell: usize) -> Option<Self> {
        let key = &place.runs(cell)[0].key;
        if !key.is_trained() {
            return None;
        }
        let own = place.sample(measured, cell, None)?;
        let untrained = (0..place.cells.len()).filter(|other| {
            let other = &place.runs(*other)[0].key;
            !other.is_trained() && other.reward == key.reward
        });
        let difference = |other: usize| {
            let sample = place.sample(measured, cell, Some(other))?;
            Some(RewardDifference::new(place.runs(other)[0].key.controller.clone(), &sample))
        };
        let differences = untrained.filter_map(difference).collect();
        Some(Self { by_episodes: by_episodes(&own), rewards: own.values, differences })
    }

    /// Whether they learnt.
    pub fn learnt(&self) -> Learnt {
        let significant = || self.differences.iter().filter(|each| each.is_significant());
        if significant().any(|each| each.difference < 0.0) {
            Learnt::No
        } else if significant().next().is_some() {
            Learnt::Yes
        } else {
            Learnt::Unclear
        }
    }

    /// Whether the trainings disagree: the standard deviation of their rewards is more than twice what their episodes explain, and more
    /// than half of what they gained over `random` (over 0 without it). None for a single training.
    pub fn disagree(&self) -> Option<bool> {
        let by_episodes = self.by_episodes?;
        let n = self.rewards.len() as f64;
        let mean = self.mean();
        let variance = self.rewards.iter().map(|reward| (reward - mean) * (reward - mean)).sum::<f64>() / (n - 1.0);
        let random = self.differences.iter().find(|each| each.controller == "random");
        let gain = random.map_or(mean, |random| random.difference);
        let spread = variance.sqrt();
        Some(spread > BEYOND_EPISODES * by_episodes && spread > OF_THE_GAIN * gain.abs())
    }

    /// Mean reward over the trainings.
    pub fn mean(&self) -> f64 {
        self.rewards.iter().sum::<f64>() / self.rewards.len() as f64
    }
}

impl RewardDifference {
    fn new(controller: String, sample: &Sample) -> Self {
        let (first, all) = (sample.first, sample.values.len());
        let weight = |member: usize| {
            if member < first { 1.0 / first as f64 } else { -1.0 / (all - first) as f64 }
        };
        let variance: f64 =
            sample.covariance.iter().enumerate().map(|(i, c)| weight(i / all) * weight(i % all) * c).sum();
        // Without any spread, the error of a single episode.
        let error = variance.max(0.0).sqrt().max(1.0 / sample.episodes.effective_size().max(1.0));
        let difference = sample.estimate();
        let half = normal_quantile(0.975) * error;
        let p = 2.0 * normal_below(-(difference / error).abs());
        let theirs = sample.values[first..].iter().sum::<f64>() / (all - first) as f64;
        Self { controller, theirs, difference, interval: (difference - half, difference + half), p, holm: p }
    }
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
    let all = || cells.iter().filter_map(|cell| cell.learning.as_ref()).flat_map(|learning| &learning.differences);
    let adjusted = holm(&all().map(|each| each.p).collect::<Vec<_>>());
    let learnings = cells.iter_mut().filter_map(|cell| cell.learning.as_mut());
    let differences = learnings.flat_map(|learning| &mut learning.differences);
    differences.zip(adjusted).for_each(|(each, holm)| each.holm = holm);
}

/// A reason to doubt the trainings of a cell. `Display` gives a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// The cell.
    pub key: CellKey,
    /// The reason.
    pub reason: Reason,
}

/// Why trainings are doubtful.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// Their reward is below that of an untrained controller.
    Below {
        /// Their mean reward.
        ours: f64,
        /// The controller with the highest reward of those.
        controller: String,
        /// Its mean reward.
        theirs: f64,
    },
    /// Their reward is above that of no untrained controller.
    NotAbove {
        /// Their mean reward.
        ours: f64,
        /// The controller with the lowest reward.
        controller: String,
        /// Its mean reward.
        theirs: f64,
    },
    /// The trainings disagree.
    Disagree {
        /// The mean reward of each.
        rewards: Vec<f64>,
    },
}

impl Reason {
    /// What to try.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Below { .. } | Self::NotAbove { .. } => {
                "train for more `steps`, lead the reward with a `potential`, or spawn the pedestrian where hits are easier"
            }
            Self::Disagree { .. } => "train for more `steps`, and more `runs` to see which result is usual",
        }
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = &self.key;
        match &self.reason {
            Reason::Below { ours, controller, theirs } => write!(
                f,
                "{key}: the trainings are worse than the untrained `{controller}`: mean reward {ours:.3} instead of {theirs:.3}"
            ),
            Reason::NotAbove { ours, controller, theirs } => write!(
                f,
                "{key}: no sign of learning: mean reward {ours:.3}, and {theirs:.3} of the untrained `{controller}`"
            ),
            Reason::Disagree { rewards } => {
                let each: Vec<String> = rewards.iter().map(|reward| format!("{reward:.3}")).collect();
                write!(f, "{key}: the trainings disagree: mean rewards {}", each.join(", "))
            }
        }?;
        write!(f, "; {}", self.reason.advice())
    }
}

/// The doubts about the trainings of a campaign, in the order of the cells. Trainings without an untrained controller to compare with give
/// none.
///
/// A training is judged where it was trained: in its town and against its driver. One that was evaluated only elsewhere is judged there.
pub fn doubts(cells: &[CellEvidence]) -> Vec<Doubt> {
    let is_home = |key: &CellKey| key.town == key.train_town && key.policy == key.train_policy;
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

impl Learning {
    /// The reasons to doubt these trainings.
    fn reasons(&self) -> Vec<Reason> {
        let ours = self.mean();
        let of = |each: &RewardDifference| (each.controller.clone(), each.theirs);
        let by_reward = |a: &&RewardDifference, b: &&RewardDifference| a.theirs.total_cmp(&b.theirs);
        let learnt = match self.learnt() {
            Learnt::Yes => None,
            Learnt::No => {
                let better = self.differences.iter().filter(|each| each.is_significant() && each.difference < 0.0);
                better.max_by(by_reward).map(of).map(|(controller, theirs)| Reason::Below { ours, controller, theirs })
            }
            Learnt::Unclear => {
                let least = self.differences.iter().min_by(by_reward).map(of);
                least.map(|(controller, theirs)| Reason::NotAbove { ours, controller, theirs })
            }
        };
        let disagree = self.disagree() == Some(true);
        learnt.into_iter().chain(disagree.then(|| Reason::Disagree { rewards: self.rewards.clone() })).collect()
    }
}
