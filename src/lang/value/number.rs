//! Numbers with their units: single ones, whole ones, ranges, distributions, places.

use std::f64::consts::{PI, TAU};

use super::context::{Context, unfit};
use super::distribution::distribution;
use super::quantity::{ends, is_formula, quantity, within};
use crate::ast::{Expression, ExpressionKind};
use crate::diagnostics;
use base::diagnostic::Diagnostic;
use base::signature::{Distribution, Type, Value, bounds, short};
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
