//! The robustness of requirements: that of its definition, of banquo and of rtamt.

use std::sync::Arc;

use banquo::Trace as BanquoTrace;
use banquo::operators::{Always, And, Eventually, Not, Or};
use rand::RngExt;
use serde_json::Value;

use base::seed::{Seed, Stream};
use base::signature::{BinaryOperator, Comparison, Formula, Requirement, Temporal, VariableId, Within};
use base::units::Dimension;
use episode::requirement::{Degree, Trace, ticks_within};

/// Signals of the random traces.
const SIGNALS: usize = 3;
const CONSTANTS: [f64; 4] = [-1.0, 0.0, 0.5, 1.25];

/// `x_index - constant > 0`, or `>= 0`.
fn comparison(index: usize, constant: f64, strict: bool) -> Comparison {
    let variable = Formula::Variable(VariableId(index));
    let margin = Formula::Binary(BinaryOperator::Subtract, variable.into(), Formula::Constant(constant).into());
    Comparison {
        text: format!("x{index} > {constant}"),
        margin,
        strict,
        dimension: Some(Dimension::LENGTH),
        scale: 2.0,
    }
}

/// A random formula; its comparisons are added to the list.
fn random(stream: &mut Stream, depth: u32, parts: &mut Vec<Comparison>) -> Temporal {
    if depth == 0 || stream.random_range(0..7) == 0 {
        let constant = CONSTANTS[stream.random_range(0..CONSTANTS.len())];
        parts.push(comparison(stream.random_range(0..SIGNALS), constant, stream.random()));
        return Temporal::Part(parts.len() - 1);
    }
    let mut inner = || Arc::new(random(stream, depth - 1, parts));
    let (a, b) = (inner(), inner());
    let from = f64::from([0, 0, 1, 2, 5][stream.random_range(0..5)]);
    let width = f64::from([0, 1, 2, 4, 9, 30][stream.random_range(0..6)]);
    let ends = [(from, from + width), (from, f64::INFINITY), (0.0, f64::INFINITY), (1.2, 1.4)];
    let (from, to) = ends[[0, 0, 0, 1, 2, 2, 3][stream.random_range(0..7)]];
    let within = Within { from, to };
    match stream.random_range(0..9) {
        0 => Temporal::Constant(stream.random()),
        1 => Temporal::Not(a),
        2 => Temporal::And(a, b),
        3 => Temporal::Or(a, b),
        4 | 5 => Temporal::Always(within, a),
        6 => Temporal::Eventually(within, a),
        _ => Temporal::Until(within, a, b),
    }
}

/// Samples of which many are equal, so that ties occur.
fn samples(stream: &mut Stream) -> Vec<[f64; SIGNALS]> {
    let count = stream.random_range(1..25);
    let mut value = || match stream.random::<bool>() {
        true => f64::from(stream.random_range(-3..4)),
        false => stream.random_range(-3.0..3.0),
    };
    (0..count).map(|_| std::array::from_fn(|_| value())).collect()
}

fn recorded(requirement: &Requirement, samples: &[[f64; SIGNALS]]) -> Trace {
    let mut trace = Trace::new(requirement, samples.len(), &|_| false);
    samples.iter().for_each(|sample| trace.push(requirement, &|id| sample[id.0]));
    trace
}

/// The definition, word by word, at a sample; ticks are 1 s apart.
fn by_definition(formula: &Temporal, parts: &[Comparison], samples: &[[f64; SIGNALS]], at: usize) -> f64 {
    let value = |formula: &Temporal, at: usize| by_definition(formula, parts, samples, at);
    let least = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(f64::INFINITY, |a, b| if b.total_cmp(&a).is_lt() { b } else { a })
    };
    let most = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(f64::NEG_INFINITY, |a, b| if b.total_cmp(&a).is_gt() { b } else { a })
    };
    let times = |within: &Within| {
        let (from, to) = (within.from, within.to);
        (at..samples.len()).filter(move |time| (from..=to).contains(&((time - at) as f64)))
    };
    match formula {
        Temporal::Constant(truth) => {
            if *truth {
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            }
        }
        Temporal::Part(index) => {
            let part = &parts[*index];
            match part.margin.evaluate(&|id| samples[at][id.0]) {
                0.0 if part.strict => -0.0,
                0.0 => 0.0,
                margin => margin,
            }
        }
        Temporal::Not(inner) => -value(inner, at),
        Temporal::And(a, b) => least(&mut [value(a, at), value(b, at)].into_iter()),
        Temporal::Or(a, b) => most(&mut [value(a, at), value(b, at)].into_iter()),
        Temporal::Always(within, inner) => least(&mut times(within).map(|time| value(inner, time))),
        Temporal::Eventually(within, inner) => most(&mut times(within).map(|time| value(inner, time))),
        Temporal::Until(within, a, b) => most(&mut times(within).map(|time| {
            let before = (at..time).map(|time| value(a, time));
            least(&mut before.chain([value(b, time)]))
        })),
    }
}

