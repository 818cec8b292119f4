//! Checks values against the types of their keys.

mod distribution;
mod suggested;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::ast::{Expression, ExpressionKind, Known};
use super::diagnostics;
use super::formula::{ROBUST, Scope, Sort, formula};
use super::library;
use super::names::Names;
use super::requirement::requirement;
use base::diagnostic::{Diagnostic, Sources, Span};
use base::signature::{Form, Formula, LEAST, MOST, Type, Value, VariableId, Vocabulary, bounds, short};
use base::units::Dimension;
use distribution::distribution;
pub use distribution::distributions;
use suggested::{as_allowed, as_beside, as_difference, as_meant, otherwise, places_with_units, round_the_back};

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
    let span = expression.span;
    let wrong = |diagnostics: &mut Vec<Diagnostic>| {
        // The parameter may have been in a statement that could not be read.
        let lost = |word: &str| context.names.may_be_unread(word, context.names.params());
        if !matches!(&expression.kind, ExpressionKind::Name(word) if lost(word)) {
            diagnostics.push(otherwise(expression, ty, context));
        }
        None
    };
    match (ty, &expression.kind) {
        (_, ExpressionKind::Known(Known::Wrong)) => None,
        _ if let Some(meant) = places_with_units(expression, ty, context) => {
            diagnostics.push(diagnostics::missing_units(span, meant));
            None
        }
        (Type::List(item), ExpressionKind::List(members)) => {
            if members.is_empty() {
                diagnostics.push(diagnostics::empty_list(span));
                return None;
            }
            let values: Vec<Option<Value>> =
                members.iter().map(|member| value(member, item, context, diagnostics)).collect();
            let values: Vec<Value> = values.into_iter().collect::<Option<_>>()?;
            if matches!(**item, Type::Reference(_) | Type::Choice(_) | Type::WordOrReference(..)) {
                let mut seen = BTreeMap::new();
                for (member, value) in members.iter().zip(&values) {
                    let named = match value {
                        Value::Reference(id) => (id.0, ""),
                        Value::Choice(word) => (usize::MAX, *word),
                        _ => continue,
                    };
                    if let Some(first) = seen.insert(named, member.span) {
                        let written = context.sources.text(member.span);
                        diagnostics.push(diagnostics::repeated_member(member.span, written, first));
                        return None;
                    }
                }
            }
            Some(Value::List(values))
        }
        (Type::List(item), ExpressionKind::Group(members))
            if members.len() > 1 && !matches!(**item, Type::Point | Type::Pose) =>
        {
            wrong(diagnostics)
        }
        (Type::List(item), _) => value(expression, item, context, diagnostics).map(|one| Value::List(vec![one])),
        (Type::Range { dimension, min, max }, ExpressionKind::Range(low, high)) => {
            let before = diagnostics.len();
            let ends = ends(span, low, high, *dimension, context, diagnostics);
            as_allowed(&mut diagnostics[before..], expression, *dimension, (*min, *max));
            let (a, b) = ends?;
            within(a, *min, *max, *dimension, low.span, context, diagnostics)?;
            within(b, *min, *max, *dimension, high.span, context, diagnostics)?;
            Some(Value::Range(a, b))
        }
        (Type::Distribution { .. }, ExpressionKind::List(_) | ExpressionKind::Group(_)) if !is_formula(expression) => {
            wrong(diagnostics)
        }
        (Type::Distribution { .. }, ExpressionKind::Text(_)) => wrong(diagnostics),
        (Type::Distribution { dimension, min, max }, _) => {
            let before = diagnostics.len();
            let drawn = distribution(expression, *dimension, context, diagnostics);
            as_allowed(&mut diagnostics[before..], expression, *dimension, (*min, *max));
            let drawn = drawn?;
            let (low, high) = drawn.support();
            let unbounded = low == f64::NEG_INFINITY && *min > low || high == f64::INFINITY && *max < high;
            if unbounded {
                let allowed = bounds(*min, *max, *dimension);
                diagnostics.push(diagnostics::unbounded(span, context.sources.text(span), &allowed));
                return None;
            }
            let before = diagnostics.len();
            let inside = within(low, *min, *max, *dimension, span, context, diagnostics)
                .and_then(|()| within(high, *min, *max, *dimension, span, context, diagnostics));
            if inside.is_none()
                && let Some(meant) = as_meant(expression, &drawn, ty, context)
            {
                let said = diagnostics.split_off(before);
                diagnostics.extend(said.into_iter().map(|said| said.fix(meant.clone())));
            }
            if inside.is_some() {
                diagnostics.extend(as_difference(expression, &drawn, context));
            }
            inside.map(|()| Value::Distribution(drawn))
        }
        (Type::Quantity { dimension, min, max }, _) if is_formula(expression) => {
            let before = diagnostics.len();
            let number = quantity(expression, *dimension, context, diagnostics);
            as_allowed(&mut diagnostics[before..], expression, *dimension, (*min, *max));
            let number = number?;
            within(number, *min, *max, *dimension, span, context, diagnostics)?;
            Some(Value::Number(number))
        }
        (Type::Integer { min, max } | Type::Ticks { min, max }, _) if is_formula(expression) => {
            let number = quantity(expression, Dimension::RATIO, context, diagnostics)?;
            let written = context.sources.text(span);
            if number.fract() == 0.0
                && written.contains('.')
                && matches!(expression.kind, ExpressionKind::Number { .. })
            {
                diagnostics.push(diagnostics::pointed(span, written));
                return None;
            }
            if number.fract() != 0.0 {
                diagnostics.push(diagnostics::not_whole(span, number));
                return None;
            }
            let whole = number as i64;
            if number.abs() > 9e15 || whole < *min || whole > *max {
                let bounds = if *max == i64::MAX { format!("{min} or more") } else { format!("{min} to {max}") };
                diagnostics.push(diagnostics::out_of_range(span, short(number), bounds));
                return None;
            }
            Some(Value::Integer(whole))
        }
        (Type::Boolean, ExpressionKind::Name(word)) if word == "true" || word == "false" => {
            Some(Value::Boolean(word == "true"))
        }
        (Type::Choice(words) | Type::Step(words), ExpressionKind::Name(word) | ExpressionKind::Text(word)) => {
            match words.iter().find(|known| *known == word) {
                Some(known) => Some(Value::Choice(known)),
                None => {
                    diagnostics.push(diagnostics::unknown_choice(span, word, words));
                    None
                }
            }
        }
        (Type::WordOrReference(words, form), kind) => {
            let word = match kind {
                ExpressionKind::Name(word) | ExpressionKind::Text(word) => words.iter().find(|known| *known == word),
                _ => None,
            };
            match (word, kind) {
                (Some(known), _) => Some(Value::Choice(known)),
                // With no declaration at hand, a wrong word is a typo of one of the words.
                (None, ExpressionKind::Name(word) | ExpressionKind::Text(word))
                    if context.names.of_form(form).next().is_none()
                        && context.names.other_form(context.forms, word).is_none() =>
                {
                    diagnostics.push(diagnostics::unknown_choice(span, word, words));
                    None
                }
                _ => value(expression, &Type::Reference(form), context, diagnostics),
            }
        }
        (Type::Text | Type::Path, ExpressionKind::Text(text)) => Some(Value::Text(text.clone())),
        (Type::Reference(form), ExpressionKind::Name(word)) => match context.names.find(form, word) {
            Some(id) => Some(Value::Reference(id)),
            None if context.names.may_be_unread(word, context.names.of_form(form))
                || context.names.has_form_beside(context.forms, word) =>
            {
                None
            }
            None if let Some(file) = library::home(form, word) => {
                let added = context.names.another_import(word, file, context.sources);
                diagnostics.push(diagnostics::not_imported(span, form, word, file, added));
                None
            }
            None => {
                let mut kinds = context.forms.iter().filter(|each| each.name == *form).flat_map(|each| &each.kinds);
                let other = context.names.other_form(context.forms, word);
                diagnostics.push(match (kinds.any(|kind| kind.name == word), other) {
                    (true, _) => diagnostics::kind_for_name(span, form, word),
                    (false, Some(other)) => {
                        diagnostics::other_form(span, form, word, other, context.names.of_form(form))
                    }
                    (false, None) => diagnostics::unknown_name(span, form, word, context.names.of_form(form)),
                });
                None
            }
        },
        (Type::Reference(form), ExpressionKind::Inline { form: known, place }) if form == known => {
            Some(Value::Reference(context.names.own(*place)))
        }
        (Type::Reference(form), ExpressionKind::Call { function, .. }) if has_kind(form, &function.text, context) => {
            diagnostics.push(diagnostics::kind_in_place(span, form, context.sources.text(span)));
            None
        }
        (Type::Reference(form), ExpressionKind::List(members)) => {
            let written: Vec<&str> = members.iter().map(|member| context.sources.text(member.span)).collect();
            diagnostics.push(diagnostics::several_for_one(span, form, &written));
            None
        }
        (Type::Pose, ExpressionKind::Group(parts)) if parts.len() == 2 => {
            let written: Vec<&str> = parts.iter().map(|part| context.sources.text(part.span)).collect();
            diagnostics.push(diagnostics::missing_heading(span, &written));
            None
        }
        (Type::Reference(form), ExpressionKind::Known(Known::Declaration(known, id))) if form == known => {
            Some(Value::Reference(*id))
        }
        (Type::Point, ExpressionKind::Group(parts)) if parts.len() == 2 => {
            let numbers = parts.iter().map(|part| quantity(part, Dimension::LENGTH, context, diagnostics));
            let numbers: Vec<Option<f64>> = numbers.collect();
            Some(Value::Point(numbers[0]?, numbers[1]?))
        }
        (Type::Pose, ExpressionKind::Group(parts)) if parts.len() == 3 => {
            let dimensions = [Dimension::LENGTH, Dimension::LENGTH, Dimension::ANGLE];
            let numbers = parts.iter().zip(dimensions).map(|(part, d)| quantity(part, d, context, diagnostics));
            let numbers: Vec<Option<f64>> = numbers.collect();
            Some(Value::Pose(numbers[0]?, numbers[1]?, numbers[2]?))
        }
        (Type::Formula(event), _) => {
            plain_number(expression, &scope_of(event, true, context), diagnostics).map(Value::Formula)
        }
        (Type::Requirement(event), _) => {
            let scope = scope_of(event, true, context);
            requirement(expression, &scope, context.sources, diagnostics).map(Value::Requirement)
        }
        (Type::Condition(event), _) => {
            let scope = scope_of(event, false, context);
            match formula(expression, &scope, diagnostics)? {
                (formula, Sort::Truth) => Some(Value::Formula(formula)),
                (_, Sort::Quantity(dimension)) => {
                    diagnostics.push(diagnostics::not_a(span, "condition", &dimension.to_string()));
                    None
                }
            }
        }
        _ => wrong(diagnostics),
    }
}

