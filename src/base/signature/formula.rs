use std::sync::Arc;

/// An index into the variables of a [`Vocabulary`](super::Vocabulary).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VariableId(pub usize);

/// A signal of one actor towards another one, as a variable of formulas. In a checked program the actors are roles; in a scenario they are
/// numbers of its cast.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActorSignal {
    /// The actor, from 0: the car under test is number 0, and others follow.
    pub of: usize,
    /// The actor towards which it is measured.
    pub to: usize,
    /// Its place among the signals of the [`Vocabulary`](super::Vocabulary).
    pub signal: usize,
}

/// The bit that tells a signal of an actor from other variables, the bits of an actor's number and those of a signal.
const OF_ACTOR: usize = 1 << 62;
const ACTOR_BITS: usize = 24;
const SIGNAL_BITS: usize = 8;

impl From<ActorSignal> for VariableId {
    fn from(ActorSignal { of, to, signal }: ActorSignal) -> Self {
        Self(OF_ACTOR | (of << ACTOR_BITS | to) << SIGNAL_BITS | signal)
    }
}

impl VariableId {
    /// The signal of an actor that it is; `None` for another variable.
    pub fn of_actor(self) -> Option<ActorSignal> {
        let (bits, low) = (self.0 & !OF_ACTOR, |value: usize, bits: usize| value & ((1 << bits) - 1));
        let actors = bits >> SIGNAL_BITS;
        let found =
            ActorSignal { of: actors >> ACTOR_BITS, to: low(actors, ACTOR_BITS), signal: low(bits, SIGNAL_BITS) };
        (self.0 & OF_ACTOR != 0).then_some(found)
    }
}

/// An operator between two formulas; comparisons and logic give 1 or 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BinaryOperator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `and`
    And,
    /// `or`
    Or,
    /// `implies`
    Implies,
}

/// A function of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// The minimum of two or more.
    Min,
    /// The maximum of two or more.
    Max,
    /// The absolute value of one.
    Abs,
    /// The exponential of one plain number.
    Exp,
    /// The square root of one plain number; of a negative number it is NaN, which stops a run.
    Sqrt,
    /// The logarithm of the normal density at the first, with the second as mean and the third as standard deviation,
    /// relative to its maximum value: −((x − mean) / sd)² / 2.
    LogLikelihood,
}

/// A checked formula: dimensions agree, names are resolved, every constant is in SI. A copy shares its parts.
#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
    /// A constant in SI; 1 and 0 for true and false.
    Constant(f64),
    /// A variable's value.
    Variable(VariableId),
    Negate(Arc<Formula>),
    /// Logical not.
    Not(Arc<Formula>),
    /// An operator between two.
    Binary(BinaryOperator, Arc<Formula>, Arc<Formula>),
    Call(Function, Arc<[Formula]>),
}

impl Formula {
    /// The value for given values of the variables, which are looked up by their index. Logic is 1 or 0.
    pub fn evaluate(&self, values: &impl Fn(VariableId) -> f64) -> f64 {
        let truth = |condition: bool| if condition { 1.0 } else { 0.0 };
        match self {
            Formula::Constant(value) => *value,
            Formula::Variable(id) => values(*id),
            Formula::Negate(inner) => -inner.evaluate(values),
            Formula::Not(inner) => truth(inner.evaluate(values) == 0.0),
            Formula::Binary(operator, left, right) => {
                let (a, b) = (left.evaluate(values), right.evaluate(values));
                match operator {
                    BinaryOperator::Add => a + b,
                    BinaryOperator::Subtract => a - b,
                    BinaryOperator::Multiply => a * b,
                    BinaryOperator::Divide => a / b,
                    BinaryOperator::Less => truth(a < b),
                    BinaryOperator::LessEqual => truth(a <= b),
                    BinaryOperator::Greater => truth(a > b),
                    BinaryOperator::GreaterEqual => truth(a >= b),
                    BinaryOperator::And => truth(a != 0.0 && b != 0.0),
                    BinaryOperator::Or => truth(a != 0.0 || b != 0.0),
                    BinaryOperator::Implies => truth(a == 0.0 || b != 0.0),
                }
            }
            Formula::Call(function, arguments) => {
                let mut values = arguments.iter().map(|argument| argument.evaluate(values));
                let first = values.next().expect("checked: every function has an argument");
                match function {
                    Function::Min => {
                        values.fold(first, |least, value| if value.is_nan() || value < least { value } else { least })
                    }
                    Function::Max => {
                        values.fold(first, |most, value| if value.is_nan() || value > most { value } else { most })
                    }
                    Function::Abs => first.abs(),
                    Function::Exp => libm::exp(first),
                    Function::Sqrt => first.sqrt(),
                    Function::LogLikelihood => {
                        let mut next = || values.next().expect("checked: the function has three arguments");
                        let z = (first - next()) / next();
                        -0.5 * z * z
                    }
                }
            }
        }
    }
}

