//! Constant quantities.

use super::context::Context;
use crate::ast::{Expression, ExpressionKind, Known};
use crate::diagnostics;
use crate::formula::{Scope, Sort, formula};
use base::diagnostic::{Diagnostic, Span};
use base::signature::{MAX_MAGNITUDE, MIN_POSITIVE, VariableId, bounds};
use base::units::Dimension;

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
pub(super) fn quantity(
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
