//! The distributions of a scenario: `7 m .. 30 m`, `truncated(normal(5 m/s, 1 m/s), 0 m/s .. 8 m/s)`, `choice(a, b)`.
//!
//! A draw is the quantile of one uniform number, so every key takes exactly one number from its stream.

use std::sync::Arc;

use crate::statistics::{normal_below, normal_quantile};

/// A distribution of one quantity, in SI.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Always this value.
    Constant(f64),
    /// Uniform from the first to the second.
    Uniform(f64, f64),
    /// Normal, conditioned on two bounds.
    Normal {
        /// Mean of the distribution without bounds.
        mean: f64,
        /// Standard deviation of the distribution without bounds.
        deviation: f64,
        /// Minimum; may be −∞.
        low: f64,
        /// Maximum; may be ∞.
        high: f64,
    },
    /// One of several, with weights above zero that sum to 1.
    Mixture(Arc<[(f64, Distribution)]>),
}

impl Distribution {
    /// A mixture with these weights, which need not sum to 1.
    pub fn mixture(mut parts: Vec<(f64, Distribution)>) -> Self {
        let total: f64 = parts.iter().map(|(weight, _)| weight).sum();
        parts.iter_mut().for_each(|(weight, _)| *weight /= total);
        Self::Mixture(parts.into())
    }

    /// The number of its parts that are not mixtures themselves.
    pub fn leaves(&self) -> usize {
        match self {
            Self::Mixture(parts) => parts.iter().map(|(_, part)| part.leaves()).sum(),
            _ => 1,
        }
    }

    /// The minimum and the maximum that it can take.
    pub fn support(&self) -> (f64, f64) {
        match self {
            Self::Constant(value) => (*value, *value),
            Self::Uniform(low, high) | Self::Normal { low, high, .. } => (*low, *high),
            Self::Mixture(parts) => {
                let supports = parts.iter().map(|(_, part)| part.support());
                supports.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (low, high)| (a.min(low), b.max(high)))
            }
        }
    }

    /// The probability of a value from `low` to `high`, both inclusive.
    pub fn mass(&self, low: f64, high: f64) -> f64 {
        match self {
            Self::Constant(value) => f64::from(u8::from(low <= *value && *value <= high)),
            Self::Uniform(a, b) if a == b => f64::from(u8::from(low <= *a && *a <= high)),
            Self::Uniform(a, b) => ((high.min(*b) - low.max(*a)) / (b - a)).max(0.0),
            Self::Normal { mean, deviation, low: a, high: b } => {
                let below = |bound: f64| normal_below((bound - mean) / deviation);
                let all = below(*b) - below(*a);
                ((below(high.min(*b)) - below(low.max(*a))) / all).max(0.0)
            }
            Self::Mixture(parts) => parts.iter().map(|(weight, part)| weight * part.mass(low, high)).sum(),
        }
    }

    /// The probability density at a value, in one over the unit of the quantity; 0 outside of the support.
    ///
    /// Single values with a probability of their own (constants) are not part of it; their probability is `mass(value, value)`.
    pub fn density(&self, value: f64) -> f64 {
        match self {
            Self::Constant(_) => 0.0,
            Self::Uniform(low, high) => {
                if low < high && (*low..=*high).contains(&value) {
                    1.0 / (high - low)
                } else {
                    0.0
                }
            }
            Self::Normal { low, high, .. } if !(*low..=*high).contains(&value) => 0.0,
            Self::Normal { mean, deviation, low, high } => {
                let (a, b) = ((low - mean) / deviation, (high - mean) / deviation);
                // In the upper tail the lower one is more precise.
                let kept =
                    if a > 0.0 { normal_below(-a) - normal_below(-b) } else { normal_below(b) - normal_below(a) };
                let z = (value - mean) / deviation;
                libm::exp(-z * z / 2.0) / ((2.0 * std::f64::consts::PI).sqrt() * deviation * kept)
            }
            Self::Mixture(parts) => parts.iter().map(|(weight, part)| weight * part.density(value)).sum(),
        }
    }

    /// The distribution given that the value is from `low` to `high`; `None` if that is impossible.
    pub fn truncated(&self, low: f64, high: f64) -> Option<Self> {
        let (a, b) = self.support();
        if low <= a && b <= high {
            return Some(self.clone());
        }
        match self {
            Self::Constant(value) => (low <= *value && *value <= high).then(|| self.clone()),
            Self::Uniform(a, b) => {
                let (a, b) = (a.max(low), b.min(high));
                (a <= b).then_some(Self::Uniform(a, b))
            }
            Self::Normal { mean, deviation, low: a, high: b } => {
                let kept = Self::Normal { mean: *mean, deviation: *deviation, low: a.max(low), high: b.min(high) };
                (self.mass(low, high) > 0.0).then_some(kept)
            }
            Self::Mixture(parts) => {
                let kept = parts.iter().filter_map(|(weight, part)| {
                    let weight = weight * part.mass(low, high);
                    let part = part.truncated(low, high)?;
                    (weight > 0.0).then_some((weight, part))
                });
                let kept: Vec<_> = kept.collect();
                (!kept.is_empty()).then(|| Self::mixture(kept))
            }
        }
    }

    /// The distribution given that the value is not this one; `None` if it always is. Only parts that draw single values change.
    pub fn without(&self, value: f64) -> Option<Self> {
        match self {
            Self::Constant(only) if *only == value => None,
            Self::Uniform(low, high) if low == high && *low == value => None,
            Self::Mixture(parts) => {
                let kept = parts.iter().filter_map(|(weight, part)| {
                    let weight = weight * (1.0 - part.mass(value, value));
                    let part = part.without(value)?;
                    (weight > 0.0).then_some((weight, part))
                });
                let kept: Vec<_> = kept.collect();
                (!kept.is_empty()).then(|| Self::mixture(kept))
            }
            other => Some(other.clone()),
        }
    }

    /// The minimum and the maximum of each of its parts.
    pub fn pieces(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Mixture(parts) => parts.iter().flat_map(|(_, part)| part.pieces()).collect(),
            other => vec![other.support()],
        }
    }

    /// The value below which a share `u` of all values lies, `u` from 0 to 1.
    ///
    /// In a mixture the parts follow each other in the written order, so it rises with `u` only within each part.
    pub fn quantile(&self, u: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Uniform(low, high) => low + (high - low) * u,
            Self::Normal { mean, deviation, low, high } => {
                let (a, b) = ((low - mean) / deviation, (high - mean) / deviation);
                // In the upper tail the lower one is more precise.
                let z = if a > 0.0 {
                    let (from, to) = (normal_below(-b), normal_below(-a));
                    -normal_quantile(to - (to - from) * u)
                } else {
                    let (from, to) = (normal_below(a), normal_below(b));
                    normal_quantile(from + (to - from) * u)
                };
                (mean + deviation * z).clamp(*low, *high)
            }
            Self::Mixture(parts) => {
                let mut below = 0.0;
                for (weight, part) in parts.iter() {
                    if u < below + weight {
                        return part.quantile(((u - below) / weight).clamp(0.0, 1.0));
                    }
                    below += weight;
                }
                parts.last().map_or(0.0, |(_, last)| last.quantile(1.0))
            }
        }
    }
}
