//! Checks formulas: names, arity, dimensions.

use super::ast::{Expression, ExpressionKind, Known, Name};
use super::codes;
use super::names::Names;
use crate::diagnostic::{Diagnostic, Span};
use crate::signature::{BinaryOperator, Formula, Function, VariableId, Vocabulary};
use crate::units::{Dimension, UNIT_NAMES, Unit, UnitError, parse_unit};

/// What a formula gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    /// A quantity.
    Quantity(Dimension),
    /// True or false.
    Truth,
}

/// The variables a formula may name.
pub(super) struct Scope<'a> {
    pub vocabulary: &'a Vocabulary,
    /// The event, for messages, and the variables that have a value then.
    pub available: &'a [&'static str],
    pub event: &'a str,
    /// The names that can be seen, for suggestions: what is no variable may be a parameter.
    pub names: &'a Names<'a>,
}

/// The names of the functions that formulas may call.
pub fn functions() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|(name, _)| *name)
}

const FUNCTIONS: &[(&str, Function)] = &[
    ("min", Function::Min),
    ("max", Function::Max),
    ("abs", Function::Abs),
    ("exp", Function::Exp),
    ("sqrt", Function::Sqrt),
    ("log_likelihood", Function::LogLikelihood),
];

/// Whether formulas have a function of this name.
pub(super) fn is_function(name: &str) -> bool {
    FUNCTIONS.iter().any(|(known, _)| *known == name)
}

/// Checks an expression as a formula; `None` when something was wrong and has been said.
pub(super) fn formula(
    expression: &Expression,
    scope: &Scope,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<(Formula, Sort)> {
    Checker { scope, diagnostics }.visit(expression)
}

/// Reads a unit, saying what is wrong with it.
pub(super) fn unit(name: &Name, diagnostics: &mut Vec<Diagnostic>) -> Option<Unit> {
    let names = || -> Vec<&str> { UNIT_NAMES.iter().map(|(name, _)| *name).collect() };
    match parse_unit(&name.text) {
        Ok(unit) => Some(unit),
        Err(UnitError::Unknown { name: part }) => {
            diagnostics.push(codes::unknown_unit(name.span, &name.text, Some(&part), &names()));
            None
        }
        Err(UnitError::BadPower) => {
            diagnostics.push(codes::unknown_unit(name.span, &name.text, None, &names()));
            None
        }
    }
}

struct Checker<'a> {
    scope: &'a Scope<'a>,
    diagnostics: &'a mut Vec<Diagnostic>,
}

