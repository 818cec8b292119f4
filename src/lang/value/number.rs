//! Numbers with their units: single ones, whole ones, ranges, distributions, places.

use std::f64::consts::{PI, TAU};

use super::distribution::distribution;
use super::{Context, unfit};
use crate::ast::{Expression, ExpressionKind, Known};
use crate::diagnostics;
use crate::formula::{Scope, Sort, formula};
use base::diagnostic::{Diagnostic, Span};
use base::signature::{Distribution, MAX_MAGNITUDE, MIN_POSITIVE, Type, Value, VariableId, bounds, short};
use base::units::Dimension;

/// A constant quantity.
pub(super) fn single(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let Type::Quantity { dimension, min, max } = *ty else { return None };
    if !is_formula(expression) {
        return unfit(expression, ty, context, diagnostics);
    }
    let number = quantity(expression, dimension, context, diagnostics)?;
    within(number, min, max, dimension, expression.span, context, diagnostics)?;
    Some(Value::Number(number))
}

pub(super) fn whole(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let (Type::Integer { min, max } | Type::Ticks { min, max }) = *ty else { return None };
    if !is_formula(expression) {
        return unfit(expression, ty, context, diagnostics);
    }
    let span = expression.span;
    let number = quantity(expression, Dimension::RATIO, context, diagnostics)?;
    let written = context.sources.text(span);
    let is_literal = matches!(expression.kind, ExpressionKind::Number { .. });
    let whole = number as i64;
    if number.fract() != 0.0 || is_literal && written.contains('.') {
        diagnostics.push(diagnostics::not_whole(span, written));
    } else if number.abs() > 9e15 || whole < min || whole > max {
        let bounds = if max == i64::MAX { format!("{min} or more") } else { format!("{min} to {max}") };
        diagnostics.push(diagnostics::out_of_range(span, short(number), bounds));
    } else {
        return Some(Value::Integer(whole));
    }
    None
}

/// Both ends of a range.
pub(super) fn range(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let Type::Range { dimension, min, max } = *ty else { return None };
    let ExpressionKind::Range(low, high) = &expression.kind else {
        return unfit(expression, ty, context, diagnostics);
    };
    let (a, b) = ends(expression.span, low, high, dimension, context, diagnostics)?;
    within(a, min, max, dimension, low.span, context, diagnostics)?;
    within(b, min, max, dimension, high.span, context, diagnostics)?;
    Some(Value::Range(a, b))
}

/// A distribution whose support is within the bounds.
pub(super) fn drawn(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let Type::Distribution { dimension, min, max } = *ty else { return None };
    let span = expression.span;
    let is_list = matches!(expression.kind, ExpressionKind::List(_) | ExpressionKind::Group(_));
    if is_list && !is_formula(expression) || matches!(expression.kind, ExpressionKind::Text(_)) {
        return unfit(expression, ty, context, diagnostics);
    }
    let is_circle = dimension == Dimension::ANGLE && (min, max) == (-PI, PI);
    if let (true, ExpressionKind::Range(low, high)) = (is_circle, &expression.kind) {
        let (a, b) = (quantity(low, dimension, context, diagnostics), quantity(high, dimension, context, diagnostics));
        let (a, b) = (a?, b?);
        // It goes across 180 degrees, the shorter way.
        let mut parts = vec![(PI - a, Distribution::Uniform(a, PI)), (b + PI, Distribution::Uniform(-PI, b))];
        parts.retain(|(width, _)| *width > 0.0);
        if (PI..TAU).contains(&(a - b)) && a <= PI && b >= -PI {
            return Some(Value::Distribution(Distribution::mixture(parts)));
        }
    }
    let drawn = distribution(expression, dimension, context, diagnostics)?;
    let (low, high) = drawn.support();
    if low == f64::NEG_INFINITY && min > low || high == f64::INFINITY && max < high {
        let allowed = bounds(min, max, dimension);
        diagnostics.push(diagnostics::unbounded(span, context.sources.text(span), &allowed));
        return None;
    }
    if is_circle && (low < -PI || high > PI) {
        let allowed = bounds(min, max, dimension);
        let mut beyond = diagnostics::out_of_range(span, context.sources.text(span).to_string(), allowed);
        if let (ExpressionKind::Range(..), Some(fitting)) = (&expression.kind, around(low, high)) {
            beyond = beyond.fix(fitting);
        }
        diagnostics.push(beyond);
        return None;
    }
    within(low, min, max, dimension, span, context, diagnostics)?;
    within(high, min, max, dimension, span, context, diagnostics)?;
    Some(Value::Distribution(drawn))
}