/// The truth of the definition, without any robustness.
fn is_true(formula: &Temporal, parts: &[Comparison], samples: &[[f64; SIGNALS]], at: usize) -> bool {
    let truth = |formula: &Temporal, at: usize| is_true(formula, parts, samples, at);
    let mut times = (at..samples.len()).map(|time| (time, (time - at) as f64));
    match formula {
        Temporal::Constant(truth) => *truth,
        Temporal::Part(index) => {
            let part = &parts[*index];
            let margin = part.margin.evaluate(&|id| samples[at][id.0]);
            margin > 0.0 || margin == 0.0 && !part.strict
        }
        Temporal::Not(inner) => !truth(inner, at),
        Temporal::And(a, b) => truth(a, at) && truth(b, at),
        Temporal::Or(a, b) => truth(a, at) || truth(b, at),
        Temporal::Always(within, inner) => {
            times.all(|(time, after)| !(within.from..=within.to).contains(&after) || truth(inner, time))
        }
        Temporal::Eventually(within, inner) => {
            times.any(|(time, after)| (within.from..=within.to).contains(&after) && truth(inner, time))
        }
        Temporal::Until(within, a, b) => times.any(|(time, after)| {
            (within.from..=within.to).contains(&after) && truth(b, time) && (at..time).all(|time| truth(a, time))
        }),
    }
}

/// What banquo's operators give at all samples, without a bound between two ticks; none for `until`, whose left side is taken from the first sample
/// on, up to and including the sample of the right side.
fn by_banquo(formula: &Temporal, parts: &[Comparison], samples: &[[f64; SIGNALS]]) -> Option<BanquoTrace<f64>> {
    let inner = |formula: &Temporal| by_banquo(formula, parts, samples);
    let of = |value: &dyn Fn(usize) -> f64| (0..samples.len()).map(|time| (time as f64, value(time))).collect();
    let bound =
        |within: &Within| (within.from > 0.0 || within.to.is_finite()).then_some(within.from..=within.to.min(1e6));
    Some(match formula {
        Temporal::Constant(truth) => of(&|_| if *truth { f64::INFINITY } else { f64::NEG_INFINITY }),
        Temporal::Part(index) => of(&|time| parts[*index].margin.evaluate(&|id| samples[time][id.0])),
        Temporal::Not(a) => Not::<()>::apply(inner(a)?),
        Temporal::And(a, b) => And::<(), ()>::apply(inner(a)?, inner(b)?).ok()?,
        Temporal::Or(a, b) => Or::<(), ()>::apply(inner(a)?, inner(b)?).ok()?,
        Temporal::Always(within, a) => Always::<()>::apply(bound(within), inner(a)?).ok()?,
        Temporal::Eventually(within, a) => Eventually::<()>::apply(bound(within), inner(a)?).ok()?,
        Temporal::Until(..) => return None,
    })
}

