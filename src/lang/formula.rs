//! Checks formulas: names, arity, dimensions.

use super::ast::{Expression, ExpressionKind, Known, Name};
use super::diagnostics;
use super::names::Names;
use super::temporal::is_temporal;
use base::diagnostic::{Diagnostic, Span};
use base::signature::{ActorSignal, BinaryOperator, Bounds, DeclarationId, Formula, Function, VariableId, Vocabulary};
use base::units::{Dimension, UNIT_NAMES, Unit, UnitError, parse_unit};

/// The type of a formula's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
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
    /// The visible names, for suggestions: a word that is not a variable may be a parameter.
    pub names: &'a Names<'a>,
    /// Whether every part must have a value, for all values of the variables within their bounds.
    pub whole: bool,
}

/// The names of the functions that formulas may call, and their values.
pub fn functions() -> impl Iterator<Item = (&'static str, &'static str)> {
    FUNCTIONS.iter().map(|(name, _, doc)| (*name, *doc)).chain([(
        ROBUSTNESS,
        "robustness(slow_pass), in a reward: the robustness of a requirement over the episode up to now, as a plain number from -100 to 100.",
    )])
}

const FUNCTIONS: &[(&str, Function, &str)] = &[
    ("min", Function::Min, "The minimum of two or more quantities, or of a signal over a group: min(crowd.gap)."),
    ("max", Function::Max, "The maximum of two or more quantities, or of a signal over a group."),
    ("abs", Function::Abs, "The size of a quantity, without its sign."),
    ("exp", Function::Exp, "The exponential of a plain number."),
    ("sqrt", Function::Sqrt, "The square root of a number, which must not be below 0; of an area a length."),
    (
        "log_likelihood",
        Function::LogLikelihood,
        "log_likelihood(x, mean, sd): the logarithm of the normal density at x relative to its peak, -((x - mean) / sd)^2 / 2.",
    ),
];

/// The robustness of a requirement, in a reward.
const ROBUSTNESS: &str = "robustness";
/// Its bounds there.
pub(super) const ROBUST: Bounds = (-100.0, 100.0);

