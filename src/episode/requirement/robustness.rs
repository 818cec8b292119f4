use std::collections::VecDeque;

use super::Degree;
use base::signature::{Comparison, Requirement, Temporal, VariableId, Within};

/// The margins of a requirement's comparisons, sample by sample.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Number of comparisons.
    parts: usize,
    /// The margins of a sample after those of the sample before it.
    margins: Vec<f64>,
    /// The number of samples for which memory is reserved.
    reserved: usize,
    /// Memory for the values of operators.
    spare: Vec<Vec<Degree>>,
    window: VecDeque<(usize, Degree)>,
    /// What stands before each `implies`; what is never true of a formula that only speaks of what is not there.
    conditions: Vec<Temporal>,
}

impl Trace {
    /// Reserves memory for a requirement and this number of samples. The values of silent variables say nothing: where they decide whether it is satisfied, it
    /// does not apply.
    pub fn new(requirement: &Requirement, samples: usize, is_silent: &impl Fn(VariableId) -> bool) -> Self {
        let parts = requirement.parts.len();
        let (margins, window) = (Vec::with_capacity(parts * samples), VecDeque::with_capacity(samples));
        let conditions = match requirement.says_something(is_silent) {
            true => requirement.formula.conditions(),
            false => vec![Temporal::Constant(false)],
        };
        Self { parts, margins, window, reserved: samples, conditions, ..Self::default() }
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.margins.clear();
    }

    /// Adds a sample.
    pub fn push(&mut self, requirement: &Requirement, values: &impl Fn(VariableId) -> f64) {
        let is_scaled = requirement.is_scaled();
        self.margins.extend(requirement.parts.iter().map(|part| margin(part, is_scaled, values)));
    }

    /// The number of samples; 0 of a requirement without comparisons.
    fn samples(&self) -> usize {
        self.margins.len().checked_div(self.parts).unwrap_or(1)
    }

    /// The degree of the requirement at the first sample, for samples this time (s) apart.
    pub fn degree(&mut self, requirement: &Requirement, dt: f64) -> Degree {
        let values = self.evaluate(&requirement.formula, dt);
        let first = values.first().copied();
        self.spare.push(values);
        let degree = first.unwrap_or(Degree::constant(true, 0));
        Degree { applies: degree.is_violated() || self.applies(dt), ..degree }
    }

    /// Whether an antecedent of an `implies` held in a sample.
    fn applies(&mut self, dt: f64) -> bool {
        let conditions = std::mem::take(&mut self.conditions);
        let holds = |condition: &Temporal| {
            let values = self.evaluate(condition, dt);
            let holds = values.iter().any(|value| !value.is_violated());
            self.spare.push(values);
            holds
        };
        let applies = conditions.is_empty() || conditions.iter().any(holds);
        self.conditions = conditions;
        applies
    }

    /// The degrees of a formula at all samples.
    fn evaluate(&mut self, formula: &Temporal, dt: f64) -> Vec<Degree> {
        let samples = self.samples();
        match formula {
            Temporal::Constant(truth) => {
                let mut values = self.empty();
                values.extend((0..samples).map(|sample| Degree::constant(*truth, sample as u32)));
                values
            }
            Temporal::Part(index) => {
                let mut values = self.empty();
                let margins = self.margins.iter().skip(*index).step_by(self.parts);
                values.extend((0..).zip(margins).map(|(sample, margin)| Degree {
                    robustness: *margin,
                    sample,
                    part: Some(*index as u16),
                    applies: true,
                }));
                values
            }
            Temporal::Not(inner) => {
                let mut values = self.evaluate(inner, dt);
                values.iter_mut().for_each(|value| value.robustness = -value.robustness);
                values
            }
            Temporal::And(a, b) => self.both(a, b, dt, Degree::and),
            Temporal::Or(a, b) => self.both(a, b, dt, Degree::or),
            Temporal::Always(within, inner) => {
                let mut values = self.evaluate(inner, dt);
                self.slide(&mut values, Ticks::new(within, dt), Wanted::Least);
                values
            }
            Temporal::Eventually(within, inner) => {
                let mut values = self.evaluate(inner, dt);
                self.slide(&mut values, Ticks::new(within, dt), Wanted::Greatest);
                values
            }
            Temporal::Until(within, first, second) => {
                let (mut first, mut second) = (self.evaluate(first, dt), self.evaluate(second, dt));
                self.until(&mut first, &mut second, Ticks::new(within, dt));
                self.spare.push(second);
                first
            }
        }
    }

    fn empty(&mut self) -> Vec<Degree> {
        let mut values = self.spare.pop().unwrap_or_else(|| Vec::with_capacity(self.reserved));
        values.clear();
        values
    }

