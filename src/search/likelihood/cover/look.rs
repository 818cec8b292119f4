use base::statistics::clopper_pearson;
use serde::{Deserialize, Serialize};

/// Significance level, one-sided.
const ALPHA: f64 = 0.05;

/// A check of a picture with fresh points, uniform in the box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// The number of points that the picture was learnt from: the first ones.
    pub learnt: u64,
    /// The number of fresh points.
    pub points: u64,
    /// How many of them failed where the picture says that they pass.
    pub worse: u64,
    /// How many of them passed where the picture says that they fail.
    pub better: u64,
    /// The share of the 5 % that this look may use.
    pub alpha: f64,
    /// The one-sided bound of the share of the box that is worse than the picture.
    pub bound: f64,
}

/// The error probability of the look with this number, from 0. All of them together are 5 %: 1/2 + 1/6 + 1/12 + … = 1.
pub(super) fn share_of_look(number: u64) -> f64 {
    let look = number as f64 + 1.0;
    ALPHA / (look * (look + 1.0))
}

/// The one-sided upper bound of a share of which `worse` of `points` were found.
pub(super) fn bound(worse: u64, points: u64, alpha: f64) -> f64 {
    clopper_pearson(worse, points, 2.0 * alpha).1
}

/// The least number of points of which `worse` may be worse with a bound of at most `epsilon`.
pub(super) fn size(worse: u64, epsilon: f64, alpha: f64) -> u64 {
    let (mut low, mut high) = (worse, worse + 1);
    while bound(worse, high, alpha) > epsilon {
        (low, high) = (high, high.saturating_mul(2));
    }
    while high - low > 1 {
        let middle = low.midpoint(high);
        if bound(worse, middle, alpha) > epsilon { low = middle } else { high = middle }
    }
    high
}
