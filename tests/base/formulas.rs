//! Values of formulas, and the bounds that hold them.

use base::signature::{BinaryOperator, Formula, Function, VariableId};
use proptest::prelude::*;

#[test]
fn the_papers_r2_for_a_frontal_hit() {
    let v_c = Formula::Variable(VariableId(0));
    let product = Formula::Binary(BinaryOperator::Multiply, Formula::Constant(1.5).into(), v_c.into());
    let r2 = Formula::Call(Function::Max, [Formula::Constant(3.0), product].into());
    assert_eq!(r2.evaluate(&|_| 1.0), 3.0);
    assert_eq!(r2.evaluate(&|_| 10.0), 15.0);
}

#[test]
fn a_likelihood_is_that_of_the_normal_relative_to_its_peak() {
    let arguments = [5.0, 2.0, 1.5].map(Formula::Constant).to_vec();
    let density = |x: f64| libm::exp(-0.5 * ((x - 2.0) / 1.5) * ((x - 2.0) / 1.5));
    let found = Formula::Call(Function::LogLikelihood, arguments.into()).evaluate(&|_| 0.0);
    assert!((found - libm::log(density(5.0) / density(2.0))).abs() < 1e-12);
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

fn any_formula() -> impl Strategy<Value = Formula> {
    let leaf = prop_oneof![
        (-5.0..5.0).prop_map(Formula::Constant),
        (0_usize..3).prop_map(|index| Formula::Variable(VariableId(index))),
    ];
    leaf.prop_recursive(4, 24, 3, |inner| {
        use BinaryOperator::{Add, Divide, Greater, GreaterEqual, Less, LessEqual, Multiply, Or, Subtract};
        let operator = prop::sample::select(vec![
            Add,
            Subtract,
            Multiply,
            Divide,
            Less,
            LessEqual,
            Greater,
            GreaterEqual,
            BinaryOperator::And,
            Or,
            BinaryOperator::Implies,
        ]);
        let operator_of_same = prop::sample::select(vec![Multiply, Divide, Subtract, Less]);
        let function = prop::sample::select(vec![
            Function::Min,
            Function::Max,
            Function::Abs,
            Function::Exp,
            Function::Sqrt,
            Function::LogLikelihood,
        ]);
        prop_oneof![
            (operator, inner.clone(), inner.clone()).prop_map(|(o, a, b)| Formula::Binary(o, a.into(), b.into())),
            inner.clone().prop_map(|a| Formula::Negate(a.into())),
            inner.clone().prop_map(|a| Formula::Not(a.into())),
            // The same on both sides, or the same with the other sign.
            inner
                .clone()
                .prop_map(|a| { Formula::Binary(Multiply, Formula::Negate(a.clone().into()).into(), a.into()) }),
            (operator_of_same, inner.clone()).prop_map(|(o, a)| Formula::Binary(o, a.clone().into(), a.into())),
            (function, prop::collection::vec(inner, 3)).prop_map(|(f, arguments)| Formula::Call(f, arguments.into())),
        ]
    })
}

/// Whether each part of a formula has a value, as the language demands: a comparison with a root of a negative number is neither true nor false.
fn is_number(formula: &Formula, values: &impl Fn(VariableId) -> f64) -> bool {
    let of = |part: &Formula| is_number(part, values);
    let parts = match formula {
        Formula::Constant(_) | Formula::Variable(_) => true,
        Formula::Negate(inner) | Formula::Not(inner) => of(inner),
        Formula::Binary(_, left, right) => of(left) && of(right),
        Formula::Call(_, arguments) => arguments.iter().all(of),
    };
    parts && !formula.evaluate(values).is_nan()
}

proptest! {
    #[test]
    fn no_value_lies_outside_its_bounds(
        formula in any_formula(),
        ends in prop::array::uniform3((-4.0..4.0, 0.0..3.0)),
        shares in prop::array::uniform3(0.0..=1.0),
    ) {
        let value = formula.evaluate(&|id: VariableId| ends[id.0].0 + shares[id.0] * ends[id.0].1);
        let (low, high) = formula.bounds(&|id: VariableId| (ends[id.0].0, ends[id.0].0 + ends[id.0].1));
        let values = |id: VariableId| ends[id.0].0 + shares[id.0] * ends[id.0].1;
        prop_assume!(is_number(&formula, &values) && !low.is_nan() && !high.is_nan());
        // An infinite value allows no slack.
        let slack = if value.is_finite() { 1e-9 * (1.0 + value.abs()) } else { 0.0 };
        prop_assert!(low <= value + slack && value <= high + slack, "{value} in {low} .. {high}");
    }
}
