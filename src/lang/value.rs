//! Checks values against the types of their keys.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::ast::{Expression, ExpressionKind, Known, Operator};
use super::codes;
use super::elsewhere::own_word;
use super::formula::{Scope, Sort, formula, is_function};
use super::names::Names;
use super::shelf;
use super::suggest::nearest;
use crate::diagnostic::{Diagnostic, Fix, Sources, Span};
use crate::signature::{Distribution, Form, Formula, LEAST, MOST, Type, Value, VariableId, Vocabulary, bounds, short};
use crate::units::{Dimension, parse_unit};

/// What a value is checked against.
pub(super) struct Context<'a> {
    pub vocabulary: &'a Vocabulary,
    /// The forms that there are, for suggestions.
    pub forms: &'a [Form],
    pub names: &'a Names<'a>,
    pub sources: &'a Sources,
}

/// Checks an expression as a value of this type; `None` when something was wrong and has been said.
pub(super) fn value(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let span = expression.span;
    let wrong = |diagnostics: &mut Vec<Diagnostic>| {
        // What could not be read may have been the parameter.
        let lost = |word: &str| context.names.may_be_unread(word, context.names.params());
        if !matches!(&expression.kind, ExpressionKind::Name(word) if lost(word)) {
            diagnostics.push(otherwise(expression, ty, context));
        }
        None
    };
    match (ty, &expression.kind) {
        (_, ExpressionKind::Known(Known::Wrong)) => None,
        _ if let Some(meant) = places_with_units(expression, ty, context) => {
            diagnostics.push(codes::missing_units(span, meant));
            None
        }
        (Type::List(item), ExpressionKind::List(members)) => {
            if members.is_empty() {
                diagnostics.push(codes::empty_list(span));
                return None;
            }
            let values: Vec<Option<Value>> =
                members.iter().map(|member| value(member, item, context, diagnostics)).collect();
            let values: Vec<Value> = values.into_iter().collect::<Option<_>>()?;
            if matches!(**item, Type::Reference(_) | Type::Choice(_)) {
                let mut seen = BTreeMap::new();
                for (member, value) in members.iter().zip(&values) {
                    let named = match value {
                        Value::Reference(id) => (id.0, ""),
                        Value::Choice(word) => (0, *word),
                        _ => continue,
                    };
                    if let Some(first) = seen.insert(named, member.span) {
                        let written = context.sources.text(member.span);
                        diagnostics.push(codes::repeated_member(member.span, written, first));
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
        (Type::Distribution { dimension, min, max }, _) => {
            let before = diagnostics.len();
            let drawn = distribution(expression, *dimension, context, diagnostics);
            as_allowed(&mut diagnostics[before..], expression, *dimension, (*min, *max));
            let drawn = drawn?;
            let (low, high) = drawn.support();
            let unbounded = low == f64::NEG_INFINITY && *min > low || high == f64::INFINITY && *max < high;
            if unbounded {
                let allowed = bounds(*min, *max, *dimension);
                diagnostics.push(codes::unbounded(span, context.sources.text(span), &allowed));
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
        (Type::Integer { min, max }, _) if is_formula(expression) => {
            let number = quantity(expression, Dimension::RATIO, context, diagnostics)?;
            let written = context.sources.text(span);
            if number.fract() == 0.0
                && written.contains('.')
                && matches!(expression.kind, ExpressionKind::Number { .. })
            {
                diagnostics.push(codes::pointed(span, written));
                return None;
            }
            if number.fract() != 0.0 || number.abs() > 9e15 {
                diagnostics.push(codes::not_whole(span, number));
                return None;
            }
            let number = number as i64;
            if number < *min || number > *max {
                let bounds = if *max == i64::MAX { format!("{min} or more") } else { format!("{min} to {max}") };
                diagnostics.push(codes::out_of_range(span, number.to_string(), bounds));
                return None;
            }
            Some(Value::Integer(number))
        }
        (Type::Boolean, ExpressionKind::Name(word)) if word == "true" || word == "false" => {
            Some(Value::Boolean(word == "true"))
        }
        (Type::Choice(words), ExpressionKind::Name(word) | ExpressionKind::Text(word)) => {
            match words.iter().find(|known| *known == word) {
                Some(known) => Some(Value::Choice(known)),
                None => {
                    diagnostics.push(codes::unknown_choice(span, word, words));
                    None
                }
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
            None if let Some(file) = shelf::home(form, word) => {
                let added = context.names.another_import(word, file, context.sources);
                diagnostics.push(codes::not_imported(span, form, word, file, added));
                None
            }
            None => {
                let mut kinds = context.forms.iter().filter(|each| each.name == *form).flat_map(|each| &each.kinds);
                let other = context.names.other_form(context.forms, word);
                diagnostics.push(match (kinds.any(|kind| kind.name == word), other) {
                    (true, _) => codes::kind_for_name(span, form, word),
                    (false, Some(other)) => codes::other_form(span, form, word, other, context.names.of_form(form)),
                    (false, None) => codes::unknown_name(span, form, word, context.names.of_form(form)),
                });
                None
            }
        },
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
        (Type::Condition(event), _) => {
            let scope = scope_of(event, false, context);
            match formula(expression, &scope, diagnostics)? {
                (formula, Sort::Truth) => Some(Value::Formula(formula)),
                (_, Sort::Quantity(dimension)) => {
                    diagnostics.push(codes::not_a(span, "condition", &dimension.to_string()));
                    None
                }
            }
        }
        _ => wrong(diagnostics),
    }
}

/// The scope of formulas about an event.
fn scope_of<'a>(event: &'a str, whole: bool, context: &Context<'a>) -> Scope<'a> {
    let known = context.vocabulary.events.iter().find(|known| known.name == event);
    let available = known.map_or(&[][..], |event| event.variables);
    Scope { vocabulary: context.vocabulary, available, event, names: context.names, whole }
}

/// The most that a reward may be, or minus that: learners count in 32 bits, and add up.
const MOST_PAID: f64 = 1e9;

/// How large a variable is on ordinary days (SI): what is paid beyond that hardly ever is.
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
                let variable = &scope.vocabulary.variables[id.0];
                let (most, (low, high)) = (everyday(variable.dimension), variable.bounds);
                (low.max(-most), high.min(most))
            });
            if low < -MOST_PAID || high > MOST_PAID {
                diagnostics.push(codes::too_much(expression.span, MOST_PAID));
                return None;
            }
            Some(formula)
        }
        (_, Sort::Quantity(dimension)) => {
            diagnostics.push(codes::uncounted(expression.span, dimension));
            None
        }
        (_, Sort::Truth) => {
            diagnostics.push(codes::not_a(expression.span, "plain number", "condition"));
            None
        }
    }
}

/// A place, or several, with the units that all of its numbers lack.
fn places_with_units(expression: &Expression, ty: &Type, context: &Context) -> Option<String> {
    let number = |part: &Expression, unit: &str| match &part.kind {
        ExpressionKind::Number { unit: None, .. } => Some(format!("{} {unit}", context.sources.text(part.span))),
        _ => None,
    };
    match (ty, &expression.kind) {
        (Type::Point | Type::Pose, ExpressionKind::Group(parts)) => {
            let units: &[&str] = if *ty == Type::Point { &["m", "m"] } else { &["m", "m", "deg"] };
            let numbers = parts.iter().zip(units).map(|(part, unit)| number(part, unit)).collect::<Option<Vec<_>>>()?;
            (parts.len() == units.len()).then(|| format!("({})", numbers.join(", ")))
        }
        (Type::List(place), ExpressionKind::List(members)) if matches!(**place, Type::Point | Type::Pose) => {
            let places = members.iter().map(|member| places_with_units(member, place, context));
            let places = places.collect::<Option<Vec<_>>>()?;
            (!places.is_empty()).then(|| format!("[{}]", places.join(", ")))
        }
        _ => None,
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
        diagnostics.push(codes::missing_unit_of_both(low.span.to(high.span), dimension, written, (a, b)));
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
        diagnostics.push(codes::empty_range(span, swapped, behind.then(|| round_the_back(a, b + TAU))));
        return None;
    }
    Some((a, b))
}

/// What was probably meant by a distribution beyond the bounds of its key.
fn as_meant(expression: &Expression, drawn: &Distribution, ty: &Type, context: &Context) -> Option<String> {
    let text = |span: Span| context.sources.text(span);
    let (low, high) = drawn.support();
    let Type::Distribution { dimension, min, max } = ty else { return None };
    if *dimension == Dimension::ANGLE {
        // More than a turn in radians was meant in degrees.
        let written = text(expression.span);
        if high.max(-low) > TAU && written.contains("rad") {
            return Some(written.replace("rad", "deg"));
        }
        let all_round = *min == -PI && *max == PI && high - low <= TAU;
        let even = matches!(drawn, Distribution::Uniform(..) | Distribution::Constant(_));
        return (all_round && even).then(|| round_the_back(low, high));
    }
    match &expression.kind {
        ExpressionKind::Binary { operator: Operator::Subtract, left, right } => {
            Some(format!("{} .. {}", text(left.span), text(right.span)))
        }
        _ => None,
    }
}

/// The directions from one to another (rad) that lies to the left of it by a turn at most, or the one if they are the same, as they
/// are written between -180° and 180°.
fn round_the_back(from: f64, to: f64) -> String {
    let (from, width) = (from.to_degrees(), (to - from).to_degrees());
    let shown = |degrees: f64| format!("{} deg", short(degrees));
    let start = from - 360.0 * ((from + 180.0) / 360.0 + 1e-12).floor();
    let end = start + width;
    if width > 360.0 - 1e-9 {
        return "-180 deg .. 180 deg".into();
    }
    if width == 0.0 {
        return shown(start);
    }
    if end <= 180.0 + 1e-9 {
        return format!("{} .. {}", shown(start), shown(end));
    }
    let sides = [
        (180.0 - start, format!("{} .. 180 deg", shown(start))),
        (end - 180.0, format!("-180 deg .. {}", shown(end - 360.0))),
    ];
    match sides {
        [(left, one), (right, other)] if (left - right).abs() < 1e-9 => format!("choice({one}, {other})"),
        [(left, one), (right, other)] => format!("weighted(({}, {one}), ({}, {other}))", short(left), short(right)),
    }
}

/// The functions that make distributions, with what they take.
const DISTRIBUTIONS: &[(&str, &str)] = &[
    ("uniform", "two ends"),
    ("normal", "a mean and a deviation"),
    ("truncated", "a distribution and a range"),
    ("choice", "one distribution or more"),
    ("weighted", "one pair `(weight, distribution)` or more"),
];

/// The names of the functions that make distributions.
pub fn distributions() -> impl Iterator<Item = &'static str> {
    DISTRIBUTIONS.iter().map(|(name, _)| *name)
}

/// A value, a range, or a call of one of [`DISTRIBUTIONS`].
fn distribution(
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
                said.push(codes::wrong_unit(span, dimension, *found));
                return None;
            }
            Some(known.clone())
        }
        ExpressionKind::Call { function, arguments } if !is_function(&function.text) => {
            let Some((name, takes)) = DISTRIBUTIONS.iter().find(|(name, _)| *name == function.text) else {
                let known: Vec<&str> = DISTRIBUTIONS.iter().map(|(name, _)| *name).collect();
                said.push(codes::unknown_distribution(function.span, &function.text, &known));
                return None;
            };
            let parts = |said: &mut Vec<Diagnostic>| {
                let each = |part: &Expression| distribution(part, dimension, context, said);
                arguments.iter().map(each).collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>()
            };
            match (*name, arguments.as_slice()) {
                ("uniform", [low, high]) => {
                    let (a, b) = ends(span, low, high, dimension, context, said)?;
                    Some(Distribution::Uniform(a, b))
                }
                ("normal", [mean, deviation]) => {
                    let before = said.len();
                    let middle = quantity(mean, dimension, context, said);
                    let spread = quantity(deviation, dimension, context, said);
                    as_beside(&mut said[before..], mean, deviation, dimension, context);
                    as_beside(&mut said[before..], deviation, mean, dimension, context);
                    let (mean, spread) = (middle?, spread?);
                    within(spread, LEAST, MOST, dimension, deviation.span, context, said)?;
                    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
                    Some(Distribution::Normal { mean, deviation: spread, low, high })
                }
                ("truncated", [inner, range]) => {
                    let whole = distribution(inner, dimension, context, said);
                    let ExpressionKind::Range(low, high) = &range.kind else {
                        said.push(codes::not_a(range.span, "range", &describe(range)));
                        return None;
                    };
                    let (a, b) = ends(range.span, low, high, dimension, context, said)?;
                    let kept = whole?.truncated(a, b);
                    if kept.is_none() {
                        said.push(codes::nothing_left(span, inner.span, range.span));
                    }
                    kept
                }
                ("choice", [_, ..]) => {
                    let parts = parts(said)?;
                    Some(Distribution::mixture(parts.into_iter().map(|part| (1.0, part)).collect()))
                }
                ("weighted", pairs @ [_, ..]) => {
                    let pair = |pair: &Expression| weighted(pair, dimension, context, said);
                    let parts = pairs.iter().map(pair).collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>()?;
                    Some(Distribution::mixture(parts))
                }
                _ => {
                    said.push(codes::wrong_arity(span, name, takes, arguments.len()));
                    None
                }
            }
        }
        _ if is_formula(expression) => {
            let before = said.len();
            let constant = quantity(expression, dimension, context, said).map(Distribution::Constant);
            as_dashed_range(&mut said[before..], expression, dimension, context);
            constant
        }
        _ => {
            let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
            said.push(codes::wrong_type(span, &Type::Distribution { dimension, min, max }, &describe(expression)));
            None
        }
    }
}

