//! Suggestions for a value that is wrong, or that probably has another meaning.

use std::f64::consts::{PI, TAU};

use super::Context;
use crate::ast::{Expression, ExpressionKind, Known, Operator};
use crate::diagnostics;
use crate::foreign_names::own_words;
use crate::suggest::nearest;
use base::diagnostic::{Diagnostic, Fix, Span};
use base::signature::{Distribution, Type, short};
use base::units::{Dimension, parse_unit};

/// The greatest number of names that a word is compared with.
const MOST_COMPARED: usize = 200;

/// One place, or several, with the units that all of its numbers lack.
pub(super) fn places_with_units(expression: &Expression, ty: &Type, context: &Context) -> Option<String> {
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

/// The probable meaning of a distribution beyond the bounds of its key.
pub(super) fn as_meant(expression: &Expression, drawn: &Distribution, ty: &Type, context: &Context) -> Option<String> {
    let text = |span: Span| context.sources.text(span);
    let (low, high) = drawn.support();
    let Type::Distribution { dimension, min, max } = ty else { return None };
    if *dimension == Dimension::ANGLE {
        // More than one turn in radians was probably meant in degrees.
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

/// The directions (rad) from `from` to `to` counter-clockwise, by one turn at most, in ranges between -180° and 180°. If both are
/// equal, it is that direction alone.
pub(super) fn round_the_back(from: f64, to: f64) -> String {
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

/// Reads a difference such as `20-50 km/h`, which lacks a unit, as a range in the notation of print.
pub(super) fn as_dashed_range(
    said: &mut [Diagnostic],
    expression: &Expression,
    dimension: Dimension,
    context: &Context,
) {
    if let ExpressionKind::Binary { operator: Operator::Subtract, left, right } = &expression.kind
        && let ExpressionKind::Number { value: low, unit: None } = left.kind
        && let ExpressionKind::Number { value: high, unit: Some(unit) } = &right.kind
        && low < *high
        && parse_unit(&unit.text).is_ok_and(|unit| unit.dimension == dimension)
        && let Some(said) = said.iter_mut().find(|each| each.code == "missing-unit" && each.primary.span == left.span)
    {
        let (low, high) = (context.sources.text(left.span), context.sources.text(right.span));
        let text = format!("{low} {} .. {high}", unit.text);
        said.help.push("`-` subtracts; a range is written `low .. high`".into());
        said.fixes = vec![Fix { span: expression.span, text }];
    }
}

/// Keeps, of the units that a number may lack, those with which its key allows it.
///
/// For angles both are always offered, since a full turn more or less is a common mistake.
pub(super) fn as_allowed(
    said: &mut [Diagnostic],
    expression: &Expression,
    dimension: Dimension,
    (min, max): (f64, f64),
) {
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
        // Less usual units, if the number is too large in the usual ones.
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

/// Asks about a difference of two plain quantities of which the first is less: print writes ranges in that way.
pub(super) fn as_difference(expression: &Expression, drawn: &Distribution, context: &Context) -> Option<Diagnostic> {
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
    (unit.text == other.text && low < high).then(|| diagnostics::difference(expression.span, &value, &range))
}

/// Keeps, of the units that a number may lack, only that of another number next to it, if there is one.
pub(super) fn as_beside(
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

/// Reports that a value has another type than its key, and how to write it if the plain value was meant.
pub(super) fn otherwise(expression: &Expression, ty: &Type, context: &Context) -> Diagnostic {
    let text = |span: Span| context.sources.text(span);
    let said = |fix: Option<String>, help: &str| {
        diagnostics::written_otherwise(ty, &describe(expression), expression.span, fix, help)
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
        (Type::Range { dimension, min, max }, ExpressionKind::Number { value, unit: Some(unit) })
            if *min <= 0.0
                && *max > 0.0
                && *value > 0.0
                && parse_unit(&unit.text).is_ok_and(|u| u.dimension == *dimension) =>
        {
            said(Some(format!("0 {} .. {}", unit.text, text(expression.span))), "a range is written `low .. high`")
        }
        (Type::Range { .. }, _) => said(None, "a range is written `low .. high`"),
        (Type::List(_), ExpressionKind::Group(members)) => match (members.first(), members.last()) {
            (Some(first), Some(last)) => said(Some(format!("[{}]", text(first.span.to(last.span)))), ""),
            _ => said(None, ""),
        },
        (
            Type::Quantity { .. } | Type::Distribution { .. } | Type::Integer { .. } | Type::Ticks { .. },
            ExpressionKind::Text(written),
        ) if written.starts_with(|first: char| first.is_ascii_digit() || first == '-') => {
            said(Some(written.clone()), "numbers have no quotes")
        }
        (Type::Reference(_), ExpressionKind::Text(word)) => said(Some(word.clone()), "names have no quotes"),
        (Type::Text | Type::Path, ExpressionKind::Name(word)) => said(Some(format!("\"{word}\"")), ""),
        (Type::Boolean, ExpressionKind::Number { value, unit: None }) if *value == 0.0 || *value == 1.0 => {
            said(Some((*value == 1.0).to_string()), "")
        }
        (Type::Boolean, ExpressionKind::Name(word)) => {
            said(own_words(word).iter().find(|own| matches!(**own, "true" | "false")).map(|own| (*own).to_string()), "")
        }
        (_, ExpressionKind::List(members)) if members.len() == 1 && !matches!(ty, Type::List(_)) => {
            said(Some(text(members[0].span).into()), "")
        }
        (_, ExpressionKind::Name(word))
            if let Some(near) = nearest(word, context.names.params().take(MOST_COMPARED)) =>
        {
            said(Some(near.to_string()), "")
        }
        (_, ExpressionKind::Name(word)) if word == "None" || word == "null" => said(None, "leave the key out instead"),
        _ => said(None, ""),
    }
}

pub(super) fn describe(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number { unit: None, .. } => "a plain number".into(),
        ExpressionKind::Number { .. } => "a quantity".into(),
        ExpressionKind::Known(Known::Quantity(_, dimension)) => diagnostics::one(dimension),
        ExpressionKind::Known(Known::Declaration(form, _)) => format!("the name of {}", diagnostics::one(form)),
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
