//! Distributions: constants, ranges, and calls of the functions that make them.

use super::context::{Context, describe};
use super::quantity::{ends, is_formula, quantity, within};
use crate::ast::{Expression, ExpressionKind, Known, Name};
use crate::diagnostics;
use crate::formula::is_function;
use base::diagnostic::Diagnostic;
use base::signature::{Distribution, MAX_MAGNITUDE, MIN_POSITIVE, Type};
use base::units::Dimension;

/// The functions that make distributions, with their arguments.
const DISTRIBUTIONS: &[(&str, &str)] = &[
    ("uniform", "two ends"),
    ("normal", "a mean and a deviation"),
    ("truncated", "a distribution and a range"),
    ("choice", "one distribution or more"),
    ("weighted", "one pair `(weight, distribution)` or more"),
];

/// Maximum number of parts of a distribution. Parameters that name each other may double them again and again.
const MAX_PARTS: usize = 4096;

/// The names of the functions that make distributions.
pub fn distributions() -> impl Iterator<Item = &'static str> {
    DISTRIBUTIONS.iter().map(|(name, _)| *name)
}

/// A value, a range, or a call of one of [`DISTRIBUTIONS`].
pub(super) fn distribution(
    expression: &Expression,
    dimension: Dimension,
    context: &Context,
    said: &mut Vec<Diagnostic>,
) -> Option<Distribution> {
    let span = expression.span;
    match &expression.kind {
        ExpressionKind::Range(low, high) => {
            let (a, b) = ends(span, low, high, dimension, context, said)?;
            Some(Distribution::Uniform(a, b))
        }
        ExpressionKind::Known(Known::Distribution(known, found)) => {
            if *found != dimension {
                said.push(diagnostics::wrong_unit(span, dimension, *found));
                return None;
            }
            Some(known.clone())
        }
        ExpressionKind::Call { function, arguments, .. } if !is_function(&function.text) => {
            called(function, arguments, expression, dimension, context, said)
        }
        _ if is_formula(expression) => quantity(expression, dimension, context, said).map(Distribution::Constant),
        _ => {
            let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
            said.push(diagnostics::wrong_type(
                span,
                &Type::Distribution { dimension, min, max },
                &describe(expression),
            ));
            None
        }
    }
}

/// A call of one of [`DISTRIBUTIONS`].
fn called(
    function: &Name,
    arguments: &[Expression],
    whole: &Expression,
    dimension: Dimension,
    context: &Context,
    said: &mut Vec<Diagnostic>,
) -> Option<Distribution> {
    let Some((name, takes)) = DISTRIBUTIONS.iter().find(|(name, _)| *name == function.text) else {
        let known: Vec<&str> = DISTRIBUTIONS.iter().map(|(name, _)| *name).collect();
        said.push(diagnostics::unknown_distribution(function.span, &function.text, &known));
        return None;
    };
    if parts_of(whole) > MAX_PARTS {
        said.push(diagnostics::too_many_parts(whole.span, MAX_PARTS));
        return None;
    }
    match (*name, arguments) {
        ("uniform", [low, high]) => {
            let (a, b) = ends(whole.span, low, high, dimension, context, said)?;
            Some(Distribution::Uniform(a, b))
        }
        ("normal", [mean, deviation]) => {
            let middle = quantity(mean, dimension, context, said);
            let spread = quantity(deviation, dimension, context, said);
            let (mean, spread) = (middle?, spread?);
            within(spread, MIN_POSITIVE, MAX_MAGNITUDE, dimension, deviation.span, context, said)?;
            let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
            Some(Distribution::Normal { mean, deviation: spread, low, high })
        }
        ("truncated", [inner, range]) => {
            let untruncated = distribution(inner, dimension, context, said);
            let ExpressionKind::Range(low, high) = &range.kind else {
                said.push(diagnostics::not_a(range.span, "range", &describe(range)));
                return None;
            };
            let (a, b) = ends(range.span, low, high, dimension, context, said)?;
            let kept = untruncated?.truncated(a, b);
            if kept.is_none() {
                said.push(diagnostics::nothing_left(whole.span, inner.span, range.span));
            }
            kept
        }
        ("choice" | "weighted", [_, ..]) => {
            let part = |part: &Expression| match *name {
                "choice" => distribution(part, dimension, context, said).map(|part| (1.0, part)),
                _ => weighted(part, dimension, context, said),
            };
            let parts = arguments.iter().map(part).collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>()?;
            Some(Distribution::mixture(parts))
        }
        _ => {
            said.push(diagnostics::wrong_arity(whole.span, name, takes, arguments.len()));
            None
        }
    }
}

/// The number of parts of a distribution, counted up to a little more than [`MAX_PARTS`].
fn parts_of(expression: &Expression) -> usize {
    match &expression.kind {
        ExpressionKind::Known(Known::Distribution(known, _)) => known.leaves(),
        // `(weight, distribution)`
        ExpressionKind::Group(members) => members.last().map_or(0, parts_of),
        ExpressionKind::Call { arguments: members, .. } => {
            let add = |sum: usize, member: &Expression| if sum > MAX_PARTS { sum } else { sum + parts_of(member) };
            members.iter().fold(0, add)
        }
        _ => 1,
    }
}

/// `(weight, distribution)`
fn weighted(
    pair: &Expression,
    dimension: Dimension,
    context: &Context,
    said: &mut Vec<Diagnostic>,
) -> Option<(f64, Distribution)> {
    let members = if let ExpressionKind::Group(members) = &pair.kind { members.as_slice() } else { &[] };
    let [weight, part] = members else {
        said.push(diagnostics::not_a(pair.span, "pair `(weight, distribution)`", &describe(pair)));
        return None;
    };
    let number = quantity(weight, Dimension::RATIO, context, said);
    let part = distribution(part, dimension, context, said);
    let number = number?;
    within(number, MIN_POSITIVE, MAX_MAGNITUDE, Dimension::RATIO, weight.span, context, said)?;
    Some((number, part?))
}