/// `(weight, distribution)`
fn weighted(
    pair: &Expression,
    dimension: Dimension,
    context: &Context,
    said: &mut Vec<Diagnostic>,
) -> Option<(f64, Distribution)> {
    let ExpressionKind::Group(members) = &pair.kind else {
        said.push(codes::not_a(pair.span, "pair `(weight, distribution)`", &describe(pair)));
        return None;
    };
    let [weight, part] = members.as_slice() else {
        said.push(codes::not_a(pair.span, "pair `(weight, distribution)`", &describe(pair)));
        return None;
    };
    if let (
        ExpressionKind::Number { unit: Some(_), .. } | ExpressionKind::Range(..),
        ExpressionKind::Number { unit: None, .. },
    ) = (&weight.kind, &part.kind)
        && dimension != Dimension::RATIO
    {
        let text = |span: Span| context.sources.text(span);
        let found = codes::not_a(pair.span, "pair `(weight, distribution)`", "pair the other way round");
        said.push(found.fix(format!("({}, {})", text(part.span), text(weight.span))));
        return None;
    }
    let number = quantity(weight, Dimension::RATIO, context, said);
    let part = distribution(part, dimension, context, said);
    let number = number?;
    within(number, LEAST, MOST, Dimension::RATIO, weight.span, context, said)?;
    Some((number, part?))
}

