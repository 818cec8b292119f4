//! Values: numbers with their units, words, calls, and expressions of them.

use std::iter::Peekable;

use pest::iterators::{Pair, Pairs};
use pest::pratt_parser::{Assoc, ConstPrattParser, Op};

use super::rules::Rule;
use super::{Reader, inner_text, read_number};
use crate::ast::{Entry, Expression, ExpressionKind, Known, Name, Operator};
use crate::diagnostics;
use crate::formula::is_function;
use crate::temporal::is_temporal;
use crate::value::distributions;
use base::diagnostic::Span;

/// Maximum number of terms and operators of one expression; later phases walk it recursively.
const MAX_TERMS: usize = 500;

/// The operators, from the one that binds least; `true` where it binds more than the one before. `a implies b implies c` is
/// `a implies (b implies c)`, and `not` applies to a whole comparison.
static OPERATORS: ConstPrattParser<Rule, 9> = ConstPrattParser::new_const([
    (Op::infix(Rule::range, Assoc::Left), true),
    (Op::infix(Rule::implies, Assoc::Right), true),
    (Op::infix(Rule::or, Assoc::Left), true),
    (Op::infix(Rule::and, Assoc::Left), true),
    (Op::prefix(Rule::not), true),
    (Op::infix(Rule::comparison, Assoc::Left), true),
    (Op::infix(Rule::sum, Assoc::Left), true),
    (Op::infix(Rule::product, Assoc::Left), true),
    (Op::prefix(Rule::minus), true),
]);

impl Reader {
    pub(super) fn value(&mut self, pair: Pair<Rule>) -> Expression {
        let (span, pairs) = (self.span(&pair), pair.into_inner());
        if pairs.len() > MAX_TERMS {
            self.diagnostics.push(diagnostics::too_long(span, MAX_TERMS));
            return Expression { kind: ExpressionKind::Known(Known::Wrong), span };
        }
        OPERATORS
            .map_primary(|operand| self.operand(operand))
            .map_prefix(move |sign, inner| {
                let span = Span { start: sign.as_span().start(), ..inner.span };
                let kind = match (sign.as_rule(), inner.kind) {
                    (Rule::not, kind) => ExpressionKind::Not(Expression { kind, span: inner.span }.into()),
                    (_, ExpressionKind::Number { value, unit }) => ExpressionKind::Number { value: -value, unit },
                    (_, kind) => ExpressionKind::Negate(Expression { kind, span: inner.span }.into()),
                };
                Expression { kind, span }
            })
            .map_infix(|left, sign, right| {
                let span = left.span.to(right.span);
                let (left, right) = (left.into(), right.into());
                let kind = match sign.as_rule() {
                    Rule::range => ExpressionKind::Range(left, right),
                    _ => ExpressionKind::Binary { operator: operator(sign.as_str()), left, right },
                };
                Expression { kind, span }
            })
            .parse(pairs)
    }

    /// A value, and the unit that it is counted in.
    fn operand(&mut self, pair: Pair<Rule>) -> Expression {
        let mut pairs = pair.into_inner().peekable();
        let expression = self.primary(&mut pairs);
        let Some(conversion) = pairs.next() else { return expression };
        let unit = self.name(conversion.into_inner().next().expect("a conversion has a unit"));
        let span = expression.span.to(unit.span);
        Expression { kind: ExpressionKind::Conversion(expression.into(), unit), span }
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

fn operator(sign: &str) -> Operator {
    match sign {
        "implies" => Operator::Implies,
        "or" => Operator::Or,
        "and" => Operator::And,
        "<" => Operator::Less,
        "<=" => Operator::LessEqual,
        ">" => Operator::Greater,
        ">=" => Operator::GreaterEqual,
        "+" => Operator::Add,
        "-" => Operator::Subtract,
        "*" => Operator::Multiply,
        "/" => Operator::Divide,
        other => unreachable!("`{other}` is not an operator"),
    }
}
