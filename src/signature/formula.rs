/// An index into the variables of a [`Vocabulary`](super::Vocabulary).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VariableId(pub usize);

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
}

/// A function of formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// The least of one or more.
    Min,
    /// The greatest of one or more.
    Max,
    /// The absolute value of one.
    Abs,
    /// The exponential of one plain number.
    Exp,
    /// The square root of one plain number; 0 below zero.
    Sqrt,
}

/// A checked formula: dimensions agree, names are resolved, every constant is in SI.
#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
    /// A constant in SI; 1 and 0 for true and false.
    Constant(f64),
    /// A variable's value.
    Variable(VariableId),
    /// The negative.
    Negate(Box<Formula>),
    /// Logical not.
    Not(Box<Formula>),
    /// An operator between two.
    Binary(BinaryOperator, Box<Formula>, Box<Formula>),
    /// A function.
    Call(Function, Vec<Formula>),
}

impl Formula {
    /// The value for given values of the variables, which are asked for by their index. Logic is 1 or 0.
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
                }
            }
            Formula::Call(function, arguments) => {
                let mut values = arguments.iter().map(|argument| argument.evaluate(values));
                let first = values.next().expect("checked: every function has an argument");
                match function {
                    Function::Min => values.fold(first, f64::min),
                    Function::Max => values.fold(first, f64::max),
                    Function::Abs => first.abs(),
                    Function::Exp => libm::exp(first),
                    Function::Sqrt => first.max(0.0).sqrt(),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_r2_for_a_frontal_hit() {
        let v_c = Formula::Variable(VariableId(0));
        let product = Formula::Binary(BinaryOperator::Multiply, Formula::Constant(1.5).into(), v_c.into());
        let r2 = Formula::Call(Function::Max, vec![Formula::Constant(3.0), product]);
        assert_eq!(r2.evaluate(&|_| 1.0), 3.0);
        assert_eq!(r2.evaluate(&|_| 10.0), 15.0);
    }

    #[test]
    fn conditions_are_one_or_zero() {
        let formula = Formula::Binary(
            BinaryOperator::Greater,
            Formula::Variable(VariableId(0)).into(),
            Formula::Constant(60.0).into(),
        );
        assert_eq!(formula.evaluate(&|_| 61.0), 1.0);
        assert_eq!(Formula::Not(formula.into()).evaluate(&|_| 61.0), 0.0);
    }
}