impl Checker<'_> {
    fn say<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.push(diagnostic);
        None
    }

    fn visit(&mut self, expression: &Expression) -> Option<(Formula, Sort)> {
        let span = expression.span;
        match &expression.kind {
            ExpressionKind::Number { value, unit: None } => {
                Some((Formula::Constant(*value), Sort::Quantity(Dimension::RATIO)))
            }
            ExpressionKind::Number { value, unit: Some(name) } => {
                let unit = unit(name, self.diagnostics)?;
                Some((Formula::Constant(value * unit.factor), Sort::Quantity(unit.dimension)))
            }
            ExpressionKind::Name(word) => self.variable(word, span),
            ExpressionKind::Known(Known::Quantity(value, dimension)) => {
                Some((Formula::Constant(*value), Sort::Quantity(*dimension)))
            }
            ExpressionKind::Known(Known::Wrong) => None,
            ExpressionKind::Known(Known::Declaration(form, _)) => self.say(codes::not_a(span, "formula", form)),
            ExpressionKind::Group(members) if members.len() == 1 => self.visit(&members[0]),
            ExpressionKind::Negate(inner) => {
                let (formula, dimension) = self.quantity(inner)?;
                Some((Formula::Negate(formula.into()), Sort::Quantity(dimension)))
            }
            ExpressionKind::Not(inner) => Some((Formula::Not(self.truth(inner)?.into()), Sort::Truth)),
            ExpressionKind::Conversion(inner, name) => {
                let converted = self.quantity(inner);
                let unit = unit(name, self.diagnostics)?;
                let (formula, dimension) = converted?;
                if dimension != unit.dimension {
                    return self.say(codes::wrong_unit(inner.span, unit.dimension, dimension));
                }
                let factor = Formula::Constant(unit.factor);
                Some((binary(BinaryOperator::Divide, formula, factor), Sort::Quantity(Dimension::RATIO)))
            }
            ExpressionKind::Binary { operator, left, right } => self.binary(*operator, left, right, span),
            ExpressionKind::Call { function, arguments } => self.call(function, arguments, span),
            ExpressionKind::Text(_) => self.say(codes::not_a(span, "formula", "text")),
            ExpressionKind::Range(..) => self.say(codes::not_a(span, "formula", "range")),
            ExpressionKind::Group(_) => self.say(codes::not_a(span, "formula", "tuple")),
            ExpressionKind::List(_) => self.say(codes::not_a(span, "formula", "list")),
        }
    }

    fn quantity(&mut self, expression: &Expression) -> Option<(Formula, Dimension)> {
        match self.visit(expression)? {
            (formula, Sort::Quantity(dimension)) => Some((formula, dimension)),
            (_, Sort::Truth) => self.say(codes::not_a(expression.span, "quantity", "condition")),
        }
    }

    fn truth(&mut self, expression: &Expression) -> Option<Formula> {
        match self.visit(expression)? {
            (formula, Sort::Truth) => Some(formula),
            (_, Sort::Quantity(dimension)) => {
                self.say(codes::not_a(expression.span, "condition", &dimension.to_string()))
            }
        }
    }

    fn variable(&mut self, word: &str, span: Span) -> Option<(Formula, Sort)> {
        if word == "true" || word == "false" {
            return Some((Formula::Constant(f64::from(word == "true")), Sort::Truth));
        }
        let scope = self.scope;
        match scope.vocabulary.variables.iter().position(|variable| variable.name == word) {
            None => {
                let known = scope.available.iter().copied().chain(scope.names.params());
                self.say(codes::unknown_variable(span, word, known))
            }
            Some(_) if !scope.available.contains(&word) => {
                self.say(codes::unavailable_variable(span, word, scope.event, scope.available))
            }
            Some(index) => {
                let dimension = scope.vocabulary.variables[index].dimension;
                Some((Formula::Variable(VariableId(index)), Sort::Quantity(dimension)))
            }
        }
    }

    fn binary(
        &mut self,
        operator: BinaryOperator,
        left: &Expression,
        right: &Expression,
        span: Span,
    ) -> Option<(Formula, Sort)> {
        use BinaryOperator::{Add, And, Divide, Greater, GreaterEqual, Less, LessEqual, Multiply, Or, Subtract};
        if matches!(operator, And | Or) {
            let (a, b) = (self.truth(left), self.truth(right));
            return Some((binary(operator, a?, b?), Sort::Truth));
        }
        let (a, b) = (self.quantity(left), self.quantity(right));
        let ((a, first), (b, second)) = (a?, b?);
        let sort = match operator {
            Multiply | Divide => {
                let dimension = if operator == Multiply { first.times(second) } else { first.over(second) };
                match dimension {
                    Some(dimension) => Sort::Quantity(dimension),
                    None => return self.say(codes::syntax(span, "the power of a unit grows beyond reason".into())),
                }
            }
            _ if first != second => return self.say(codes::mixed_dimensions(left.span, first, right.span, second)),
            Add | Subtract => Sort::Quantity(first),
            Less | LessEqual | Greater | GreaterEqual => Sort::Truth,
            And | Or => unreachable!("handled above"),
        };
        if operator == Divide && constant(&b) == Some(0.0) {
            return self.say(codes::not_finite(right.span, "nothing can be divided by 0"));
        }
        let formula = self.finite(binary(operator, a, b), span)?;
        Some((formula, sort))
    }

    /// The formula, unless it is a constant that is no number.
    fn finite(&mut self, formula: Formula, span: Span) -> Option<Formula> {
        match constant(&formula) {
            Some(value) if !value.is_finite() => self.say(codes::not_finite(span, "this is no finite number")),
            _ => Some(formula),
        }
    }

    fn call(&mut self, name: &Name, arguments: &[Expression], span: Span) -> Option<(Formula, Sort)> {
        let known: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).collect();
        let checked: Vec<Option<(Formula, Dimension)>> = arguments.iter().map(|each| self.quantity(each)).collect();
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name.text) else {
            return self.say(codes::unknown_function(name.span, &name.text, &known));
        };
        let (fits, expected) = match function {
            Function::Min | Function::Max => (!arguments.is_empty(), "one argument or more"),
            Function::LogLikelihood => (arguments.len() == 3, "a value, a mean and a standard deviation"),
            _ => (arguments.len() == 1, "one argument"),
        };
        if !fits {
            return self.say(codes::wrong_arity(span, &name.text, expected, arguments.len()));
        }
        let checked: Vec<(Formula, Dimension)> = checked.into_iter().collect::<Option<_>>()?;
        let dimension = checked[0].1;
        if let Some(other) = checked.iter().position(|(_, d)| *d != dimension) {
            let second = checked[other].1;
            return self.say(codes::mixed_dimensions(arguments[0].span, dimension, arguments[other].span, second));
        }
        if matches!(function, Function::Exp | Function::Sqrt) && dimension != Dimension::RATIO {
            return self.say(codes::wrong_unit(arguments[0].span, Dimension::RATIO, dimension));
        }
        let dimension = if *function == Function::LogLikelihood { Dimension::RATIO } else { dimension };
        let formulas: Vec<Formula> = checked.into_iter().map(|(formula, _)| formula).collect();
        if *function == Function::LogLikelihood && constant(&formulas[2]).is_some_and(|deviation| deviation <= 0.0) {
            return self.say(codes::not_finite(arguments[2].span, "a standard deviation is above 0"));
        }
        let formula = self.finite(Formula::Call(*function, formulas.into()), span)?;
        Some((formula, Sort::Quantity(dimension)))
    }
}

/// Most nodes of a formula that are looked at to see whether it is constant: every part of a formula is asked, and it may be long.
const MOST_NODES: u32 = 32;

/// The value of a small formula without variables.
fn constant(formula: &Formula) -> Option<f64> {
    fn stands(formula: &Formula, left: &mut u32) -> bool {
        if *left == 0 {
            return false;
        }
        *left -= 1;
        match formula {
            Formula::Constant(_) => true,
            Formula::Variable(_) => false,
            Formula::Negate(inner) | Formula::Not(inner) => stands(inner, left),
            Formula::Binary(_, a, b) => stands(a, left) && stands(b, left),
            Formula::Call(_, arguments) => arguments.iter().all(|argument| stands(argument, left)),
        }
    }
    stands(formula, &mut MOST_NODES.clone()).then(|| formula.evaluate(&|_| f64::NAN))
}

fn binary(operator: BinaryOperator, left: Formula, right: Formula) -> Formula {
    Formula::Binary(operator, left.into(), right.into())
}
