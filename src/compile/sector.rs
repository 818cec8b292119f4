//! Turns conditions of a spawn into sampling where possible.
//!
//! `distance > 10 m` cuts the distribution of the distance, which gives the same draws as rejection. The rest is left to rejection, which reports a
//! spawn that draws no start.

use base::signature::{BinaryOperator, Distribution, Formula, Vocabulary};

/// Quantities that are drawn independently, by their variables.
pub(super) type Sector = [(&'static str, Distribution); 3];

/// Applies a condition to the distributions as far as possible; returns the part that remains.
pub(super) fn narrow(sector: &mut Sector, condition: &Formula, vocabulary: &Vocabulary) -> Option<Formula> {
    if let Formula::Binary(BinaryOperator::And, left, right) = condition {
        return match (narrow(sector, left, vocabulary), narrow(sector, right, vocabulary)) {
            (Some(left), Some(right)) => Some(Formula::Binary(BinaryOperator::And, left.into(), right.into())),
            (left, right) => left.or(right),
        };
    }
    let mut cut = || {
        let (variable, operator, bound) = bound(condition, vocabulary)?;
        let (_, distribution) = sector.iter_mut().find(|(name, _)| *name == variable)?;
        let (low, high) = distribution.support();
        let kept = match operator {
            BinaryOperator::Less | BinaryOperator::LessEqual => distribution.truncated(low, bound),
            _ => distribution.truncated(bound, high),
        };
        let strict = matches!(operator, BinaryOperator::Less | BinaryOperator::Greater);
        *distribution = kept.and_then(|kept| if strict { kept.without(bound) } else { Some(kept) })?;
        Some(())
    };
    cut().is_none().then(|| condition.clone())
}

/// `variable < constant` in either order.
fn bound(condition: &Formula, vocabulary: &Vocabulary) -> Option<(&'static str, BinaryOperator, f64)> {
    use BinaryOperator::{Greater, GreaterEqual, Less, LessEqual};
    let Formula::Binary(operator, left, right) = condition else { return None };
    let (id, bound, operator) = match (&**left, &**right, operator) {
        (Formula::Variable(id), bound, Less | LessEqual | Greater | GreaterEqual) => (id, bound, *operator),
        (bound, Formula::Variable(id), Less) => (id, bound, Greater),
        (bound, Formula::Variable(id), LessEqual) => (id, bound, GreaterEqual),
        (bound, Formula::Variable(id), Greater) => (id, bound, Less),
        (bound, Formula::Variable(id), GreaterEqual) => (id, bound, LessEqual),
        _ => return None,
    };
    let (low, high) = bound.bounds(&|_| (f64::NEG_INFINITY, f64::INFINITY));
    (low == high).then(|| (vocabulary.variables[id.0].name, operator, low))
}

pub(super) fn names(condition: &Formula, vocabulary: &Vocabulary, variable: &str) -> bool {
    condition.mentions(&|id| vocabulary.variables[id.0].name == variable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::signature::VariableId;
    use episode::vocabulary;

    #[test]
    fn the_papers_sector_written_as_conditions_is_sampled_directly() {
        let vocabulary = vocabulary();
        let variable = |name: &str| {
            let place = vocabulary.variables.iter().position(|variable| variable.name == name);
            Formula::Variable(VariableId(place.unwrap()))
        };
        let compare = |left: Formula, operator, right: Formula| Formula::Binary(operator, left.into(), right.into());
        let (bearing, distance) = (Distribution::Uniform(-3.0, 3.0), Distribution::Uniform(5.0, 50.0));
        let mut sector = [("bearing", bearing), ("distance", distance), ("ego_speed", Distribution::Constant(0.0))];
        let near = compare(variable("distance"), BinaryOperator::GreaterEqual, Formula::Constant(7.0));
        let far = compare(Formula::Constant(30.0), BinaryOperator::GreaterEqual, variable("distance"));
        let right = compare(variable("bearing"), BinaryOperator::Greater, Formula::Constant(-1.0));
        let left = compare(variable("bearing"), BinaryOperator::Less, Formula::Constant(1.0));
        let and = |a: Formula, b: Formula| compare(a, BinaryOperator::And, b);
        assert_eq!(narrow(&mut sector, &and(and(near, far), and(right, left)), &vocabulary), None);
        let [bearing, distance, _] = sector.map(|(_, distribution)| distribution);
        assert_eq!((bearing, distance), (Distribution::Uniform(-1.0, 1.0), Distribution::Uniform(7.0, 30.0)));
    }
}
