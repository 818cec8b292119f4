//! Checks values against the types of their keys.

mod number;
mod list;
mod name;
mod distribution;
mod suggested;

use super::ast::{Expression, ExpressionKind, Known};
use super::diagnostics;
use super::formula::{ROBUST, Scope, Sort, formula};
use super::names::Names;
use super::requirement::requirement;
use base::diagnostic::{Diagnostic, Sources};
use base::signature::{Form, Formula, Type, Value, Vocabulary};
use base::units::Dimension;
pub use distribution::distributions;
use suggested::{otherwise, places_with_units};

/// The context of a value.
pub(super) struct Context<'a> {
    pub vocabulary: &'a Vocabulary,
    /// All forms, for suggestions.
    pub forms: &'a [Form],
    pub names: &'a Names<'a>,
    pub sources: &'a Sources,
}

/// Checks an expression as a value of this type; `None` when something was wrong and has been reported.
pub(super) fn value(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    if matches!(expression.kind, ExpressionKind::Known(Known::Wrong)) {
        return None;
    }
    if let Some(meant) = places_with_units(expression, ty, context) {
        diagnostics.push(diagnostics::missing_units(expression.span, meant));
        return None;
    }
    match ty {
        Type::List(item) => list::list(expression, ty, item, context, diagnostics),
        Type::Quantity { .. } => number::single(expression, ty, context, diagnostics),
        Type::Integer { .. } | Type::Ticks { .. } => number::whole(expression, ty, context, diagnostics),
        Type::Range { .. } => number::range(expression, ty, context, diagnostics),
        Type::Distribution { .. } => number::drawn(expression, ty, context, diagnostics),
        Type::Point | Type::Pose => number::place(expression, ty, context, diagnostics),
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
            requirement(expression, &scope, context.sources, diagnostics).map(Value::Requirement)
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

/// Reports an expression of another kind than its type wants, unless it is a parameter that may have been in a statement which could not be read.
fn unfit(expression: &Expression, ty: &Type, context: &Context, diagnostics: &mut Vec<Diagnostic>) -> Option<Value> {
    let lost = |word: &str| context.names.may_be_unread(word, context.names.params());
    if !matches!(&expression.kind, ExpressionKind::Name(word) if lost(word)) {
        diagnostics.push(otherwise(expression, ty, context));
    }
    None
}

/// The scope of formulas about an event.
fn scope_of<'a>(event: &'a str, whole: bool, context: &Context<'a>) -> Scope<'a> {
    let known = context.vocabulary.events.iter().find(|known| known.name == event);
    let available = known.map_or(&[][..], |event| &event.variables);
    Scope { vocabulary: context.vocabulary, available, event, names: context.names, whole }
}

/// The greatest absolute value of a reward: learners compute in 32 bits, and add up.
const MOST_PAID: f64 = 1e9;

/// The usual size of a variable (SI); rewards for larger values are rare.
fn everyday(dimension: Dimension) -> f64 {
    if dimension == Dimension::LENGTH { 1e3 } else { 1e2 }
}

/// A formula whose value is a plain number, as rewards are.
pub(super) fn plain_number(
    expression: &Expression,
    scope: &Scope,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Formula> {
    match formula(expression, scope, diagnostics)? {
        (formula, Sort::Quantity(Dimension::RATIO)) => {
            let (low, high) = formula.bounds(&|id| {
                let Some(variable) = scope.vocabulary.variables.get(id.0) else { return ROBUST };
                let (most, (low, high)) = (everyday(variable.dimension), variable.bounds);
                (low.max(-most), high.min(most))
            });
            if low < -MOST_PAID || high > MOST_PAID {
                diagnostics.push(diagnostics::too_much(expression.span, MOST_PAID));
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
