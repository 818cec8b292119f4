use std::sync::Arc;

use super::{Bounds, Formula, VariableId};
use crate::units::Dimension;

/// A checked requirement in temporal logic over the samples of one episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// Its comparisons, in the order in which they are written; a [`Temporal::Part`] is an index into this list.
    pub parts: Vec<Comparison>,
    pub formula: Temporal,
}

/// A comparison of a requirement, or a condition without degree.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Its text in the file.
    pub text: String,
    /// The distance to the side on which it is false (SI): above 0 where it is true, below 0 where it is false. Of a condition without degree 1
    /// or 0 instead.
    pub margin: Formula,
    /// Whether it is false where both sides are equal: `<` and `>`.
    pub strict: bool,
    /// The dimension of both sides; none of a condition without degree, such as `in_sight`.
    pub dimension: Option<Dimension>,
    /// The margin (SI) that counts as 1 where parts of different dimensions meet.
    pub scale: f64,
}

/// The times of a temporal operator after the present sample (s), both included; the end is infinite without a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within {
    pub from: f64,
    pub to: f64,
}

impl Within {
    /// From now to the end of the episode.
    pub const EPISODE: Self = Self { from: 0.0, to: f64::INFINITY };
}

/// A formula of temporal logic.
#[derive(Debug, Clone, PartialEq)]
pub enum Temporal {
    /// `true` or `false`.
    Constant(bool),
    /// A comparison, by its place in [`Requirement::parts`].
    Part(usize),
    Not(Arc<Temporal>),
    And(Arc<Temporal>, Arc<Temporal>),
    Or(Arc<Temporal>, Arc<Temporal>),
    /// True if it is true at all samples of the bound.
    Always(Within, Arc<Temporal>),
    /// True if it is true at one sample of the bound.
    Eventually(Within, Arc<Temporal>),
    /// True if the second is true at one sample of the bound, and the first at all samples before that one.
    Until(Within, Arc<Temporal>, Arc<Temporal>),
}

impl Requirement {
    /// The dimension of its robustness: that of all its comparisons, if they share one. `None` if they differ, or if there are none.
    pub fn dimension(&self) -> Option<Dimension> {
        let mut measured = self.parts.iter().filter_map(|part| part.dimension);
        let first = measured.next()?;
        measured.all(|other| other == first).then_some(first)
    }

    /// Whether its robustness is scaled, since its comparisons have different dimensions.
    pub fn is_scaled(&self) -> bool {
        self.dimension().is_none()
    }

    /// Whether a comparison contains a variable that satisfies a condition.
    pub fn mentions(&self, wanted: &impl Fn(VariableId) -> bool) -> bool {
        self.parts.iter().any(|part| part.margin.mentions(wanted))
    }

    /// Whether it can say something if the values of silent variables say nothing: a part of what must all hold is enough, and of alternatives each must.
    pub fn says_something(&self, is_silent: &impl Fn(VariableId) -> bool) -> bool {
        self.formula.says_something(true, &|part| self.parts[part].margin.mentions(is_silent))
    }

    /// The latest time that a bound of it reaches after the start (s), bounds inside others added up; infinite ends do not count.
    pub fn reach(&self) -> f64 {
        self.formula.reach()
    }
}

impl Temporal {
    /// What must hold for the formula to say anything: what stands before each `implies`, which is its negation or the rest. Empty of a formula that
    /// always says something, as one does that has a part without any. The antecedents of an `implies` within another must hold together with that.
    pub fn conditions(&self) -> Vec<Self> {
        match self {
            Self::Constant(_) | Self::Part(_) => Vec::new(),
            Self::Or(first, second) if let Self::Not(condition) = &**first => match second.conditions() {
                none if none.is_empty() => vec![Self::clone(condition)],
                inner => inner.into_iter().map(|inner| Self::And(condition.clone(), inner.into())).collect(),
            },
            Self::Not(inner) | Self::Always(_, inner) | Self::Eventually(_, inner) => inner.conditions(),
            Self::And(a, b) => match [a.conditions(), b.conditions()] {
                both if both.iter().any(Vec::is_empty) => Vec::new(),
                both => both.concat(),
            },
            Self::Or(a, b) | Self::Until(_, a, b) => [a.conditions(), b.conditions()].concat(),
        }
    }

    /// The same of a formula, or of its negation, by its silent comparisons.
    fn says_something(&self, as_it_is: bool, is_silent: &impl Fn(usize) -> bool) -> bool {
        let [one, all] = [|a: bool, b: bool| a || b, |a: bool, b: bool| a && b];
        let both = |a: &Self, b: &Self, join: fn(bool, bool) -> bool| {
            join(a.says_something(as_it_is, is_silent), b.says_something(as_it_is, is_silent))
        };
        match self {
            Self::Constant(_) => true,
            Self::Part(index) => !is_silent(*index),
            Self::Not(inner) => inner.says_something(!as_it_is, is_silent),
            Self::Always(_, inner) | Self::Eventually(_, inner) => inner.says_something(as_it_is, is_silent),
            Self::And(a, b) => both(a, b, if as_it_is { one } else { all }),
            Self::Or(a, b) | Self::Until(_, a, b) => both(a, b, if as_it_is { all } else { one }),
        }
    }

    fn reach(&self) -> f64 {
        let end = |within: &Within| if within.to.is_finite() { within.to } else { within.from };
        match self {
            Self::Constant(_) | Self::Part(_) => 0.0,
            Self::Not(inner) => inner.reach(),
            Self::And(a, b) | Self::Or(a, b) => a.reach().max(b.reach()),
            Self::Always(within, inner) | Self::Eventually(within, inner) => end(within) + inner.reach(),
            Self::Until(within, a, b) => end(within) + a.reach().max(b.reach()),
        }
    }

    /// Whether it is the same at every sample, for values of the variables within bounds: true, false, or unknown. An operator with a bound
    /// that begins after the present sample may be at the end of the episode, so it is unknown.
    pub fn settled(&self, parts: &[Comparison], values: &impl Fn(VariableId) -> Bounds) -> Option<bool> {
        match self {
            Self::Constant(truth) => Some(*truth),
            Self::Part(index) => parts[*index].settled(values),
            Self::Not(inner) => inner.settled(parts, values).map(|truth| !truth),
            Self::And(a, b) => match (a.settled(parts, values), b.settled(parts, values)) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (Some(true), Some(true)) => Some(true),
                _ => None,
            },
            Self::Or(a, b) => match (a.settled(parts, values), b.settled(parts, values)) {
                (Some(true), _) | (_, Some(true)) => Some(true),
                (Some(false), Some(false)) => Some(false),
                _ => None,
            },
            Self::Always(within, inner) | Self::Eventually(within, inner) => {
                inner.settled(parts, values).filter(|_| within.from == 0.0)
            }
            Self::Until(within, _, second) => second.settled(parts, values).filter(|_| within.from == 0.0),
        }
    }
}

impl Comparison {
    /// Whether it is always true or always false, for values of the variables within bounds.
    pub fn settled(&self, values: &impl Fn(VariableId) -> Bounds) -> Option<bool> {
        let (low, high) = self.margin.bounds(values);
        match (self.dimension, self.strict) {
            (None, _) => (low == high).then_some(low != 0.0),
            (_, true) if low > 0.0 => Some(true),
            (_, true) if high <= 0.0 => Some(false),
            (_, false) if low >= 0.0 => Some(true),
            (_, false) if high < 0.0 => Some(false),
            _ => None,
        }
    }
}