#[test]
fn robustness_is_that_of_the_definition_and_of_banquo() {
    let mut stream = Seed::root(1).child("formulas").stream();
    let (mut compared, mut violated) = (0, 0);
    for number in 0..100_000 {
        let mut parts = Vec::new();
        let depth = stream.random_range(1..5);
        let formula = random(&mut stream, depth, &mut parts);
        let samples = samples(&mut stream);
        let requirement = Requirement { parts, formula };
        let mut trace = recorded(&requirement, &samples);
        if requirement.parts.is_empty() {
            continue;
        }
        let found = trace.degree(&requirement, 1.0);
        let Requirement { parts, formula } = &requirement;
        let other = by_banquo(formula, parts, &samples).and_then(|trace| trace.at_time(0.0).copied());
        if let Some(other) = other {
            assert!(
                found.robustness == other || (found.robustness - other).abs() < 1e-9,
                "{number}: {found:?}, {other}, {requirement:?}"
            );
            compared += 1;
        }
        // The definition takes a time that is exponential in the depth.
        if number % 10 == 0 {
            let defined = by_definition(formula, parts, &samples, 0);
            assert_eq!(
                found.robustness.to_bits(),
                defined.to_bits(),
                "{number}: {found:?}, {defined}, {requirement:?}, {samples:?}"
            );
            assert_eq!(!found.is_violated(), is_true(formula, parts, &samples, 0), "{number}: {found:?}");
        }
        if let Some(part) = found.part {
            let part = &parts[usize::from(part)];
            let margin = part.margin.evaluate(&|id| samples[found.sample as usize][id.0]);
            assert_eq!(
                margin.abs(),
                found.robustness.abs(),
                "{number}: the named part has that margin at the named sample"
            );
        }
        violated += usize::from(found.is_violated());
    }
    assert!(compared > 50_000 && (20_000..80_000).contains(&violated), "{compared} {violated}");
}

/// The formula of a recorded list.
fn read(tree: &Value, parts: &mut Vec<Comparison>) -> Temporal {
    let number = |index: usize| tree[index].as_f64().unwrap();
    let within = || Within { from: number(1), to: tree[2].as_f64().unwrap_or(f64::INFINITY) };
    let mut inner = |index: usize| Arc::new(read(&tree[index], parts));
    match tree[0].as_str().unwrap() {
        "not" => Temporal::Not(inner(1)),
        "and" => Temporal::And(inner(1), inner(2)),
        "or" => Temporal::Or(inner(1), inner(2)),
        "always" => Temporal::Always(within(), inner(3)),
        "eventually" => Temporal::Eventually(within(), inner(3)),
        "until" => Temporal::Until(within(), inner(3), inner(4)),
        _ => {
            parts.push(comparison(number(1) as usize, number(2), false));
            Temporal::Part(parts.len() - 1)
        }
    }
}

#[test]
fn robustness_is_that_of_rtamt() {
    let recorded_here = crate::repository().join("tests/reference/rtamt/robustness.json");
    let path = std::env::var_os("FALSIFY_RTAMT").map_or(recorded_here, Into::into);
    let recording: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let (mut compared, mut until) = (0, 0);
    for pair in recording["pairs"].as_array().unwrap() {
        let mut parts = Vec::new();
        let formula = read(&pair[0], &mut parts);
        let signals: [Vec<f64>; SIGNALS] = serde_json::from_value(pair[1].clone()).unwrap();
        // rtamt failed on this one.
        let Some(expected) = pair[2].as_array() else { continue };
        let requirement = Requirement { parts, formula };
        let samples: Vec<[f64; SIGNALS]> =
            (0..signals[0].len()).map(|time| std::array::from_fn(|index| signals[index][time])).collect();
        for (from, expected) in expected.iter().enumerate() {
            let expected = match expected.as_str() {
                Some("inf") => f64::INFINITY,
                Some(_) => f64::NEG_INFINITY,
                None => expected.as_f64().unwrap(),
            };
            let found = recorded(&requirement, &samples[from..]).degree(&requirement, 1.0).robustness;
            assert!(found == expected || (found - expected).abs() < 1e-9, "{found} and {expected} at {from}: {pair}");
        }
        compared += 1;
        until += usize::from(pair[0].to_string().contains("until"));
    }
    assert!(compared > 150 && until > 20, "{compared} {until}");
}

