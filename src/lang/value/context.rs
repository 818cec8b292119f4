use crate::ast::{Expression, ExpressionKind, Known};
use crate::diagnostics;
use crate::names::Names;
use base::diagnostic::{Diagnostic, Sources};
use base::signature::{Form, Type, Value, Vocabulary};

/// What a value is checked with.
pub(crate) struct Context<'a> {
    pub vocabulary: &'a Vocabulary,
    /// All forms, for suggestions.
    pub forms: &'a [Form],
    pub names: &'a Names<'a>,
    pub sources: &'a Sources,
}

/// What an expression is, for messages.
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

/// Reports an expression of another kind than its type wants, unless it is a parameter that may have been in a statement which could not be read.
pub(super) fn unfit(
    expression: &Expression,
    ty: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let lost = |word: &str| context.names.may_be_unread(word, context.names.params());
    if !matches!(&expression.kind, ExpressionKind::Name(word) if lost(word)) {
        diagnostics.push(diagnostics::wrong_type(expression.span, ty, &describe(expression)));
    }
    None
}
