//! Checks requirements: formulas of temporal logic over comparisons of quantities.

use std::sync::Arc;

use super::context::{Context, describe};
use super::quantity::quantity;
use crate::ast::{Expression, ExpressionKind, Known, Operator};
use crate::diagnostics;
use crate::formula::{ROBUST, Scope, Sort, formula, functions, is_function};
use crate::temporal::{Word, is_temporal, temporal_operators};
use base::diagnostic::Diagnostic;
use base::signature::{BinaryOperator, Comparison, Formula, Requirement, Temporal, VariableId, Within};
use base::units::Dimension;

/// Checks an expression as a requirement; `None` after an error has been reported.
pub(super) fn requirement(
    expression: &Expression,
    scope: &Scope,
    context: &Context,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Arc<Requirement>> {
    let mut checker = Checker { scope, context, diagnostics, parts: Vec::new(), is_temporal: false };
    let formula = checker.visit(expression)?;
    let Checker { parts, is_temporal, .. } = checker;
    if !is_temporal && !parts.is_empty() {
        diagnostics.push(diagnostics::only_at_start(expression.span));
    }
    Some(Arc::new(Requirement { parts, formula }))
}

struct Checker<'a> {
    scope: &'a Scope<'a>,
    context: &'a Context<'a>,
    diagnostics: &'a mut Vec<Diagnostic>,
    parts: Vec<Comparison>,
    /// Whether there is a temporal operator.
    is_temporal: bool,
}