    fn both(&mut self, a: &Temporal, b: &Temporal, dt: f64, which: fn(Degree, Degree) -> Degree) -> Vec<Degree> {
        let (mut values, other) = (self.evaluate(a, dt), self.evaluate(b, dt));
        values.iter_mut().zip(&other).for_each(|(value, other)| *value = which(*value, *other));
        self.spare.push(other);
        values
    }

    /// Replaces each value by the least or the greatest of its bound.
    fn slide(&mut self, values: &mut [Degree], ticks: Ticks, wanted: Wanted) {
        shift(values, ticks, wanted.of_nothing());
        let Some(width) = ticks.width.filter(|width| *width < values.len()) else {
            for sample in (1..values.len()).rev() {
                values[sample - 1] = wanted.of(values[sample - 1], values[sample]);
            }
            return;
        };
        // From the last sample to the first. A candidate leaves when it is outside the bound, or when an earlier one is as good.
        self.window.clear();
        for sample in (0..values.len()).rev() {
            let entering = values[sample];
            while self.window.back().is_some_and(|(_, back)| wanted.replaces(&entering, back)) {
                self.window.pop_back();
            }
            self.window.push_back((sample, entering));
            while self.window.front().is_some_and(|(place, _)| *place > sample + width) {
                self.window.pop_front();
            }
            values[sample] = self.window.front().map_or(entering, |(_, front)| *front);
        }
    }

    /// Replaces each value of the first by that of `until` with a bound.
    ///
    /// `until(a, b, [from, to])` is `eventually(b, [from, to])` and `until(a, b, [from, ∞))`; the latter is `a` at all samples before `from`, and
    /// `until(a, b)` at `from`.
    fn until(&mut self, first: &mut [Degree], second: &mut [Degree], ticks: Ticks) {
        let mut free = self.empty();
        free.extend_from_slice(second);
        for sample in (1..free.len()).rev() {
            free[sample - 1] = second[sample - 1].or(first[sample - 1].and(free[sample]));
        }
        shift(&mut free, Ticks { width: None, ..ticks }, Wanted::Greatest.of_nothing());
        match ticks.from.checked_sub(1) {
            Some(width) => {
                self.slide(first, Ticks { from: 0, width: Some(width), is_empty: false }, Wanted::Least);
                first.iter_mut().zip(&free).for_each(|(value, free)| *value = value.and(*free));
            }
            None => first.copy_from_slice(&free),
        }
        if ticks.width.is_some() || ticks.is_empty {
            self.slide(second, ticks, Wanted::Greatest);
            first.iter_mut().zip(&*second).for_each(|(value, second)| *value = value.and(*second));
        }
        self.spare.push(free);
    }
}

/// A margin that is signed as [the module](super) says.
fn margin(part: &Comparison, is_scaled: bool, values: &impl Fn(VariableId) -> f64) -> f64 {
    let value = part.margin.evaluate(values);
    match part.dimension {
        None => Degree::constant(value != 0.0, 0).robustness,
        Some(_) if value == 0.0 => {
            if part.strict {
                -0.0
            } else {
                0.0
            }
        }
        Some(_) if is_scaled => value / part.scale,
        Some(_) => value,
    }
}

/// Replaces each value by the one at the beginning of its bound.
fn shift(values: &mut [Degree], ticks: Ticks, of_nothing: bool) {
    let samples = values.len();
    let from = if ticks.is_empty { samples } else { ticks.from.min(samples) };
    values.copy_within(from.., 0);
    let last = samples.saturating_sub(1) as u32;
    values[samples - from..].fill(Degree::constant(of_nothing, last));
}

/// Whether an operator takes the least or the greatest of its bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Least,
    Greatest,
}

impl Wanted {
    /// Whether a bound without samples is true.
    fn of_nothing(self) -> bool {
        self == Self::Least
    }

    /// The chosen one of two, the first one of equal ones.
    fn of(self, first: Degree, second: Degree) -> Degree {
        match self {
            Self::Least => first.and(second),
            Self::Greatest => first.or(second),
        }
    }

    /// Whether an earlier candidate makes a later one needless.
    fn replaces(self, earlier: &Degree, later: &Degree) -> bool {
        let order = earlier.robustness.total_cmp(&later.robustness);
        if self == Self::Least { order.is_le() } else { order.is_ge() }
    }
}

/// A bound in ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Ticks {
    from: usize,
    /// From its first sample to its last; `None` without an end.
    width: Option<usize>,
    /// Whether no sample lies in it.
    is_empty: bool,
}

impl Ticks {
    /// The ticks of a bound: those whose time lies in it. Rounding of a quotient loses none at its ends.
    fn new(within: &Within, dt: f64) -> Self {
        let (from, to) = super::ticks_within(within, dt);
        let width = to.map(|to| to.saturating_sub(from));
        Self { from, width, is_empty: to.is_some_and(|to| to < from) }
    }
}