impl Formula {
    /// Whether it contains a variable that satisfies a condition.
    pub fn mentions(&self, wanted: &impl Fn(VariableId) -> bool) -> bool {
        match self {
            Formula::Constant(_) => false,
            Formula::Variable(id) => wanted(*id),
            Formula::Negate(inner) | Formula::Not(inner) => inner.mentions(wanted),
            Formula::Binary(_, left, right) => left.mentions(wanted) || right.mentions(wanted),
            Formula::Call(_, arguments) => arguments.iter().any(|argument| argument.mentions(wanted)),
        }
    }
}

impl Formula {
    /// The same with other variables. A variable for which there are several takes their place among the arguments of a function; elsewhere the first
    /// of them counts.
    pub fn substituted(&self, with: &mut impl FnMut(VariableId) -> Vec<VariableId>) -> Self {
        match self {
            Formula::Constant(value) => Formula::Constant(*value),
            Formula::Variable(id) => Formula::Variable(with(*id).first().copied().unwrap_or(*id)),
            Formula::Negate(inner) => Formula::Negate(inner.substituted(with).into()),
            Formula::Not(inner) => Formula::Not(inner.substituted(with).into()),
            Formula::Binary(operator, left, right) => {
                Formula::Binary(*operator, left.substituted(with).into(), right.substituted(with).into())
            }
            Formula::Call(function, arguments) => {
                let mut all = Vec::new();
                for argument in arguments.iter() {
                    match argument {
                        Formula::Variable(id) => all.extend(with(*id).into_iter().map(Formula::Variable)),
                        other => all.push(other.substituted(with)),
                    }
                }
                Formula::Call(*function, all.into())
            }
        }
    }
}

/// Bounds of a value: its minimum and maximum.
pub type Bounds = (f64, f64);

/// No bounds.
const ANY: Bounds = (f64::NEG_INFINITY, f64::INFINITY);

/// The bounds of a condition that is always or never true.
fn truth(always: bool, never: bool) -> Bounds {
    match (always, never) {
        (true, _) => (1.0, 1.0),
        (_, true) => (0.0, 0.0),
        _ => (0.0, 1.0),
    }
}

impl BinaryOperator {
    /// Whether it is `<`, `<=`, `>` or `>=`.
    pub fn compares(self) -> bool {
        matches!(self, Self::Less | Self::LessEqual | Self::Greater | Self::GreaterEqual)
    }

    /// Bounds of the result for two values within bounds.
    pub fn bounds(self, (a, b): Bounds, (c, d): Bounds) -> Bounds {
        let found = match self {
            BinaryOperator::Add => (a + c, b + d),
            BinaryOperator::Subtract => (a - d, b - c),
            BinaryOperator::Multiply => hull([a * c, a * d, b * c, b * d]),
            BinaryOperator::Divide if c > 0.0 || d < 0.0 => hull([a / c, a / d, b / c, b / d]),
            BinaryOperator::Divide => ANY,
            BinaryOperator::Less => truth(b < c, a >= d),
            BinaryOperator::LessEqual => truth(b <= c, a > d),
            BinaryOperator::Greater => truth(a > d, b <= c),
            BinaryOperator::GreaterEqual => truth(a >= d, b < c),
            BinaryOperator::And => truth(a > 0.0 && c > 0.0, (a == 0.0 && b == 0.0) || (c == 0.0 && d == 0.0)),
            BinaryOperator::Or => truth(a > 0.0 || c > 0.0, a == 0.0 && b == 0.0 && c == 0.0 && d == 0.0),
            BinaryOperator::Implies => {
                BinaryOperator::Or.bounds(truth(a == 0.0 && b == 0.0, a > 0.0 || b < 0.0), (c, d))
            }
        };
        if found.0.is_nan() || found.1.is_nan() { ANY } else { found }
    }

