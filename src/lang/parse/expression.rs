//! Values: numbers with their units, words, calls, and expressions of them.

use std::iter::Peekable;

use pest::iterators::{Pair, Pairs};

use super::rules::Rule;
use super::{Reader, inner_text, read_number};
use crate::ast::{Entry, Expression, ExpressionKind, Name, Operator};
use crate::diagnostics;
use crate::formula::is_function;
use crate::requirement::is_temporal;
use crate::value::distributions;
use base::diagnostic::Span;
use base::signature::short;

/// Greatest number of terms and operators of one expression; later phases walk it recursively.
const MAX_TERMS: usize = 500;

impl Reader {
    pub(super) fn value(&mut self, pair: Pair<Rule>) -> Expression {
        let span = self.span(&pair);
        let source = pair.get_input();
        let pairs = pair.into_inner();
        let counts = |pair: &Pair<Rule>| {
            !matches!(pair.as_rule(), Rule::prefix | Rule::unit | Rule::arguments | Rule::conversion)
        };
        if pairs.len() > MAX_TERMS && pairs.clone().filter(counts).count() > MAX_TERMS {
            self.diagnostics.push(diagnostics::too_long(span, MAX_TERMS));
            return Expression { kind: ExpressionKind::Number { value: 0.0, unit: None }, span };
        }
        let mut pairs = pairs.peekable();
        let from = pairs.next_if(|pair| pair.as_rule() == Rule::range_from);
        let low = self.expression(&mut pairs);
        let sign = pairs.next_if(|pair| pair.as_rule() == Rule::range_sign);
        if let Some(sign) = sign.as_ref().filter(|_| from.is_none()) {
            self.mistake(sign);
        }
        if pairs.peek().is_none() {
            return low;
        }
        // A term without an operator before it starts the other end of a range.
        let high = self.expression(&mut pairs);
        if from.is_some() {
            let part = |value: &Expression| &source[value.span.start..value.span.end];
            let meant = format!("{} .. {}", part(&low), part(&high));
            self.report(span, "a range is written `low .. high`", Some(&meant));
        }
        let span = low.span.to(high.span);
        Expression { kind: ExpressionKind::Range(low.into(), high.into()), span }
    }

    fn expression(&mut self, pairs: &mut Peekable<Pairs<Rule>>) -> Expression {
        let first = self.term(pairs);
        self.operations(first, pairs, 0)
    }

