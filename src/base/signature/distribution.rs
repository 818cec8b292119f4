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

    /// The number of its parts that are no mixtures themselves.
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

    /// The distribution given that the value is from `low` to `high`; `None` when that is impossible.
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

    /// The distribution given that the value is not this one; `None` when it always is. Only parts that draw single values change.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_distribution() -> impl Strategy<Value = Distribution> {
        let plain = prop_oneof![
            (-9.0..9.0).prop_map(Distribution::Constant),
            (-9.0..9.0, 0.0..5.0).prop_map(|(low, width)| Distribution::Uniform(low, low + width)),
            (-9.0..9.0, 0.1..3.0, -9.0..0.0, 0.1..9.0).prop_map(|(mean, deviation, low, high)| {
                Distribution::Normal { mean, deviation, low: mean + low, high: mean + high }
            }),
        ];
        plain.prop_recursive(2, 8, 3, |inner| {
            prop::collection::vec((0.1..3.0, inner), 1..4).prop_map(Distribution::mixture)
        })
    }

    /// Removes the value at a quantile from a distribution and compares the masses.
    fn take_out(d: &Distribution, at: f64) -> Result<(), TestCaseError> {
        let value = d.quantile(at);
        let left = 1.0 - d.mass(value, value);
        prop_assume!(!(1e-9..1e-3).contains(&left));
        match d.without(value) {
            None => prop_assert!(left < 1e-9),
            Some(kept) => {
                prop_assert!(kept.mass(value, value) < 1e-9);
                let below = d.mass(-100.0, value) - d.mass(value, value);
                prop_assert!((kept.mass(-100.0, value) - below / left).abs() < 1e-9);
            }
        }
        Ok(())
    }

    /// A mixture for which `single_values_can_be_taken_out` once failed.
    #[test]
    fn a_value_can_be_taken_out_of_a_nested_mixture() {
        let inner = Distribution::mixture(vec![
            (0.5, Distribution::Constant(8.427_877_529_368_645)),
            (0.5, Distribution::Constant(0.0)),
        ]);
        let outer = Distribution::mixture(vec![
            (0.450_444_432_642_284_84, inner),
            (0.549_555_567_357_715_2, Distribution::Constant(-0.385_707_721_736_751_3)),
        ]);
        take_out(&outer, 0.288_139_346_871_761_4).unwrap();
    }

    proptest! {
        #[test]
        fn quantiles_lie_in_the_support_and_masses_agree_with_them(
            d in any_distribution(), low in -12.0..12.0, width in 0.0..9.0
        ) {
            let (a, b) = d.support();
            let high = low + width;
            let steps = 4000;
            let values: Vec<f64> = (0..steps).map(|i| d.quantile((f64::from(i) + 0.5) / f64::from(steps))).collect();
            prop_assert!(values.iter().all(|value| a - 1e-9 <= *value && *value <= b + 1e-9));
            let inside = values.iter().filter(|value| low <= **value && **value <= high).count() as f64 / f64::from(steps);
            prop_assert!((inside - d.mass(low, high)).abs() < 0.01, "{inside} {}", d.mass(low, high));
        }

        #[test]
        fn the_density_is_the_mass_of_a_small_interval_over_its_length(d in any_distribution(), at in -12.0..12.0, u in 0.0..1.0) {
            let half = 1e-4;
            for value in [at, d.quantile(u)] {
                let edges = d.pieces().into_iter().flat_map(|(low, high)| [low, high]);
                if edges.into_iter().any(|edge| (edge - value).abs() <= half) {
                    continue;
                }
                let (mass, density) = (d.mass(value - half, value + half), d.density(value));
                prop_assert!((mass - 2.0 * half * density).abs() < 1e-9 + 1e-5 * mass, "{mass} {density} at {value}");
                let (low, high) = d.support();
                prop_assert!(density == 0.0 || (low..=high).contains(&value));
            }
        }

        #[test]
        fn along_the_quantiles_the_density_is_their_slope(mean in -9.0..9.0, deviation in 0.1..3.0, low in -3.0..1.0, width in 0.1..3.0, u in 0.01..0.99) {
            let (low, step) = (mean + low * deviation, 1e-5);
            let normal = Distribution::Normal { mean, deviation, low, high: low + width * deviation };
            for d in [Distribution::Uniform(mean, mean + width), normal] {
                let slope = (d.quantile(u + step) - d.quantile(u - step)) / (2.0 * step);
                prop_assert!((slope * d.density(d.quantile(u)) - 1.0).abs() < 1e-3, "{d:?} at {u}");
            }
        }

        #[test]
        fn truncation_is_conditioning(d in any_distribution(), low in -9.0..6.0, width in 0.5..9.0, cut in 0.0..1.0) {
            let high = low + width;
            prop_assume!(d.mass(low, high) > 1e-6);
            let kept = d.truncated(low, high).unwrap();
            let middle = low + cut * width;
            prop_assert!((kept.mass(low, middle) - d.mass(low, middle) / d.mass(low, high)).abs() < 1e-9);
            prop_assert!((kept.mass(low, high) - 1.0).abs() < 1e-9);
        }

        #[test]
        fn single_values_can_be_taken_out(d in any_distribution(), at in 0.0..1.0) {
            take_out(&d, at)?;
        }

        #[test]
        fn what_has_no_mass_cannot_be_kept(d in any_distribution()) {
            let (a, b) = d.support();
            prop_assert_eq!(d.truncated(b + 1.0, b + 2.0), None);
            prop_assert_eq!(d.truncated(a - 2.0, a - 1.0), None);
        }
    }
}