/// The declaration of a form with this name; `None` after an error has been reported.
pub(super) fn named(
    word: &str,
    span: Span,
    form: &str,
    names: &Names,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<DeclarationId> {
    let found = names.find(form, word);
    if found.is_none() {
        diagnostics.push(diagnostics::unknown_name(span, form, word, &names.of_form(form).collect::<Vec<_>>()));
    }
    found
}

/// Whether formulas have a function of this name.
pub(super) fn is_function(name: &str) -> bool {
    name == ROBUSTNESS || FUNCTIONS.iter().any(|(known, ..)| *known == name)
}

/// Checks an expression as a formula; `None` after an error has been reported.
pub(super) fn formula(
    expression: &Expression,
    scope: &Scope,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<(Formula, Sort)> {
    let mut checker = Checker { scope, diagnostics, grows: None };
    let part = checker.visit(expression)?;
    if scope.whole && !is_finite(part.bounds) {
        let place = checker.grows.unwrap_or(expression.span);
        return checker.say(diagnostics::maybe_nothing(place, GROWS, HOLD));
    }
    Some((part.formula, part.sort))
}

/// Reads a unit and reports what is wrong with it.
pub(super) fn unit(name: &Name, diagnostics: &mut Vec<Diagnostic>) -> Option<Unit> {
    let names = || -> Vec<&str> { UNIT_NAMES.iter().map(|(name, _)| *name).collect() };
    match parse_unit(&name.text) {
        Ok(unit) => Some(unit),
        Err(UnitError::Unknown { name: part }) => {
            diagnostics.push(diagnostics::unknown_unit(name.span, &name.text, Some(&part), &names()));
            None
        }
        Err(UnitError::BadPower) => {
            diagnostics.push(diagnostics::unknown_unit(name.span, &name.text, None, &names()));
            None
        }
    }
}

/// A part of a formula.
struct Part {
    formula: Formula,
    sort: Sort,
    bounds: Bounds,
}

impl Part {
    fn constant(value: f64, dimension: Dimension) -> Self {
        Self { formula: Formula::Constant(value), sort: Sort::Quantity(dimension), bounds: (value, value) }
    }
}

struct Quantity {
    formula: Formula,
    dimension: Dimension,
    bounds: Bounds,
}

/// The message for a part that may grow without bound, and the advice.
const GROWS: &str = "this may grow beyond all numbers";
const HOLD: &str = "hold what it is made of below some number: `min(…, 100)`";

fn is_finite((low, high): Bounds) -> bool {
    low.is_finite() && high.is_finite()
}

/// The number of this expression, without a unit.
fn plain(expression: &Expression) -> Option<f64> {
    match &expression.kind {
        ExpressionKind::Number { value, unit: None } => Some(*value),
        _ => None,
    }
}

struct Checker<'a> {
    scope: &'a Scope<'a>,
    diagnostics: &'a mut Vec<Diagnostic>,
    /// The first part that may grow without bound.
    grows: Option<Span>,
}

impl Checker<'_> {
    fn say<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.push(diagnostic);
        None
    }

    fn visit(&mut self, expression: &Expression) -> Option<Part> {
        let span = expression.span;
        match &expression.kind {
            ExpressionKind::Number { value, unit: None } => Some(Part::constant(*value, Dimension::RATIO)),
            ExpressionKind::Number { value, unit: Some(name) } => {
                let unit = unit(name, self.diagnostics)?;
                Some(Part::constant(value * unit.factor, unit.dimension))
            }
            ExpressionKind::Name(word) => self.variable(word, span),
            ExpressionKind::Known(Known::Quantity(value, dimension)) => Some(Part::constant(*value, *dimension)),
            ExpressionKind::Known(Known::Wrong) => None,
            ExpressionKind::Known(Known::Distribution(..)) => {
                self.say(diagnostics::not_a(span, "formula", "distribution"))
            }
            ExpressionKind::Known(Known::Declaration(form, _)) => self.say(diagnostics::not_a(span, "formula", form)),
            ExpressionKind::Group(members) if members.len() == 1 => self.visit(&members[0]),
            ExpressionKind::Negate(inner) => {
                let Quantity { formula, dimension, bounds: (low, high) } = self.quantity(inner)?;
                let formula = Formula::Negate(formula.into());
                Some(Part { formula, sort: Sort::Quantity(dimension), bounds: (-high, -low) })
            }
            ExpressionKind::Not(inner) => {
                let formula = Formula::Not(self.truth(inner)?.formula.into());
                Some(Part { formula, sort: Sort::Truth, bounds: (0.0, 1.0) })
            }
            ExpressionKind::Conversion(inner, name) => {
                let converted = self.quantity(inner);
                let unit = unit(name, self.diagnostics)?;
                let converted = converted?;
                if converted.dimension != unit.dimension {
                    return self.say(diagnostics::wrong_count(
                        name.span,
                        unit.dimension,
                        inner.span,
                        converted.dimension,
                    ));
                }
                let factor = Part::constant(unit.factor, unit.dimension);
                let bounds = BinaryOperator::Divide.bounds(converted.bounds, factor.bounds);
                let formula = Formula::Binary(BinaryOperator::Divide, converted.formula.into(), factor.formula.into());
                Some(Part { formula, sort: Sort::Quantity(Dimension::RATIO), bounds })
            }
            ExpressionKind::Binary { operator, left, right } => self.binary(*operator, left, right, span),
            ExpressionKind::Call { function, arguments, .. } => self.call(function, arguments, span),
            ExpressionKind::Text(_) => self.say(diagnostics::not_a(span, "formula", "text")),
            ExpressionKind::Range(..) => self.say(diagnostics::not_a(span, "formula", "range")),
            ExpressionKind::Group(_) => self.say(diagnostics::not_a(span, "formula", "tuple")),
            ExpressionKind::List(_) => self.say(diagnostics::not_a(span, "formula", "list")),
            ExpressionKind::Inline { .. } => self.say(diagnostics::not_a(span, "formula", "declaration")),
        }
    }

    fn quantity(&mut self, expression: &Expression) -> Option<Quantity> {
        let Part { formula, sort, bounds } = self.visit(expression)?;
        match sort {
            Sort::Quantity(dimension) => Some(Quantity { formula, dimension, bounds }),
            Sort::Truth => self.say(diagnostics::not_a(expression.span, "quantity", "condition")),
        }
    }

    fn truth(&mut self, expression: &Expression) -> Option<Part> {
        let part = self.visit(expression)?;
        match part.sort {
            Sort::Truth => Some(part),
            Sort::Quantity(dimension) => {
                self.say(diagnostics::not_a(expression.span, "condition", &dimension.to_string()))
            }
        }
    }

    fn variable(&mut self, word: &str, span: Span) -> Option<Part> {
        if word == "true" || word == "false" {
            let value = f64::from(word == "true");
            return Some(Part { formula: Formula::Constant(value), sort: Sort::Truth, bounds: (value, value) });
        }
        let scope = self.scope;
        match scope.vocabulary.variables.iter().position(|variable| variable.name == word) {
            None if scope.names.may_be_unread(word, scope.available.iter().copied()) => None,
            None => {
                let known: Vec<&str> = scope.available.iter().copied().chain(scope.names.params()).collect();
                self.say(diagnostics::unknown_variable(span, word, &known))
            }
            Some(_) if !scope.available.contains(&word) => {
                self.say(diagnostics::unavailable_variable(span, word, scope.event, scope.available))
            }
            Some(index) => {
                let variable = &scope.vocabulary.variables[index];
                let quantity = Sort::Quantity(variable.dimension);
                let sort = if variable.is_condition { Sort::Truth } else { quantity };
                let formula = Formula::Variable(VariableId(index));
                Some(Part { formula, sort, bounds: variable.bounds })
            }
        }
    }

    fn binary(&mut self, operator: BinaryOperator, left: &Expression, right: &Expression, span: Span) -> Option<Part> {
        use BinaryOperator::{Add, And, Divide, Implies, Multiply, Or, Subtract};
        if matches!(operator, And | Or | Implies) {
            let (a, b) = (self.truth(left), self.truth(right));
            let formula = Formula::Binary(operator, a?.formula.into(), b?.formula.into());
            return Some(Part { formula, sort: Sort::Truth, bounds: (0.0, 1.0) });
        }
        let compares = BinaryOperator::compares;
        if let ExpressionKind::Binary { operator: before, right: middle, .. } = &left.kind
            && compares(operator)
            && compares(*before)
        {
            return self.say(diagnostics::chained(span, middle.span));
        }
        let (a, b) = (self.quantity(left), self.quantity(right));
        let (a, b) = (a?, b?);
        let sort = match operator {
            Multiply | Divide => {
                let dimension = match operator {
                    Multiply => a.dimension.times(b.dimension),
                    _ => a.dimension.over(b.dimension),
                };
                match dimension {
                    Some(dimension) => Sort::Quantity(dimension),
                    None => {
                        return self.say(diagnostics::syntax(span, "the power of a unit grows beyond reason".into()));
                    }
                }
            }
            _ => {
                self.of_one_dimension(operator, (left, a.dimension), (right, b.dimension))?;
                if compares(operator) { Sort::Truth } else { Sort::Quantity(a.dimension) }
            }
        };
        if operator == Divide {
            self.away_from_zero(right.span, &b)?;
        }
        let bounds = operator.bounds_between(&a.formula, a.bounds, &b.formula, b.bounds);
        let zero = |(low, high): Bounds| low <= 0.0 && high >= 0.0;
        // Infinity minus infinity, infinity over infinity, and infinity times 0 are not numbers.
        let lost = match operator {
            Add | Subtract | Divide => !is_finite(a.bounds) && !is_finite(b.bounds),
            Multiply => !is_finite(a.bounds) && zero(b.bounds) || !is_finite(b.bounds) && zero(a.bounds),
            _ => false,
        };
        let formula = Formula::Binary(operator, a.formula.into(), b.formula.into());
        self.counted(Part { formula, sort, bounds }, lost, span)
    }

    /// Checks that two operands have the same dimension.
    fn of_one_dimension(
        &mut self,
        operator: BinaryOperator,
        (left, a): (&Expression, Dimension),
        (right, b): (&Expression, Dimension),
    ) -> Option<()> {
        if a == b {
            return Some(());
        }
        // A number without a unit most likely lacks it in a comparison; rewards use the plain numbers of quantities on purpose.
        let may_lack = operator.compares() || !self.scope.whole;
        match (plain(left), plain(right)) {
            (Some(number), _) if may_lack && a == Dimension::RATIO => {
                self.say(diagnostics::bare_number(left.span, b, &number.to_string(), right.span))
            }
            (_, Some(number)) if may_lack && b == Dimension::RATIO => {
                self.say(diagnostics::bare_number(right.span, a, &number.to_string(), left.span))
            }
            _ => self.say(diagnostics::mixed_dimensions(left.span, a, right.span, b)),
        }
    }

    /// Checks that a divisor is not 0.
    fn away_from_zero(&mut self, span: Span, divisor: &Quantity) -> Option<()> {
        match divisor.bounds {
            (0.0, 0.0) => self.say(diagnostics::not_finite(span, "nothing can be divided by 0")),
            (low, high) if self.scope.whole && low <= 0.0 && high >= 0.0 => {
                let unit = divisor.dimension.usual_units().first().map_or(String::new(), |unit| format!(" {unit}"));
                let inner = if low == 0.0 { "…" } else { "abs(…)" };
                let help = format!("keep it above 0: `max({inner}, 0.1{unit})`");
                self.say(diagnostics::maybe_nothing(span, "this may be 0", &help))
            }
            _ => Some(()),
        }
    }

    /// Returns a part of a formula. `None` if it is not a number, or if it must be one and may fail to be (`lost`). A part that may
    /// grow without bound is remembered, since the whole may still have a value.
    fn counted(&mut self, part: Part, lost: bool, span: Span) -> Option<Part> {
        let (low, high) = part.bounds;
        if low == high && !low.is_finite() {
            return self.say(diagnostics::not_finite(span, "this is not a finite number"));
        }
        if !is_finite(part.bounds) {
            self.grows.get_or_insert(span);
        }
        if self.scope.whole && lost {
            let place = self.grows.unwrap_or(span);
            return self.say(diagnostics::maybe_nothing(place, GROWS, HOLD));
        }
        Some(part)
    }

    /// `robustness(slow_pass)`
    fn robustness(&mut self, name: &Name, arguments: &[Expression], span: Span) -> Option<Part> {
        if !self.scope.whole || self.scope.event == "tick" {
            return self.say(diagnostics::robustness_outside(name.span));
        }
        let [requirement] = arguments else {
            return self.say(diagnostics::wrong_arity(span, ROBUSTNESS, "the name of a requirement", arguments.len()));
        };
        let id = match &requirement.kind {
            ExpressionKind::Known(Known::Declaration("requirement", id)) => *id,
            ExpressionKind::Name(word) => {
                named(word, requirement.span, "requirement", self.scope.names, self.diagnostics)?
            }
            _ => return self.say(diagnostics::not_a(requirement.span, "name of a requirement", "value")),
        };
        let formula = Formula::Variable(VariableId(self.scope.vocabulary.variables.len() + id.0));
        Some(Part { formula, sort: Sort::Quantity(Dimension::RATIO), bounds: ROBUST })
    }

    /// `child.gap`, `gap(child, van)`
    fn signal(&mut self, name: &Name, signal: usize, arguments: &[Expression], span: Span) -> Option<Part> {
        if self.scope.event != "tick" {
            return self.say(diagnostics::role_outside(span));
        }
        if !(1..=2).contains(&arguments.len()) {
            return self.say(diagnostics::wrong_arity(span, &name.text, "one role or two", arguments.len()));
        }
        let roles: Vec<Option<usize>> = arguments.iter().map(|argument| self.role(argument)).collect();
        let roles = roles.into_iter().collect::<Option<Vec<usize>>>()?;
        let id = ActorSignal { of: roles[0], to: roles.get(1).copied().unwrap_or(0), signal };
        if id.of == 0 && id.to == 0 && name.text != "speed" {
            return self.say(diagnostics::not_a(span, "signal of two different roles", "signal of the ego to itself"));
        }
        let variable = &self.scope.vocabulary.signals[signal];
        let quantity = Sort::Quantity(variable.dimension);
        let sort = if variable.is_condition { Sort::Truth } else { quantity };
        Some(Part { formula: Formula::Variable(id.into()), sort, bounds: variable.bounds })
    }

    /// The number of a role: 0 for the car under test, and otherwise that of its declaration, from 1.
    fn role(&mut self, expression: &Expression) -> Option<usize> {
        match &expression.kind {
            ExpressionKind::Name(word) if word == "ego" => Some(0),
            ExpressionKind::Name(word) => {
                named(word, expression.span, "role", self.scope.names, self.diagnostics).map(|id| id.0 + 1)
            }
            _ => self.say(diagnostics::not_a(expression.span, "name of a role", "value")),
        }
    }

    fn call(&mut self, name: &Name, arguments: &[Expression], span: Span) -> Option<Part> {
        if is_temporal(&name.text) {
            return self.say(diagnostics::temporal_in_formula(name.span, &name.text));
        }
        if name.text == ROBUSTNESS {
            return self.robustness(name, arguments, span);
        }
        if let Some(signal) = self.scope.vocabulary.signals.iter().position(|signal| signal.name == name.text) {
            return self.signal(name, signal, arguments, span);
        }
        let known: Vec<&str> = FUNCTIONS.iter().map(|(name, ..)| *name).chain([ROBUSTNESS]).collect();
        let Some((_, function, _)) = FUNCTIONS.iter().find(|(known, ..)| *known == name.text) else {
            return self.say(diagnostics::unknown_function(name.span, &name.text, &known));
        };
        let checked: Vec<Option<Quantity>> = arguments.iter().map(|each| self.quantity(each)).collect();
        let (fits, expected) = match function {
            // One signal of a group has a value for each of its members.
            Function::Min | Function::Max => {
                let is_signal =
                    |each: &Quantity| matches!(each.formula, Formula::Variable(id) if id.of_actor().is_some());
                let is_group = checked.iter().flatten().any(is_signal);
                (arguments.len() > 1 || is_group, "two arguments or more, or a signal of a group")
            }
            Function::LogLikelihood => (arguments.len() == 3, "a value, a mean and a standard deviation"),
            _ => (arguments.len() == 1, "one argument"),
        };
        if !fits {
            return self.say(diagnostics::wrong_arity(span, &name.text, expected, arguments.len()));
        }
        let checked: Vec<Quantity> = checked.into_iter().collect::<Option<_>>()?;
        let dimension = checked[0].dimension;
        if let Some(other) = checked.iter().position(|each| each.dimension != dimension) {
            let (first, second) = (arguments[0].span, arguments[other].span);
            return self.say(diagnostics::mixed_dimensions(first, dimension, second, checked[other].dimension));
        }
        let given = match function {
            Function::Exp if dimension != Dimension::RATIO => None,
            Function::Sqrt => dimension.root(),
            Function::LogLikelihood => Some(Dimension::RATIO),
            _ => Some(dimension),
        };
        let Some(given) = given else { return self.say(diagnostics::uncounted(arguments[0].span, dimension)) };
        self.within_domain(*function, arguments, &checked, span)?;
        let bounds: Vec<Bounds> = checked.iter().map(|each| each.bounds).collect();
        let formulas: Vec<Formula> = checked.into_iter().map(|each| each.formula).collect();
        let lost = *function == Function::LogLikelihood && !bounds.iter().all(|each| is_finite(*each));
        let (formula, bounds) = (Formula::Call(*function, formulas.into()), function.bounds(&bounds));
        self.counted(Part { formula, sort: Sort::Quantity(given), bounds }, lost, span)
    }

    /// Checks that a function has a value for all values of its arguments.
    fn within_domain(
        &mut self,
        function: Function,
        arguments: &[Expression],
        checked: &[Quantity],
        span: Span,
    ) -> Option<()> {
        match function {
            Function::Sqrt => {
                let (low, high) = checked[0].bounds;
                if high < 0.0 {
                    return self.say(diagnostics::not_finite(span, "no number below 0 has a square root"));
                }
                if self.scope.whole && low < 0.0 {
                    let zero = if checked[0].dimension == Dimension::RATIO { "0" } else { "0 * …" };
                    let help = format!("keep it at or above 0: `max(…, {zero})`");
                    return self.say(diagnostics::maybe_nothing(arguments[0].span, "this may be below 0", &help));
                }
            }
            Function::LogLikelihood => {
                let deviation = &checked[2];
                if deviation.bounds.1 <= 0.0 {
                    return self.say(diagnostics::not_finite(arguments[2].span, "a standard deviation is above 0"));
                }
                self.away_from_zero(arguments[2].span, deviation)?;
            }
            _ => {}
        }
        Some(())
    }
}
