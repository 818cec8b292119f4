use super::{ClusteredCount, MIN_RUNS, MIN_TESTED, Uncertainty};

/// The degrees of freedom of a variance that is known.
const KNOWN: f64 = 1e6;

/// A figure of several trainings, each estimated from episodes with the same starts for all of them; or the difference of
/// two groups of them.
///
/// There are two reasons why another campaign would find another figure: other trainings and other episodes. Members of
/// `values` show the first. `covariance` holds the second; off its diagonal it holds what members have in common because
/// their episodes have the same starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// The figure of each training: those of the first group, then those of the group that is subtracted, if there is one.
    pub values: Vec<f64>,
    /// Covariances of these due to the draw of episodes (n × n, row by row).
    pub covariance: Vec<f64>,
    /// How many of the values belong to the first group.
    pub first: usize,
    /// Whether the members of each group come from trainings, so that they are independent of each other.
    pub trained: [bool; 2],
    /// The episodes that a figure is estimated from; if they have weights, their effective number counts.
    pub episodes: ClusteredCount,
}

impl Sample {
    /// The groups: the ranges of their values, and their signs.
    fn groups(&self) -> [(std::ops::Range<usize>, f64); 2] {
        [(0..self.first, 1.0), (self.first..self.values.len(), -1.0)]
    }

    /// The mean of the first group, minus that of the second if there is one.
    pub fn estimate(&self) -> f64 {
        let mean = |(group, sign): (std::ops::Range<usize>, f64)| {
            let count = group.len().max(1) as f64;
            sign * self.values[group].iter().sum::<f64>() / count
        };
        self.groups().map(mean).iter().sum()
    }

    /// Student's 95 % interval over trainings, from the [`uncertainty`](Self::uncertainty); `None` with [few runs](Self::has_few_runs).
    pub fn interval(&self) -> Option<(f64, f64)> {
        self.interval_at(0.05)
    }

    /// [`interval`](Self::interval) where a share `alpha` of all intervals may miss the figure, instead of 0.05.
    pub fn interval_at(&self, alpha: f64) -> Option<(f64, f64)> {
        if self.has_few_runs() {
            return None;
        }
        Some(self.uncertainty()?.interval_at(self.estimate(), alpha))
    }

    /// The two-sided p-value of a figure that is 0 in truth, by Student's t; see [`uncertainty`](Self::uncertainty). `None` where a group has several runs, but
    /// fewer than [`MIN_TESTED`].
    pub fn p(&self) -> Option<f64> {
        if self.groups().iter().any(|(group, _)| (2..MIN_TESTED).contains(&group.len())) {
            return None;
        }
        Some(self.uncertainty()?.p(self.estimate()))
    }

    /// Whether a group has several runs, but fewer than [`MIN_RUNS`]: its single values say more than an interval.
    pub fn has_few_runs(&self) -> bool {
        self.groups().iter().any(|(group, _)| (2..MIN_RUNS).contains(&group.len()))
    }

    /// The standard error about further trainings and further episodes; `None` if a group is a single training.
    ///
    /// Trainings and starts are crossed: the figure of training i at start j is μ + tᵢ + sⱼ + eᵢⱼ. The variance of a mean over I
    /// trainings and J starts is σt²/I + σs²/J + σe²/(I J). The variance between the trainings' means, divided by I, estimates the
    /// first and the last part. It shows nothing of the second one, since all trainings meet the same starts; the covariance of
    /// different trainings over these starts estimates that one. The degrees of freedom are Welch's and Satterthwaite's, in which
    /// the part of the starts is known.
    ///
    /// A pedestrian that is not trained has only the part of the starts. If all is 0, the variance of a single episode is used.
    ///
    /// # Source
    /// Searle, Casella and McCulloch, *Variance Components*, 1992, chapter 4 (two-way crossed random model).
    pub fn uncertainty(&self) -> Option<Uncertainty> {
        let (mut between, mut squares, mut common, mut fewest) = (0.0, 0.0, 0.0, KNOWN);
        for ((group, _), trained) in self.groups().into_iter().zip(self.trained) {
            let n = group.len() as f64;
            common += self.mean_covariance(&group, &group);
            if group.len() > 1 {
                let mean = self.values[group.clone()].iter().sum::<f64>() / n;
                let spread = self.values[group].iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
                let variance = spread / (n - 1.0) / n;
                between += variance;
                squares += variance * variance / (n - 1.0);
                fewest = fewest.min(n - 1.0);
            } else if group.len() == 1 && trained {
                return None;
            }
        }
        let [(first, _), (second, _)] = self.groups();
        common -= 2.0 * self.mean_covariance(&first, &second);
        let variance = between + common.max(0.0);
        let least = 1.0 / self.episodes.effective_size().max(1.0);
        if variance <= least * least {
            return Some(Uncertainty { error: least, degrees: fewest });
        }
        let degrees = if squares > 0.0 { (variance * variance / squares).min(KNOWN) } else { KNOWN };
        Some(Uncertainty { error: variance.sqrt(), degrees })
    }

    /// The mean covariance between members of two groups, each with the others except in a group of one; 0 for an empty one.
    fn mean_covariance(&self, rows: &std::ops::Range<usize>, columns: &std::ops::Range<usize>) -> f64 {
        let (mut sum, mut pairs) = (0.0, 0.0);
        for row in rows.clone() {
            for column in columns.clone().filter(|column| row != *column || rows.len() == 1) {
                sum += self.covariance[row * self.values.len() + column];
                pairs += 1.0;
            }
        }
        if pairs > 0.0 { sum / pairs } else { 0.0 }
    }
}