    /// Bounds of the result for two formulas whose values lie within bounds. They are narrower if both are the same, or if one is a
    /// multiple of the other.
    pub fn bounds_between(self, left: &Formula, a: Bounds, right: &Formula, b: Bounds) -> Bounds {
        if left == right {
            return self.bounds_of_same(a);
        }
        let ((one, first), (other, second)) = (left.scaled(), right.scaled());
        let ratio = other / one;
        if self == BinaryOperator::Multiply && first == second && ratio.is_finite() && ratio != 0.0 {
            let (low, high) = self.bounds_of_same(a);
            return hull([ratio * low, ratio * high, ratio * low, ratio * high]);
        }
        self.bounds(a, b)
    }

    /// Bounds of the result for a value within bounds and the same value again.
    fn bounds_of_same(self, bounds: Bounds) -> Bounds {
        let (low, high) = bounds;
        let finite = low.is_finite() && high.is_finite();
        match self {
            BinaryOperator::Subtract if finite => (0.0, 0.0),
            BinaryOperator::Divide if finite && (low > 0.0 || high < 0.0) => (1.0, 1.0),
            BinaryOperator::Multiply => {
                let (near, far) = Function::Abs.bounds(&[bounds]);
                (near * near, far * far)
            }
            _ => self.bounds(bounds, bounds),
        }
    }
}

impl Function {
    /// Bounds of the result for values within bounds.
    ///
    /// # Panics
    /// There are fewer values than the function has arguments.
    pub fn bounds(self, values: &[Bounds]) -> Bounds {
        let (low, high) = values[0];
        match self {
            Function::Min => values[1..].iter().fold((low, high), |(a, b), (c, d)| (a.min(*c), b.min(*d))),
            Function::Max => values[1..].iter().fold((low, high), |(a, b), (c, d)| (a.max(*c), b.max(*d))),
            Function::Abs if low >= 0.0 => (low, high),
            Function::Abs if high <= 0.0 => (-high, -low),
            Function::Abs => (0.0, high.max(-low)),
            Function::Exp => (libm::exp(low), libm::exp(high)),
            // A negative number has none.
            Function::Sqrt if low < 0.0 => ANY,
            Function::Sqrt => (low.sqrt(), high.sqrt()),
            Function::LogLikelihood => {
                let apart = BinaryOperator::Subtract.bounds(values[0], values[1]);
                let (near, far) = Function::Abs.bounds(&[BinaryOperator::Divide.bounds(apart, values[2])]);
                (-0.5 * far * far, -0.5 * near * near)
            }
        }
    }
}

impl Formula {
    /// A factor and the formula that it multiplies.
    fn scaled(&self) -> (f64, &Self) {
        match self {
            Formula::Negate(inner) => {
                let (factor, rest) = inner.scaled();
                (-factor, rest)
            }
            Formula::Binary(operator, left, right) => match (operator, &**left, &**right) {
                (BinaryOperator::Multiply, Formula::Constant(number), rest)
                | (BinaryOperator::Multiply, rest, Formula::Constant(number)) => {
                    let (factor, rest) = rest.scaled();
                    (factor * number, rest)
                }
                (BinaryOperator::Divide, rest, Formula::Constant(number)) => {
                    let (factor, rest) = rest.scaled();
                    (factor / number, rest)
                }
                _ => (1.0, self),
            },
            _ => (1.0, self),
        }
    }

    /// Bounds of the value when the variables lie within bounds. The value is never outside, but the bounds may be too wide.
    /// A condition with an upper bound of 0 is never true; one with a lower bound of 1 is always true.
    pub fn bounds(&self, values: &impl Fn(VariableId) -> Bounds) -> Bounds {
        match self {
            Formula::Constant(value) => (*value, *value),
            Formula::Variable(id) => values(*id),
            Formula::Negate(inner) => {
                let (low, high) = inner.bounds(values);
                (-high, -low)
            }
            Formula::Not(inner) => {
                let (low, high) = inner.bounds(values);
                truth(low == 0.0 && high == 0.0, low > 0.0 || high < 0.0)
            }
            Formula::Binary(operator, left, right) => {
                operator.bounds_between(left, left.bounds(values), right, right.bounds(values))
            }
            Formula::Call(function, arguments) => {
                let bounds: Vec<Bounds> = arguments.iter().map(|argument| argument.bounds(values)).collect();
                function.bounds(&bounds)
            }
        }
    }
}

/// The bounds of some numbers; infinity times 0 gives no bounds.
fn hull(corners: [f64; 4]) -> Bounds {
    if corners.iter().any(|corner| corner.is_nan()) {
        return ANY;
    }
    let low = corners.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    (low, corners.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b)))
}