/// The directions of a range of angles (rad), written with numbers from -180 to 180 degrees: across 180 degrees the first is the greater one. `None` for
/// more than a half turn and less than a whole one.
fn around(low: f64, high: f64) -> Option<String> {
    let degrees = |angle: f64| short(((PI - (PI - angle).rem_euclid(TAU)).to_degrees() * 1e6).round() / 1e6);
    match high - low {
        width if width >= TAU - 1e-9 => Some("-180 deg .. 180 deg".into()),
        width if width <= PI => Some(format!("{} deg .. {} deg", degrees(low), degrees(high))),
        _ => None,
    }
}

/// A point, or a pose: a point and a heading.
pub(super) fn place(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let ExpressionKind::Group(parts) = &expression.kind else {
        return unfit(expression, ty, context, diagnostics);
    };
    let is_pose = matches!(ty, Type::Pose);
    if parts.len() != if is_pose { 3 } else { 2 } {
        return unfit(expression, ty, context, diagnostics);
    }
    let dimensions = [Dimension::LENGTH, Dimension::LENGTH, Dimension::ANGLE];
    let numbers = parts.iter().zip(dimensions).map(|(part, dimension)| quantity(part, dimension, context, diagnostics));
    let numbers: Vec<Option<f64>> = numbers.collect();
    match *numbers.into_iter().collect::<Option<Vec<f64>>>()? {
        [x, y] => Some(Value::Point(x, y)),
        [x, y, heading] => Some(Value::Pose(x, y, heading)),
        _ => None,
    }
}

/// Both ends of a range, in order.
pub(super) fn ends(
    span: Span,
    low: &Expression,
    high: &Expression,
    dimension: Dimension,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<(f64, f64)> {
    let (a, b) = (quantity(low, dimension, context, diagnostics), quantity(high, dimension, context, diagnostics));
    let (a, b) = (a?, b?);
    if a > b {
        diagnostics.push(diagnostics::empty_range(span));
        return None;
    }
    Some((a, b))
}

/// Whether an expression can be a constant quantity; words and texts get a better message from their type.
pub(super) fn is_formula(expression: &Expression) -> bool {
    match &expression.kind {
        ExpressionKind::Group(members) => members.len() == 1,
        ExpressionKind::Text(_)
        | ExpressionKind::Range(..)
        | ExpressionKind::List(_)
        | ExpressionKind::Name(_)
        | ExpressionKind::Known(Known::Declaration(..) | Known::Distribution(..)) => false,
        _ => true,
    }
}

/// A constant number of this dimension (SI).
pub(crate) fn quantity(
    expression: &Expression,
    dimension: Dimension,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<f64> {
    let Context { vocabulary, names, .. } = *context;
    let scope = Scope { vocabulary, available: &[], event: "compile time", names, whole: false };
    let (formula, sort) = formula(expression, &scope, diagnostics)?;
    match sort {
        Sort::Truth => {
            diagnostics.push(diagnostics::not_a(expression.span, &dimension.to_string(), "condition"));
            None
        }
        Sort::Quantity(found) if found == dimension => {
            let number = formula.evaluate(&|_: VariableId| unreachable!("no variable is in scope"));
            if number.is_finite() {
                return Some(number);
            }
            diagnostics.push(diagnostics::out_of_range(expression.span, number.to_string(), "a finite number".into()));
            None
        }
        Sort::Quantity(Dimension::RATIO) => {
            let written = context.sources.text(expression.span);
            diagnostics.push(diagnostics::missing_unit(expression.span, dimension, written));
            None
        }
        Sort::Quantity(found) => {
            let bare = matches!(expression.kind, ExpressionKind::Number { .. });
            diagnostics.push(match dimension {
                Dimension::RATIO if !bare => diagnostics::uncounted(expression.span, found),
                _ => diagnostics::wrong_unit(expression.span, dimension, found),
            });
            None
        }
    }
}

/// Reports a number outside of its bounds.
pub(super) fn within(
    number: f64,
    min: f64,
    max: f64,
    dimension: Dimension,
    span: Span,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<()> {
    if number >= min && number <= max {
        return Some(());
    }
    let written = context.sources.text(span).to_string();
    // The bound applies even if it is not shown.
    let allowed = match number {
        _ if min == MIN_POSITIVE && 0.0 < number && number < MIN_POSITIVE => format!("{MIN_POSITIVE:e} or more, in SI"),
        _ if max == MAX_MAGNITUDE && number > MAX_MAGNITUDE => format!("{MAX_MAGNITUDE:e} or less, in SI"),
        _ => bounds(min, max, dimension),
    };
    diagnostics.push(diagnostics::out_of_range(span, written, allowed));
    None
}
