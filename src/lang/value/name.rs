//! Names of declarations, and words of a choice.

use super::context::{Context, unfit};
use crate::ast::{Expression, ExpressionKind, Known};
use crate::diagnostics;
use crate::library;
use base::diagnostic::{Diagnostic, Span};
use base::signature::{Type, Value};

/// One of some words.
pub(super) fn choice(
    expression: &Expression,
    ty: &Type,
    words: &[&'static str],
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let (ExpressionKind::Name(word) | ExpressionKind::Text(word)) = &expression.kind else {
        return unfit(expression, ty, context, diagnostics);
    };
    let known = words.iter().find(|known| *known == word);
    if known.is_none() {
        let said = diagnostics::unknown_choice(expression.span, word, words);
        let is_place = matches!(ty, Type::WordOrPoint(_));
        diagnostics.push(if is_place { said.help("or write a point of the town: `(10 m, 20 m)`") } else { said });
    }
    known.map(|known| Value::Choice(known))
}

/// One of some words, or the name of a declaration.
pub(super) fn word_or_reference(
    expression: &Expression,
    words: &[&'static str],
    form: &'static str,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    if let ExpressionKind::Name(word) | ExpressionKind::Text(word) = &expression.kind {
        if let Some(known) = words.iter().find(|known| *known == word) {
            return Some(Value::Choice(known));
        }
        // With no declaration at hand, a wrong word is a typo of one of the words.
        let no_declaration = context.names.of_form(form).next().is_none();
        if no_declaration && context.names.other_form(context.forms, word).is_none() {
            diagnostics.push(diagnostics::unknown_choice(expression.span, word, words));
            return None;
        }
    }
    match &expression.kind {
        ExpressionKind::Name(word) => named(expression.span, form, word, words, context, diagnostics),
        _ => super::value(expression, &Type::Reference(form), context, diagnostics),
    }
}

/// A declaration of a form.
pub(super) fn reference(
    expression: &Expression,
    form: &'static str,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let span = expression.span;
    let written = |member: &Expression| context.sources.text(member.span);
    match &expression.kind {
        ExpressionKind::Name(word) => named(span, form, word, &[], context, diagnostics),
        ExpressionKind::Inline { form: known, place } if form == *known => {
            Some(Value::Reference(context.names.own(*place)))
        }
        ExpressionKind::Known(Known::Declaration(known, id)) if form == *known => Some(Value::Reference(*id)),
        ExpressionKind::Call { function, .. } if has_kind(form, &function.text, context) => {
            diagnostics.push(diagnostics::kind_in_place(span, form, written(expression)));
            None
        }
        _ => unfit(expression, &Type::Reference(form), context, diagnostics),
    }
}

/// The declaration of this name; `words` may stand in its place.
fn named(
    span: Span,
    form: &str,
    word: &str,
    words: &[&'static str],
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let names = context.names;
    if let Some(id) = names.find(form, word) {
        return Some(Value::Reference(id));
    }
    if names.may_be_unread(word, names.of_form(form)) {
        return None;
    }
    let other = names.other_form(context.forms, word);
    let known: Vec<&str> = words.iter().copied().chain(names.of_form(form)).collect();
    diagnostics.push(if let Some(file) = library::home(form, word) {
        diagnostics::not_imported(span, form, word, file, names.another_import(word, file, context.sources))
    } else if has_kind(form, word, context) {
        diagnostics::kind_for_name(span, form, word)
    } else if let Some(other) = other {
        diagnostics::other_form(span, form, word, other, &known)
    } else {
        diagnostics::unknown_name(span, form, word, &known)
    });
    None
}

fn has_kind(form: &str, word: &str, context: &Context<'_>) -> bool {
    let mut kinds = context.forms.iter().filter(|each| each.name == form).flat_map(|each| &each.kinds);
    kinds.any(|kind| kind.name == word)
}
