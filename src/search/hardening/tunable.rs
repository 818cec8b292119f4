use std::fmt;
use std::sync::Arc;

use episode::{PolicyMaker, Scenario};

/// A key of a driver that may be varied.
#[derive(Debug, Clone, PartialEq)]
pub struct TunableKey {
    pub name: String,
    /// The least and the greatest value, in SI; the least may be the end that the user wrote second.
    pub range: (f64, f64),
    /// The value that it has, in SI; it may lie outside the range.
    pub before: f64,
}

impl TunableKey {
    /// The value at a share of the range, with as many digits as a person would write: a thousandth of the range.
    fn value(&self, at: f64) -> f64 {
        let (from, to) = self.range;
        let value = from + at.clamp(0.0, 1.0) * (to - from);
        let digits = (3.0 - libm::log10((to - from).abs().max(1e-9)).floor()).clamp(0.0, 12.0) as usize;
        let written: f64 = format!("{value:.digits$}").parse().unwrap_or(value);
        written.clamp(from.min(to), from.max(to))
    }
}

/// A side of a condition between two keys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// A varied key, by its place.
    Varied(usize),
    /// The value of a key that is not varied, in SI.
    Fixed(f64),
}

/// Makes a driver of a value for each key, in SI.
type Make = Arc<dyn Fn(&[f64]) -> PolicyMaker + Send + Sync>;

/// A driver with keys that may be varied.
#[derive(Clone)]
pub struct Tunable {
    pub keys: Vec<TunableKey>,
    /// Pairs of which the first must not be above the second.
    rising: Vec<[Side; 2]>,
    make: Make,
}

impl Tunable {
    /// `make` gets a value for each key, in SI.
    pub fn new(keys: Vec<TunableKey>, make: impl Fn(&[f64]) -> PolicyMaker + Send + Sync + 'static) -> Self {
        Self { keys, rising: Vec::new(), make: Arc::new(make) }
    }

    /// The same with pairs of which the first must not be above the second, in the order of a chain that rises.
    pub fn rising(self, rising: Vec<[Side; 2]>) -> Self {
        Self { rising, ..self }
    }

    /// The values of the driver as it is.
    pub fn before(&self) -> Vec<f64> {
        self.keys.iter().map(|key| key.before).collect()
    }

    /// The values at a point of the unit cube; coordinates outside are moved to its faces.
    pub(super) fn values(&self, point: &[f64]) -> Vec<f64> {
        let mut values: Vec<f64> = self.keys.iter().zip(point).map(|(key, at)| key.value(*at)).collect();
        // The greater of a pair is as it is drawn where both are varied.
        for [low, high] in self.rising.iter().rev() {
            match (*low, *high) {
                (Side::Varied(low), Side::Varied(high)) => values[low] = values[low].min(values[high]),
                (Side::Varied(low), Side::Fixed(high)) => values[low] = values[low].min(high),
                (Side::Fixed(low), Side::Varied(high)) => values[high] = values[high].max(low),
                (Side::Fixed(_), Side::Fixed(_)) => {}
            }
        }
        values
    }

    /// The point of the unit cube that is nearest to these values.
    pub(super) fn point(&self, values: &[f64]) -> Vec<f64> {
        let at = |(key, value): (&TunableKey, &f64)| {
            let width = key.range.1 - key.range.0;
            if width > 0.0 { ((value - key.range.0) / width).clamp(0.0, 1.0) } else { 0.0 }
        };
        self.keys.iter().zip(values).map(at).collect()
    }

    /// A scenario whose driver under test has these values.
    pub(crate) fn scenario(&self, scenario: &Arc<Scenario>, values: &[f64]) -> Arc<Scenario> {
        let mut scenario = Scenario::clone(scenario);
        scenario.cast.vehicles[0].policy = (self.make)(values);
        Arc::new(scenario)
    }
}

impl fmt::Debug for Tunable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tunable").field("keys", &self.keys).finish_non_exhaustive()
    }
}
