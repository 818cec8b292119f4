//! Values: numbers with their units, words, calls, and expressions of them.

use std::iter::Peekable;

use pest::iterators::{Pair, Pairs};

use super::rules::Rule;
use super::{Reader, inner_text, read_number};
use crate::ast::{Entry, Expression, ExpressionKind, Known, Name, Operator};
use crate::diagnostics;
use crate::formula::is_function;
use crate::requirement::is_temporal;
use crate::value::distributions;
use base::diagnostic::Span;

/// Maximum number of terms and operators of one expression; later phases walk it recursively.
const MAX_TERMS: usize = 500;

impl Reader {
    pub(super) fn value(&mut self, pair: Pair<Rule>) -> Expression {
        let span = self.span(&pair);
        let pairs = pair.into_inner();
        let counts = |pair: &Pair<Rule>| {
            !matches!(pair.as_rule(), Rule::prefix | Rule::unit | Rule::arguments | Rule::conversion)
        };
        if pairs.len() > MAX_TERMS && pairs.clone().filter(counts).count() > MAX_TERMS {
            self.diagnostics.push(diagnostics::too_long(span, MAX_TERMS));
            return Expression { kind: ExpressionKind::Known(Known::Wrong), span };
        }
        let mut pairs = pairs.peekable();
        let low = self.expression(&mut pairs);
        if pairs.next_if(|pair| pair.as_rule() == Rule::range).is_none() {
            return low;
        }
        let high = self.expression(&mut pairs);
        let span = low.span.to(high.span);
        Expression { kind: ExpressionKind::Range(low.into(), high.into()), span }
    }

    fn expression(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let first = self.term(pairs);
        self.operations(first, pairs, 0)
    }

    /// The operations after a term, as long as their operators bind at least this tightly.
    fn operations(&mut self, first: Expression, pairs: &mut Peekable<Pairs<Rule>>, min_tightness: u8) -> Expression {
        let mut left = first;
        let binds = |pair: &Pair<Rule>| operator(pair).filter(|(_, tightness)| *tightness >= min_tightness);
        while let Some((operator, tightness)) = pairs.peek().and_then(binds) {
            pairs.next();
            let right = self.term(pairs);
            let groups_right = tightness == IMPLIES;
            let right = self.operations(right, pairs, if groups_right { tightness } else { tightness + 1 });
            let span = left.span.to(right.span);
            let kind = ExpressionKind::Binary { operator, left: left.into(), right: right.into() };
            left = Expression { kind, span };
        }
        left
    }

    /// Signs, their operand, and the unit that it is counted in.
    fn term(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let mut prefixes = Vec::new();
        while let Some(prefix) = pairs.next_if(|pair| pair.as_rule() == Rule::prefix) {
            prefixes.push((prefix.as_str() == "-", self.span(&prefix)));
        }
        let mut expression = self.primary(pairs);
        if let Some(conversion) = pairs.next_if(|pair| pair.as_rule() == Rule::conversion) {
            let unit = self.name(conversion.into_inner().next().expect("a conversion has a unit"));
            let span = expression.span.to(unit.span);
            expression = Expression { kind: ExpressionKind::Conversion(expression.into(), unit), span };
        }
        if prefixes.len() > MAX_TERMS {
            self.diagnostics.push(diagnostics::too_long(prefixes[0].1, MAX_TERMS));
            return expression;
        }
        for (negative, span) in prefixes.into_iter().rev() {
            if !negative {
                // `not` applies to a whole comparison.
                expression = self.operations(expression, pairs, COMPARISON);
            }
            let span = span.to(expression.span);
            let kind = match (negative, expression.kind) {
                (true, ExpressionKind::Number { value, unit }) => ExpressionKind::Number { value: -value, unit },
                (true, kind) => ExpressionKind::Negate(Expression { kind, span: expression.span }.into()),
                (false, kind) => ExpressionKind::Not(Expression { kind, span: expression.span }.into()),
            };
            expression = Expression { kind, span };
        }
        expression
    }

