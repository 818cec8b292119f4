//! Lists, and single members in their place.

use std::collections::BTreeMap;

use super::context::{Context, unfit};
use super::value;
use crate::ast::{Expression, ExpressionKind};
use crate::diagnostics;
use base::diagnostic::Diagnostic;
use base::signature::{Type, Value};

/// A list of members of a type; a single member is a list of one.
pub(super) fn list(
    expression: &Expression,
    ty: &Type,
    item: &Type,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Value> {
    let members = match &expression.kind {
        ExpressionKind::List(members) => members,
        ExpressionKind::Group(members) if members.len() > 1 && !matches!(item, Type::Point | Type::Pose) => {
            return unfit(expression, ty, context, diagnostics);
        }
        _ => return value(expression, item, context, diagnostics).map(|one| Value::List(vec![one])),
    };
    if members.is_empty() {
        diagnostics.push(diagnostics::empty_list(expression.span));
        return None;
    }
    let values: Vec<Option<Value>> = members.iter().map(|member| value(member, item, context, diagnostics)).collect();
    let values: Vec<Value> = values.into_iter().collect::<Option<_>>()?;
    if matches!(item, Type::Reference(_) | Type::Choice(_) | Type::WordOrReference(..))
        && let Some(repeated) = repeated(members, &values, context)
    {
        diagnostics.push(repeated);
        return None;
    }
    Some(Value::List(values))
}

/// The first name that stands in a list twice.
fn repeated(members: &[Expression], values: &[Value], context: &Context) -> Option<Diagnostic> {
    let mut seen = BTreeMap::new();
    for (member, value) in members.iter().zip(values) {
        let named = match value {
            Value::Reference(id) => (id.0, ""),
            Value::Choice(word) => (usize::MAX, *word),
            _ => continue,
        };
        if let Some(first) = seen.insert(named, member.span) {
            let written = context.sources.text(member.span);
            return Some(diagnostics::repeated_member(member.span, written, first));
        }
    }
    None
}