    /// The operations after a term, as long as their operators bind at least this tightly.
    fn operations(&mut self, first: Expression, pairs: &mut Peekable<Pairs<Rule>>, least: u8) -> Expression {
        let mut left = first;
        let binds = |pair: &Pair<Rule>| operator(pair).filter(|(_, tightness)| *tightness >= least);
        while let Some((operator, tightness)) = pairs.peek().and_then(binds) {
            let sign = pairs.next().expect("it was peeked at");
            if sign.as_rule() == Rule::wrong_infix {
                self.mistake(&sign);
            }
            let joined = sign.as_str() == "+"
                && pairs
                    .peek()
                    .is_some_and(|next| next.as_str() == "-" && next.as_span().start() == sign.as_span().end());
            let right = self.term(pairs);
            if joined {
                self.diagnostics.push(diagnostics::tolerance(left.span.to(right.span), around(&left, &right)));
            }
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
        while let Some(prefix) = pairs.next_if(|pair| matches!(pair.as_rule(), Rule::prefix | Rule::wrong_prefix)) {
            match prefix.as_rule() {
                Rule::prefix => prefixes.push((prefix.as_str() == "-", self.span(&prefix))),
                _ => self.mistake(&prefix),
            }
        }
        let mut expression = self.primary(pairs);
        if let Some(conversion) = pairs.next_if(|pair| pair.as_rule() == Rule::conversion) {
            let unit = self.name(conversion.into_inner().next().expect("a conversion has a unit"));
            let span = expression.span.to(unit.span);
            expression = Expression { kind: ExpressionKind::Conversion(expression.into(), unit), span };
        }
        if let Some(unit) = pairs.next_if(|pair| pair.as_rule() == Rule::stray_unit) {
            self.stray_unit(&expression, &unit);
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
                if let Some(odd) = pairs.next_if(|pair| pair.as_rule() == Rule::odd_number) {
                    self.odd_number(&pair, &odd);
                }
                let unit = pairs.next_if(|pair| pair.as_rule() == Rule::unit).map(|unit| self.name(unit));
                if let Some(power) = pairs.next_if(|pair| pair.as_rule() == Rule::odd_power) {
                    self.mistake(&power);
                }
                let span = unit.as_ref().map_or(span, |unit| span.to(unit.span));
                return Expression { kind: ExpressionKind::Number { value, unit }, span };
            }
            Rule::text => ExpressionKind::Text(inner_text(&pair)),
            Rule::name => {
                let function = self.name(pair);
                let Some(list) = pairs.next_if(|pair| pair.as_rule() == Rule::arguments) else {
                    return Expression { kind: ExpressionKind::Name(function.text), span };
                };
                let span = span.to(self.span(&list));
                let (mut arguments, mut keys) = (Vec::new(), Vec::new());
                let text = list.get_input();
                for argument in self.arguments(list, false) {
                    match argument {
                        Entry::Bare(value) => {
                            keys.push(None);
                            arguments.push(value);
                        }
                        Entry::Property(property) => {
                            keys.push(Some(property.key));
                            arguments.push(property.value);
                        }
                        Entry::Clause(_) | Entry::Child(_) | Entry::Unread(_) => {
                            unreachable!("an argument is a value")
                        }
                    }
                }
                let named: Vec<&Name> = keys.iter().flatten().collect();
                if named.is_empty() {
                    self.ask_about_commas(text, &arguments);
                }
                // Kinds have keys; they may be in place of a name.
                let is_function = is_function(&function.text)
                    || is_temporal(&function.text)
                    || distributions().any(|name| name == function.text);
                if !named.is_empty() && is_function {
                    let written = |value: &Expression| &text[value.span.start..value.span.end];
                    let values: Vec<&str> = arguments.iter().map(written).collect();
                    let call = format!("{}({})", function.text, values.join(", "));
                    self.diagnostics.push(diagnostics::named_argument(&named, span, &call));
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
        let mut members: Vec<Expression> = Vec::new();
        for part in pair.into_inner() {
            if matches!(part.as_rule(), Rule::gap | Rule::group_gap) {
                let end = members.last().map_or(part.as_span().start(), |last| last.span.end);
                self.missing_comma(&part, end);
            } else {
                members.push(self.value(part));
            }
        }
        members
    }

    /// Reports a number whose digits continue after a blank, a quote or a second point.
    fn odd_number(&mut self, number: &Pair<Rule>, odd: &Pair<Rule>) {
        let (start, end) = (number.as_span().start(), odd.as_span().end());
        let written = &number.get_input()[start..end];
        if odd.as_str().starts_with('.') {
            return self.report(self.place(start, end), "a text needs quotes", Some(&format!("\"{written}\"")));
        }
        let meant = written.replace([' ', '\''], "_");
        self.report(self.place(start, end), "digits are grouped by `_`", Some(&meant));
    }

    /// Reports a unit after something other than a number or `in`.
    fn stray_unit(&mut self, value: &Expression, unit: &Pair<Rule>) {
        let text = unit.as_str().trim_end();
        let place = self.span(unit);
        let (word, rest) = text.split_at(text.find([' ', '\t']).unwrap_or(text.len()));
        if matches!(word, "as" | "to") {
            let place = Span { end: place.start + word.len(), ..place };
            return self.report(place, "write `in` before the unit", Some("in"));
        }
        let name = matches!(value.kind, ExpressionKind::Name(_) | ExpressionKind::Call { .. });
        let meant = format!("in {word}{rest}");
        match name {
            true => self.report(place, "a unit follows a number; write `in` to convert a quantity", Some(&meant)),
            false => self.report(place, "every number needs its own unit", None),
        }
    }

    /// Warns of two numbers of a call that may be one: the comma between them has no blank after it, and the other commas have one.
    fn ask_about_commas(&mut self, text: &str, arguments: &[Expression]) {
        let joined = |pair: &&[Expression]| pair[0].span.end + 1 == pair[1].span.start;
        let pairs: Vec<&[Expression]> = arguments.windows(2).filter(joined).collect();
        if pairs.len() + 1 >= arguments.len() {
            return;
        }
        for pair in pairs {
            let (from, comma) = (pair[0].span.start, pair[0].span.end);
            let whole = text[from..comma].bytes().all(|byte| byte.is_ascii_digit());
            let digits = text[comma + 1..].bytes().take_while(u8::is_ascii_digit).count();
            let end = comma + 1 + digits;
            if whole && digits > 0 && !text[end..].starts_with('.') {
                self.diagnostics.push(diagnostics::comma_in_number(self.place(from, end), &text[from..end]));
            }
        }
    }
}

/// The range of a quantity minus and plus another, when both are plain and in one unit.
fn around(middle: &Expression, less: &Expression) -> Option<String> {
    let number = |expression: &Expression| match &expression.kind {
        ExpressionKind::Number { value, unit } => Some((*value, unit.as_ref().map(|unit| unit.text.clone()))),
        _ => None,
    };
    let ((middle, unit), (less, other)) = (number(middle)?, number(less)?);
    let with_unit = |value: f64| format!("{} {}", short(value), unit.as_deref().unwrap_or_default()).trim().to_string();
    (unit == other).then(|| format!("{} .. {}", with_unit(middle + less), with_unit(middle - less)))
}

/// The precedence of comparisons: below that of their operands, above that of `and` and `or`.
const COMPARISON: u8 = 3;
/// That of `implies`, which groups to the right: `a implies b implies c` is `a implies (b implies c)`.
const IMPLIES: u8 = 0;

/// An operator and its precedence; none for another pair.
fn operator(pair: &Pair<Rule>) -> Option<(Operator, u8)> {
    if !matches!(pair.as_rule(), Rule::infix | Rule::wrong_infix) {
        return None;
    }
    Some(match pair.as_str() {
        "AND" => (Operator::And, 2),
        "gt" | "above" | "exceeds" | "ge" | "gte" | "==" => (Operator::Greater, COMPARISON),
        "lt" | "below" | "le" | "lte" | "=<" => (Operator::Less, COMPARISON),
        "^" | "**" => (Operator::Multiply, 5),
        "OR" | "if" | "elif" | "else" | "then" => (Operator::Or, 1),
        "implies" | "->" => (Operator::Implies, IMPLIES),
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
        other => unreachable!("`{other}` is no operator"),
    })
}