/// Most names that a word is compared with.
const MOST_COMPARED: usize = 200;

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
            diagnostics.push(codes::not_a(expression.span, &dimension.to_string(), "condition"));
            None
        }
        Sort::Quantity(found) if found == dimension => {
            let number = formula.evaluate(&|_: VariableId| unreachable!("no variable is in scope"));
            if number.is_finite() {
                return Some(number);
            }
            diagnostics.push(codes::out_of_range(expression.span, number.to_string(), "a finite number".into()));
            None
        }
        Sort::Quantity(Dimension::RATIO) => {
            let written = context.sources.text(expression.span);
            diagnostics.push(codes::missing_unit(expression.span, dimension, written));
            None
        }
        Sort::Quantity(found) => {
            let bare = matches!(expression.kind, ExpressionKind::Number { .. });
            let number = formula.evaluate(&|_: VariableId| unreachable!("no variable is in scope"));
            diagnostics.push(match (dimension, found) {
                (Dimension::RATIO, _) if !bare => codes::uncounted(expression.span, found),
                (Dimension::TIME, Dimension::FREQUENCY) if bare && number > 0.0 => {
                    codes::wrong_unit(expression.span, dimension, found).fix(format!("{} s", short(1.0 / number)))
                }
                _ => codes::wrong_unit(expression.span, dimension, found),
            });
            None
        }
    }
}

