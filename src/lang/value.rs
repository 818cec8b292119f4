//! Checks values against the types of their keys.

mod context;
mod quantity;
mod distribution;
mod number;
mod name;
mod list;
mod requirement;

use super::ast::{Expression, ExpressionKind, Known};
use super::diagnostics;
use super::formula::{ROBUST, Scope, Sort, formula};
use base::diagnostic::Diagnostic;
use base::signature::{Formula, Type, Value};
use base::units::Dimension;
pub(super) use context::Context;
use context::unfit;
pub use distribution::distributions;

/// Checks an expression as a value of this type; `None` after an error has been reported.
pub(super) fn value(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    if matches!(expression.kind, ExpressionKind::Known(Known::Wrong)) {
        return None;
    }
    match ty {
        Type::List(item) => list::list(expression, ty, item, context, diagnostics),
        Type::Quantity { .. } => number::single(expression, ty, context, diagnostics),
        Type::Integer { .. } | Type::Ticks { .. } => number::whole(expression, ty, context, diagnostics),
        Type::Range { .. } => number::range(expression, ty, context, diagnostics),
        Type::Distribution { .. } => number::drawn(expression, ty, context, diagnostics),
        Type::WordOrPoint(words) if matches!(expression.kind, ExpressionKind::Name(_) | ExpressionKind::Text(_)) => {
            name::choice(expression, ty, words, context, diagnostics)
        }
        Type::Point | Type::WordOrPoint(_) | Type::Pose => number::place(expression, ty, context, diagnostics),
        Type::Boolean => match &expression.kind {
            ExpressionKind::Name(word) if word == "true" || word == "false" => Some(Value::Boolean(word == "true")),
            _ => unfit(expression, ty, context, diagnostics),
        },
        Type::Text | Type::Path => match &expression.kind {
            ExpressionKind::Text(text) => Some(Value::Text(text.clone())),
            _ => unfit(expression, ty, context, diagnostics),
        },
        Type::Choice(words) | Type::Step(words) => name::choice(expression, ty, words, context, diagnostics),
        Type::WordOrReference(words, form) => name::word_or_reference(expression, words, form, context, diagnostics),
        Type::Reference(form) => name::reference(expression, form, context, diagnostics),
        Type::Formula(event) => {
            plain_number(expression, &scope_of(event, true, context), diagnostics).map(Value::Formula)
        }
        Type::Requirement(event) => {
            let scope = scope_of(event, true, context);
            requirement::requirement(expression, &scope, context, diagnostics).map(Value::Requirement)
        }
        Type::Condition(event) => {
            let scope = scope_of(event, false, context);
            match formula(expression, &scope, diagnostics)? {
                (formula, Sort::Truth) => Some(Value::Formula(formula)),
                (_, Sort::Quantity(dimension)) => {
                    diagnostics.push(diagnostics::not_a(expression.span, "condition", &dimension.to_string()));
                    None
                }
            }
        }
    }
}

/// The scope of formulas about an event.
fn scope_of<'a>(event: &'a str, whole: bool, context: &Context<'a>) -> Scope<'a> {
    let known = context.vocabulary.events.iter().find(|known| known.name == event);
    let available = known.map_or(&[][..], |event| &event.variables);
    Scope { vocabulary: context.vocabulary, available, event, names: context.names, whole }
}

/// Maximum absolute value of a reward: learners compute in 32 bits, and add up.
const MAX_REWARD: f64 = 1e9;

/// A formula whose value is a plain number, as rewards are.
pub(super) fn plain_number(
    expression: &Expression,
    scope: &Scope,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Formula> {
    match formula(expression, scope, diagnostics)? {
        (formula, Sort::Quantity(Dimension::RATIO)) => {
            let (low, high) = formula.bounds(&|id| {
                let Some(variable) = scope.vocabulary.variable(id) else { return ROBUST };
                // The usual size of a variable (SI); rewards for larger values are rare.
                let limit = if variable.dimension == Dimension::LENGTH { 1e3 } else { 1e2 };
                let (low, high) = variable.bounds;
                (low.max(-limit), high.min(limit))
            });
            if low < -MAX_REWARD || high > MAX_REWARD {
                diagnostics.push(diagnostics::too_much(expression.span, MAX_REWARD));
                return None;
            }
            Some(formula)
        }
        (_, Sort::Quantity(dimension)) => {
            diagnostics.push(diagnostics::uncounted(expression.span, dimension));
            None
        }
        (_, Sort::Truth) => {
            diagnostics.push(diagnostics::not_a(expression.span, "plain number", "condition"));
            None
        }
    }
}