/// Whether a form has a kind of this name.
fn has_kind(form: &str, word: &str, context: &Context<'_>) -> bool {
    let mut kinds = context.forms.iter().filter(|each| each.name == form).flat_map(|each| &each.kinds);
    kinds.any(|kind| kind.name == word)
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

/// Both ends of a range, in order.
fn ends(
    span: Span,
    low: &Expression,
    high: &Expression,
    dimension: Dimension,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<(f64, f64)> {
    let bare = |end: &Expression| matches!(end.kind, ExpressionKind::Number { unit: None, .. });
    if bare(low) && bare(high) && dimension != Dimension::RATIO {
        let written = context.sources.text(low.span.to(high.span));
        let (a, b) = (context.sources.text(low.span), context.sources.text(high.span));
        diagnostics.push(diagnostics::missing_unit_of_both(low.span.to(high.span), dimension, written, (a, b)));
        return None;
    }
    let before = diagnostics.len();
    let (a, b) = (quantity(low, dimension, context, diagnostics), quantity(high, dimension, context, diagnostics));
    as_beside(&mut diagnostics[before..], low, high, dimension, context);
    as_beside(&mut diagnostics[before..], high, low, dimension, context);
    let (a, b) = (a?, b?);
    if a > b {
        let swapped = format!("{} .. {}", context.sources.text(high.span), context.sources.text(low.span));
        let behind = dimension == Dimension::ANGLE && a > 0.0 && b < 0.0;
        diagnostics.push(diagnostics::empty_range(span, swapped, behind.then(|| round_the_back(a, b + TAU))));
        return None;
    }
    Some((a, b))
}

/// Whether an expression can be a constant quantity; words and texts get a better message from their type.
fn is_formula(expression: &Expression) -> bool {
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

fn quantity(
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
            let number = formula.evaluate(&|_: VariableId| unreachable!("no variable is in scope"));
            diagnostics.push(match (dimension, found) {
                (Dimension::RATIO, _) if !bare => diagnostics::uncounted(expression.span, found),
                (Dimension::TIME, Dimension::FREQUENCY) if bare && number > 0.0 => {
                    diagnostics::wrong_unit(expression.span, dimension, found).fix(format!("{} s", short(1.0 / number)))
                }
                _ => diagnostics::wrong_unit(expression.span, dimension, found),
            });
            None
        }
    }
}

fn within(
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
        _ if min == LEAST && 0.0 < number && number < LEAST => format!("{LEAST:e} or more, in SI"),
        _ if max == MOST && number > MOST => format!("{MOST:e} or less, in SI"),
        _ => bounds(min, max, dimension),
    };
    diagnostics.push(diagnostics::out_of_range(span, written, allowed));
    None
}