/// Takes a difference such as `20-50 km/h`, which lacks a unit, for the range that it is in print.
fn as_dashed_range(said: &mut [Diagnostic], expression: &Expression, dimension: Dimension, context: &Context) {
    if let ExpressionKind::Binary { operator: Operator::Subtract, left, right } = &expression.kind
        && let ExpressionKind::Number { value: low, unit: None } = left.kind
        && let ExpressionKind::Number { value: high, unit: Some(unit) } = &right.kind
        && low < *high
        && parse_unit(&unit.text).is_ok_and(|unit| unit.dimension == dimension)
        && let Some(said) = said.iter_mut().find(|each| each.code == "missing-unit" && each.primary.span == left.span)
    {
        let (low, high) = (context.sources.text(left.span), context.sources.text(right.span));
        let text = format!("{low} {} .. {high}", unit.text);
        said.help.push("`-` takes away; a range is written `low .. high`".into());
        said.fixes = vec![Fix { span: expression.span, text }];
    }
}

/// Leaves of the units that a number may lack those with which its key allows it.
///
/// Of angles both are always offered: a turn more or less is soon written.
fn as_allowed(said: &mut [Diagnostic], expression: &Expression, dimension: Dimension, (min, max): (f64, f64)) {
    if dimension == Dimension::ANGLE {
        return;
    }
    let ends = match &expression.kind {
        ExpressionKind::Range(low, high) => [low.span, high.span, low.span.to(high.span)],
        _ => [expression.span; 3],
    };
    let holds = |text: &str| {
        let (number, unit) = text.split_once(' ')?;
        let unit = parse_unit(unit).ok().filter(|unit| unit.dimension == dimension)?;
        let value = number.replace('_', "").parse::<f64>().ok()? * unit.factor;
        Some(value >= min && value <= max)
    };
    let allowed =
        |fix: &Fix| fix.text.split(" .. ").map(holds).collect::<Option<Vec<bool>>>().map(|all| !all.contains(&false));
    for said in said.iter_mut().filter(|each| each.code == "missing-unit" && ends.contains(&each.primary.span)) {
        // Units that are less usual, where the usual ones make it too much.
        let others = ["cm", "mm", "ms", "min"].map(|unit| Fix {
            span: said.primary.span,
            text: format!("{} {unit}", said.fixes.first().map_or("", |fix| fix.text.split(' ').next().unwrap_or(""))),
        });
        if said.fixes.iter().any(|fix| allowed(fix) == Some(true)) {
            said.fixes.retain(|fix| allowed(fix) != Some(false));
        } else if said.fixes.iter().all(|fix| allowed(fix) == Some(false)) {
            said.fixes.extend(others.into_iter().find(|fix| allowed(fix) == Some(true)));
            said.fixes.retain(|fix| allowed(fix) != Some(false));
        }
    }
}