    /// A number with its unit, a word or a call, a text, a group, a list.
    fn primary(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let pair = pairs.next().expect("a term has a value");
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::number => {
                let value = read_number(pair.as_str());
                let unit = pairs.next_if(|pair| pair.as_rule() == Rule::unit).map(|unit| self.name(unit));
                let span = unit.as_ref().map_or(span, |unit| span.to(unit.span));
                return Expression { kind: ExpressionKind::Number { value, unit }, span };
            }
            Rule::text => ExpressionKind::Text(inner_text(&pair)),
            Rule::signal => {
                let (role, signal) = pair.as_str().split_once('.').expect("a signal has a role");
                let part = |text: &str, start: usize| Name {
                    text: text.to_string(),
                    span: Span { start: span.start + start, end: span.start + start + text.len(), ..span },
                };
                let (role, function) = (part(role, 0), part(signal, role.len() + 1));
                let arguments = vec![Expression { kind: ExpressionKind::Name(role.text), span: role.span }];
                ExpressionKind::Call { function, arguments, keys: vec![None] }
            }
            Rule::name => {
                let function = self.name(pair);
                let Some(list) = pairs.next_if(|pair| pair.as_rule() == Rule::arguments) else {
                    return Expression { kind: ExpressionKind::Name(function.text), span };
                };
                let span = span.to(self.span(&list));
                let (mut arguments, mut keys) = (Vec::new(), Vec::new());
                for argument in self.arguments(list) {
                    match argument {
                        Entry::Bare(value) => {
                            keys.push(None);
                            arguments.push(value);
                        }
                        Entry::Property(property) => {
                            keys.push(Some(property.key));
                            arguments.push(property.value);
                        }
                        Entry::Clause(_) | Entry::Child(_) | Entry::Unread => {
                            unreachable!("an argument is a value")
                        }
                    }
                }
                // Kinds have keys; they may be in place of a name.
                let is_function = is_function(&function.text)
                    || is_temporal(&function.text)
                    || distributions().any(|name| name == function.text);
                if let Some(key) = keys.iter().flatten().next().filter(|_| is_function) {
                    self.diagnostics.push(diagnostics::named_argument(key.span, &key.text));
                    return Expression { kind: ExpressionKind::Known(Known::Wrong), span };
                }
                return Expression { kind: ExpressionKind::Call { function, arguments, keys }, span };
            }
            Rule::group => ExpressionKind::Group(self.members(pair)),
            Rule::list => ExpressionKind::List(self.members(pair)),
            other => unreachable!("no primary is a {other:?}"),
        };
        Expression { kind, span }
    }

    /// The values between commas of a group or a list.
    fn members(&mut self, pair: Pair<Rule>) -> Vec<Expression> {
        pair.into_inner().filter(|part| part.as_rule() == Rule::value).map(|part| self.value(part)).collect()
    }
}

/// The precedence of comparisons: below that of their operands, above that of `and` and `or`.
const COMPARISON: u8 = 3;
/// That of `implies`, which groups to the right: `a implies b implies c` is `a implies (b implies c)`.
const IMPLIES: u8 = 0;

/// An operator and its precedence; `None` for another pair.
fn operator(pair: &Pair<Rule>) -> Option<(Operator, u8)> {
    if pair.as_rule() != Rule::infix {
        return None;
    }
    Some(match pair.as_str() {
        "implies" => (Operator::Implies, IMPLIES),
        "or" => (Operator::Or, 1),
        "and" => (Operator::And, 2),
        "<" => (Operator::Less, COMPARISON),
        "<=" => (Operator::LessEqual, COMPARISON),
        ">" => (Operator::Greater, COMPARISON),
        ">=" => (Operator::GreaterEqual, COMPARISON),
        "+" => (Operator::Add, 4),
        "-" => (Operator::Subtract, 4),
        "*" => (Operator::Multiply, 5),
        "/" => (Operator::Divide, 5),
        other => unreachable!("`{other}` is not an operator"),
    })
}