#[test]
fn endpoints_ties_and_the_end_of_the_episode() {
    let part = |strict| vec![comparison(0, 1.0, strict)];
    let of = |requirement: &Requirement, values: &[f64]| {
        let samples: Vec<[f64; SIGNALS]> = values.iter().map(|value| [*value, 0.0, 0.0]).collect();
        recorded(requirement, &samples).degree(requirement, 0.1)
    };
    let always = |from: f64, to: f64, strict: bool| {
        let formula = Temporal::Always(Within { from, to }, Temporal::Part(0).into());
        Requirement { parts: part(strict), formula }
    };
    // Equal sides: `<` and `>` are false, `<=` and `>=` true.
    assert!(of(&always(0.0, 9.0, true), &[3.0, 1.0]).is_violated());
    assert!(!of(&always(0.0, 9.0, false), &[3.0, 1.0]).is_violated());
    // Both ends of a bound count, also where 0.3 / 0.1 is not 3.
    let found = of(&always(0.1, 0.3, true), &[-9.0, 5.0, 4.0, 3.0, -9.0]);
    assert_eq!((found.robustness, found.sample, found.part), (2.0, 3, Some(0)));
    // Of equal samples the first decides.
    assert_eq!(of(&always(0.0, f64::INFINITY, true), &[5.0, 2.0, 4.0, 2.0]).sample, 1);
    assert_eq!(of(&always(0.0, 0.2, true), &[2.0, 2.0, 4.0, 2.0]).sample, 0);
    // A bound beyond the end is true, and `eventually` is false.
    let found = of(&always(1.0, 2.0, true), &[0.0, 0.0]);
    assert_eq!((found.robustness, found.part), (f64::INFINITY, None));
    let formula = Temporal::Eventually(Within { from: 1.0, to: 2.0 }, Temporal::Part(0).into());
    assert_eq!(of(&Requirement { parts: part(true), formula }, &[9.0, 9.0]).robustness, f64::NEG_INFINITY);
    assert_eq!(ticks_within(&Within { from: 0.01, to: 0.02 }, 0.05), (1, Some(0)), "no tick lies in it");
}

#[test]
fn a_requirement_applies_where_what_stands_before_its_implies_held() {
    let parts = vec![comparison(0, 1.0, true), comparison(1, 1.0, true)];
    let implies = Temporal::Or(Temporal::Not(Temporal::Part(0).into()).into(), Temporal::Part(1).into());
    let applies = |formula: Temporal, samples: &[[f64; SIGNALS]]| {
        let requirement = Requirement { parts: parts.clone(), formula };
        recorded(&requirement, samples).degree(&requirement, 0.1).applies
    };
    let always = Temporal::Always(Within::EPISODE, implies.into());
    assert!(!applies(always.clone(), &[[0.0, 9.0, 0.0]; 3]));
    assert!(applies(always.clone(), &[[0.0, 9.0, 0.0], [2.0, 9.0, 0.0]]));
    assert!(applies(always, &[[2.0, 0.0, 0.0]]), "it is violated");
    assert!(applies(Temporal::Always(Within::EPISODE, Temporal::Part(1).into()), &[[0.0, 9.0, 0.0]]));
}

#[test]
fn parts_of_different_dimensions_are_scaled_and_conditions_have_no_degree() {
    let speed = Comparison { dimension: Some(Dimension::SPEED), scale: 5.0, ..comparison(1, 0.0, true) };
    let sight = Comparison {
        margin: Formula::Variable(VariableId(2)),
        dimension: None,
        scale: 1.0,
        ..comparison(2, 0.0, false)
    };
    let both = |a: Comparison, b: Comparison| Requirement {
        parts: vec![a, b],
        formula: Temporal::And(Temporal::Part(0).into(), Temporal::Part(1).into()),
    };
    let degree = |requirement: &Requirement, sample: [f64; SIGNALS]| -> Degree {
        recorded(requirement, &[sample]).degree(requirement, 0.1)
    };
    let mixed = both(comparison(0, 0.0, true), speed);
    assert!(mixed.is_scaled());
    assert_eq!(degree(&mixed, [3.0, 2.0, 0.0]).robustness, 0.4, "2 of 5, and 3 of 2");
    let guarded = both(comparison(0, 0.0, true), sight);
    assert_eq!(guarded.dimension(), Some(Dimension::LENGTH));
    assert_eq!(degree(&guarded, [3.0, 0.0, 1.0]).robustness, 3.0);
    assert_eq!(degree(&guarded, [3.0, 0.0, 0.0]).robustness, f64::NEG_INFINITY);
}