/// Asks about a difference of two plain quantities of which the first is less: print writes ranges that way.
fn as_difference(expression: &Expression, drawn: &Distribution, context: &Context) -> Option<Diagnostic> {
    let (ExpressionKind::Binary { operator: Operator::Subtract, left, right }, Distribution::Constant(_)) =
        (&expression.kind, drawn)
    else {
        return None;
    };
    let (
        ExpressionKind::Number { value: low, unit: Some(unit) },
        ExpressionKind::Number { value: high, unit: Some(other) },
    ) = (&left.kind, &right.kind)
    else {
        return None;
    };
    let range = format!("{} .. {}", context.sources.text(left.span), context.sources.text(right.span));
    let value = format!("{} {}", short(low - high), unit.text);
    (unit.text == other.text && low < high).then(|| codes::difference(expression.span, &value, &range))
}

/// Leaves of the units that a number may lack only that of another number beside it, if there is one.
fn as_beside(
    said: &mut [Diagnostic],
    number: &Expression,
    beside: &Expression,
    dimension: Dimension,
    context: &Context,
) {
    let ExpressionKind::Number { unit: Some(unit), .. } = &beside.kind else { return };
    let lacking = said.iter_mut().find(|each| each.code == "missing-unit" && each.primary.span == number.span);
    if let Some(said) = lacking.filter(|_| parse_unit(&unit.text).is_ok_and(|unit| unit.dimension == dimension)) {
        let text = format!("{} {}", context.sources.text(number.span), unit.text);
        said.fixes = vec![Fix { span: number.span, text }];
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
    // What is told of as no bound is one all the same.
    let allowed = match number {
        _ if min == LEAST && 0.0 < number && number < LEAST => format!("{LEAST:e} or more, in SI"),
        _ if max == MOST && number > MOST => format!("{MOST:e} or less, in SI"),
        _ => bounds(min, max, dimension),
    };
    diagnostics.push(codes::out_of_range(span, written, allowed));
    None
}

/// Says that a value has another type than its key, and how it would be written if it is plain what was meant.
fn otherwise(expression: &Expression, ty: &Type, context: &Context) -> Diagnostic {
    let text = |span: Span| context.sources.text(span);
    let said = |fix: Option<String>, help: &str| {
        codes::written_otherwise(ty, &describe(expression), expression.span, fix, help)
    };
    let ranged = matches!(ty, Type::Range { .. } | Type::Distribution { .. });
    match (ty, &expression.kind) {
        (_, ExpressionKind::List(members) | ExpressionKind::Group(members)) if ranged => match members.as_slice() {
            [range @ Expression { kind: ExpressionKind::Range(..), .. }] => said(Some(text(range.span).into()), ""),
            [low, high] => {
                let (low, high) = (text(low.span), text(high.span));
                let said = said(Some(format!("{low} .. {high}")), "");
                let one_of = matches!((ty, &expression.kind), (Type::Distribution { .. }, ExpressionKind::List(_)));
                if one_of { said.fix(format!("choice({low}, {high})")) } else { said }
            }
            _ if matches!(ty, Type::Distribution { .. }) => {
                said(None, "a range is written `low .. high`, one of several values `choice(a, b, c)`")
            }
            _ => said(None, "a range is written `low .. high`"),
        },
        (Type::Range { .. }, _) => said(None, "a range is written `low .. high`"),
        (Type::List(_), ExpressionKind::Group(members)) => match (members.first(), members.last()) {
            (Some(first), Some(last)) => said(Some(format!("[{}]", text(first.span.to(last.span)))), ""),
            _ => said(None, ""),
        },
        (Type::Reference(_), ExpressionKind::Text(word)) => said(Some(word.clone()), "names have no quotes"),
        (Type::Text | Type::Path, ExpressionKind::Name(word)) => said(Some(format!("\"{word}\"")), ""),
        (Type::Boolean, ExpressionKind::Number { value, unit: None }) if *value == 0.0 || *value == 1.0 => {
            said(Some((*value == 1.0).to_string()), "")
        }
        (Type::Boolean, ExpressionKind::Name(word)) => {
            said(own_word(word).filter(|own| matches!(*own, "true" | "false")).map(str::to_string), "")
        }
        (_, ExpressionKind::List(members)) if members.len() == 1 && !matches!(ty, Type::List(_)) => {
            said(Some(text(members[0].span).into()), "")
        }
        (_, ExpressionKind::Name(word))
            if let Some(near) = nearest(word, context.names.params().take(MOST_COMPARED)) =>
        {
            said(Some(near.to_string()), "")
        }
        (_, ExpressionKind::Name(word)) if word == "None" || word == "null" => {
            said(None, "what may be left out is left out: take the key away")
        }
        _ => said(None, ""),
    }
}

fn describe(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number { unit: None, .. } => "a plain number".into(),
        ExpressionKind::Number { .. } => "a quantity".into(),
        ExpressionKind::Known(Known::Quantity(_, dimension)) => codes::one(dimension),
        ExpressionKind::Known(Known::Declaration(form, _)) => format!("the name of {}", codes::one(form)),
        ExpressionKind::Known(Known::Distribution(_, dimension)) => format!("a distribution of {dimension}"),
        ExpressionKind::Known(Known::Wrong) => "a parameter".into(),
        ExpressionKind::Text(_) => "a text".into(),
        ExpressionKind::Name(word) => format!("the word `{word}`"),
        ExpressionKind::Range(..) => "a range".into(),
        ExpressionKind::List(_) => "a list".into(),
        ExpressionKind::Group(parts) if parts.len() > 1 => format!("a tuple of {}", parts.len()),
        _ => "a formula".into(),
    }
}