impl Checker<'_> {
    fn say<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.push(diagnostic);
        None
    }

    fn visit(&mut self, expression: &Expression) -> Option<Temporal> {
        match &expression.kind {
            ExpressionKind::Known(Known::Wrong) => None,
            ExpressionKind::Name(word) if word == "true" || word == "false" => Some(Temporal::Constant(word == "true")),
            ExpressionKind::Group(members) if members.len() == 1 => self.visit(&members[0]),
            ExpressionKind::Not(inner) => self.visit(inner).map(|inner| Temporal::Not(inner.into())),
            ExpressionKind::Binary { operator, left, right }
                if matches!(operator, Operator::And | Operator::Or | Operator::Implies) =>
            {
                let (a, b) = (self.visit(left), self.visit(right));
                let (a, b) = (a?.into(), b?.into());
                Some(match operator {
                    Operator::And => Temporal::And(a, b),
                    Operator::Or => Temporal::Or(a, b),
                    _ => Temporal::Or(Temporal::Not(a).into(), b),
                })
            }
            ExpressionKind::Call { function, arguments, .. } if is_temporal(&function.text) => {
                self.operator(Word::named(&function.text)?, arguments, expression)
            }
            ExpressionKind::Call { function, .. }
                if !is_function(&function.text)
                    && self.scope.vocabulary.signals.iter().all(|signal| signal.name != function.text) =>
            {
                let known: Vec<&str> = temporal_operators().chain(functions()).map(|(name, _)| name).collect();
                self.say(diagnostics::unknown_function(function.span, &function.text, &known))
            }
            _ => self.part(expression, None),
        }
    }

    fn operator(&mut self, word: Word, arguments: &[Expression], whole: &Expression) -> Option<Temporal> {
        let (one, two) = ("a condition", "two conditions");
        match word {
            Word::Always => self.operands(word, one, arguments, whole).map(|(within, [a])| Temporal::Always(within, a)),
            Word::Eventually => {
                self.operands(word, one, arguments, whole).map(|(within, [a])| Temporal::Eventually(within, a))
            }
            Word::Until => {
                self.operands(word, two, arguments, whole).map(|(within, [a, b])| Temporal::Until(within, a, b))
            }
            Word::Scaled => {
                let [comparison, scale] = arguments else {
                    let expected = "a comparison and the quantity that counts as 1";
                    return self.say(diagnostics::wrong_arity(whole.span, "scaled", expected, arguments.len()));
                };
                self.part(comparison, Some(scale))
            }
        }
    }

    /// The operands of an operator, and its bound.
    fn operands<const N: usize>(
        &mut self,
        word: Word,
        expected: &str,
        arguments: &[Expression],
        whole: &Expression,
    ) -> Option<(Within, [Arc<Temporal>; N])> {
        self.is_temporal = true;
        if !(N..=N + 1).contains(&arguments.len()) {
            let expected = format!("{expected}, and perhaps a bound such as `[0 s, 2 s]`");
            return self.say(diagnostics::wrong_arity(whole.span, word.name(), &expected, arguments.len()));
        }
        let inner: Vec<_> = arguments[..N].iter().map(|each| self.visit(each).map(Arc::new)).collect();
        let within = arguments.get(N).map_or(Some(Within::EPISODE), |bound| self.bound(bound));
        Some((within?, inner.into_iter().collect::<Option<Vec<_>>>()?.try_into().ok()?))
    }

    /// `[0 s, 2 s]`
    fn bound(&mut self, bound: &Expression) -> Option<Within> {
        let ExpressionKind::List(ends) = &bound.kind else {
            return self.say(diagnostics::not_a(bound.span, "bound such as `[0 s, 2 s]`", &describe(bound)));
        };
        let [low, high] = ends.as_slice() else {
            return self.say(diagnostics::wrong_bound(bound.span, ends.len()));
        };
        let (from, to) = (self.constant(low, Dimension::TIME), self.constant(high, Dimension::TIME));
        let (from, to) = (from?, to?);
        if from < 0.0 {
            let text = self.context.sources.text(low.span).to_string();
            return self.say(diagnostics::out_of_range(low.span, text, "0 s or more".into()));
        }
        if from > to {
            return self.say(diagnostics::empty_range(bound.span));
        }
        Some(Within { from, to })
    }

    /// A quantity without variables (SI).
    fn constant(&mut self, expression: &Expression, wanted: Dimension) -> Option<f64> {
        quantity(expression, wanted, self.context, self.diagnostics)
    }

    /// A comparison, perhaps with its scale, or a condition without degree.
    fn part(&mut self, expression: &Expression, scale: Option<&Expression>) -> Option<Temporal> {
        let expression = match &expression.kind {
            ExpressionKind::Group(members) if members.len() == 1 => &members[0],
            _ => expression,
        };
        let whole = match formula(expression, self.scope, self.diagnostics)? {
            (formula, Sort::Truth) => formula,
            (_, Sort::Quantity(dimension)) => {
                return self.say(diagnostics::not_a(expression.span, "condition", &dimension.to_string()));
            }
        };
        let (margin, strict, dimension) = match (&whole, &expression.kind) {
            (Formula::Binary(operator, a, b), ExpressionKind::Binary { left, .. }) if operator.compares() => {
                use BinaryOperator::{Greater, GreaterEqual, Less, Subtract};
                let (more, less) = if matches!(operator, Greater | GreaterEqual) { (a, b) } else { (b, a) };
                let margin = Formula::Binary(Subtract, Arc::clone(more), Arc::clone(less));
                let Some((_, Sort::Quantity(dimension))) = formula(left, self.scope, &mut Vec::new()) else {
                    unreachable!("checked: the side of a comparison is a quantity")
                };
                (margin, matches!(operator, Less | Greater), Some(dimension))
            }
            _ => (whole, false, None),
        };
        let scale = match (scale, dimension) {
            (None, Some(dimension)) => self.usual_scale(&margin, dimension),
            (None, None) => 1.0,
            (Some(scale), None) => {
                return self.say(diagnostics::not_a(scale.span, "comparison before it", "condition"));
            }
            (Some(scale), Some(dimension)) => match self.constant(scale, dimension)? {
                value if value > 0.0 => value,
                _ => {
                    let text = self.context.sources.text(scale.span).to_string();
                    return self.say(diagnostics::out_of_range(scale.span, text, "above 0".into()));
                }
            },
        };
        let text = self.context.sources.text(expression.span).split_whitespace().collect::<Vec<_>>().join(" ");
        let part = Comparison { text, margin, strict, dimension, scale };
        let bounds = |id: VariableId| self.scope.vocabulary.variable(id).map_or(ROBUST, |variable| variable.bounds);
        if let Some(truth) = part.settled(&bounds) {
            return self.say(diagnostics::foregone(expression.span, truth));
        }
        self.parts.push(part);
        Some(Temporal::Part(self.parts.len() - 1))
    }

    /// The maximum scale of the variables with this dimension in a formula; 1 (SI) without such a variable.
    fn usual_scale(&self, margin: &Formula, dimension: Dimension) -> f64 {
        let scale = std::cell::Cell::new(None::<f64>);
        margin.mentions(&|id| {
            let variable = self.scope.vocabulary.variable(id).filter(|variable| variable.dimension == dimension);
            scale.set(
                variable.map_or(scale.get(), |found| Some(scale.get().map_or(found.scale, |s| s.max(found.scale)))),
            );
            false
        });
        scale.get().unwrap_or(1.0)
    }
}
