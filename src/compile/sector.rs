//! Turns conditions of a spawn into sampling where possible.
//!
//! `distance > 10 m` cuts the distribution of the distance, which gives the same draws as rejection. A condition that is always true
//! is dropped. The rest is left to rejection, which reports a spawn that draws no start.

use base::diagnostic::{Diagnostic, Span};
use base::signature::{BinaryOperator, Bounds, Distribution, Formula, VariableId, Vocabulary};
use base::units::Dimension;
use lang::diagnostics;

/// A quantity that is drawn independently.
#[derive(Debug, Clone)]
struct Drawn {
    variable: &'static str,
    dimension: Dimension,
    distribution: Distribution,
}

/// The quantities that a start is drawn from.
#[derive(Debug, Clone)]
pub(super) struct Sector<'a> {
    vocabulary: &'a Vocabulary,
    drawn: [Drawn; 3],
}

impl<'a> Sector<'a> {
    /// Starts with the values of the keys.
    pub fn new(
        vocabulary: &'a Vocabulary,
        bearing: &Distribution,
        distance: &Distribution,
        ego_speed: &Distribution,
    ) -> Self {
        let drawn = |variable, dimension, distribution: &Distribution| {
            let distribution = distribution.clone();
            Drawn { variable, dimension, distribution }
        };
        let drawn = [
            drawn("bearing", Dimension::ANGLE, bearing),
            drawn("distance", Dimension::LENGTH, distance),
            drawn("ego_speed", Dimension::SPEED, ego_speed),
        ];
        Self { vocabulary, drawn }
    }

    /// The distributions of the bearing, the distance and the ego's speed.
    pub fn into_distributions(self) -> [Distribution; 3] {
        self.drawn.map(|drawn| drawn.distribution)
    }

    /// Applies a condition to the distributions as far as possible; returns the part that remains.
    ///
    /// # Errors
    /// The condition is never true.
    pub fn require(&mut self, condition: &Formula, span: Span) -> Result<Option<Formula>, Box<Diagnostic>> {
        let (low, high) = condition.bounds(&|id| self.bounds(id));
        if low == 0.0 && high == 0.0 {
            return Err(self.contradiction(condition, span).into());
        }
        if low > 0.0 {
            return Ok(None);
        }
        if let Formula::Binary(BinaryOperator::And, left, right) = condition {
            return Ok(match (self.require(left, span)?, self.require(right, span)?) {
                (Some(left), Some(right)) => Some(Formula::Binary(BinaryOperator::And, left.into(), right.into())),
                (left, right) => left.or(right),
            });
        }
        let Some((place, operator, bound)) = self.cut(condition) else { return Ok(Some(condition.clone())) };
        let distribution = &self.drawn[place].distribution;
        let (a, b) = distribution.support();
        let kept = match operator {
            BinaryOperator::Less | BinaryOperator::LessEqual => distribution.truncated(a, bound),
            _ => distribution.truncated(bound, b),
        };
        let strict = matches!(operator, BinaryOperator::Less | BinaryOperator::Greater);
        let kept = kept.and_then(|kept| if strict { kept.without(bound) } else { Some(kept) });
        self.drawn[place].distribution = kept.ok_or_else(|| self.contradiction(condition, span))?;
        Ok(None)
    }

    /// `variable < constant` in either order, for a quantity that is drawn.
    fn cut(&self, condition: &Formula) -> Option<(usize, BinaryOperator, f64)> {
        use BinaryOperator::{Greater, GreaterEqual, Less, LessEqual};
        let Formula::Binary(operator, left, right) = condition else { return None };
        let constant = |formula: &Formula| {
            let (low, high) = formula.bounds(&|_| (f64::NEG_INFINITY, f64::INFINITY));
            (low == high).then_some(low)
        };
        let place = |id: &VariableId| {
            let name = self.vocabulary.variables[id.0].name;
            self.drawn.iter().position(|drawn| drawn.variable == name)
        };
        match (&**left, &**right) {
            (Formula::Variable(id), bound) if matches!(operator, Less | LessEqual | Greater | GreaterEqual) => {
                Some((place(id)?, *operator, constant(bound)?))
            }
            (bound, Formula::Variable(id)) => {
                let mirrored = match operator {
                    Less => Greater,
                    LessEqual => GreaterEqual,
                    Greater => Less,
                    GreaterEqual => LessEqual,
                    _ => return None,
                };
                Some((place(id)?, mirrored, constant(bound)?))
            }
            _ => None,
        }
    }

    /// The bounds of a variable; infinite if it is not drawn itself.
    fn bounds(&self, id: VariableId) -> Bounds {
        let name = self.vocabulary.variables[id.0].name;
        let drawn = self.drawn.iter().find(|drawn| drawn.variable == name);
        drawn.map_or((f64::NEG_INFINITY, f64::INFINITY), |drawn| drawn.distribution.support())
    }

    fn contradiction(&self, condition: &Formula, span: Span) -> Diagnostic {
        let named = self.drawn.iter().filter(|drawn| names(condition, self.vocabulary, drawn.variable));
        named.fold(diagnostics::contradiction(span, "this is never drawn".into()), |said, drawn| {
            let (low, high) = drawn.distribution.support();
            let (low, high) = (shown(low, drawn.dimension), shown(high, drawn.dimension));
            said.help(format!("`{}` is {low} .. {high} here", drawn.variable))
        })
    }
}

/// Whether a condition names a variable.
pub(super) fn names(condition: &Formula, vocabulary: &Vocabulary, variable: &str) -> bool {
    condition.mentions(&|id| vocabulary.variables[id.0].name == variable)
}

/// A quantity as a user would write it.
fn shown(value: f64, dimension: Dimension) -> String {
    let value = if dimension == Dimension::ANGLE { value.to_degrees() } else { value };
    let value = (value * 100.0).round() / 100.0 + 0.0;
    format!("{value} {}", dimension.usual_units().first().unwrap_or(&"")).trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::diagnostic::Sources;
    use world::env::vocabulary;

    fn variable(vocabulary: &Vocabulary, name: &str) -> Formula {
        let place = vocabulary.variables.iter().position(|variable| variable.name == name);
        Formula::Variable(VariableId(place.unwrap()))
    }

    fn compare(left: Formula, operator: BinaryOperator, right: Formula) -> Formula {
        Formula::Binary(operator, left.into(), right.into())
    }

    #[test]
    fn the_papers_sector_written_as_conditions_is_sampled_directly() {
        let vocabulary = vocabulary();
        let span = Span { source: Sources::default().add("test", ""), start: 0, end: 0 };
        let (bearing, distance) = (Distribution::Uniform(-3.0, 3.0), Distribution::Uniform(5.0, 50.0));
        let mut sector = Sector::new(&vocabulary, &bearing, &distance, &Distribution::Constant(0.0));
        let (bearing, distance) = (variable(&vocabulary, "bearing"), variable(&vocabulary, "distance"));
        let near = compare(distance.clone(), BinaryOperator::GreaterEqual, Formula::Constant(7.0));
        let far = compare(Formula::Constant(30.0), BinaryOperator::GreaterEqual, distance);
        let right = compare(bearing.clone(), BinaryOperator::Greater, Formula::Constant(-1.0));
        let left = compare(bearing, BinaryOperator::Less, Formula::Constant(1.0));
        let and = |a: Formula, b: Formula| compare(a, BinaryOperator::And, b);
        assert_eq!(sector.require(&and(and(near, far), and(right, left)), span).unwrap(), None);
        let [bearing, distance, _] = sector.into_distributions();
        assert_eq!((bearing, distance), (Distribution::Uniform(-1.0, 1.0), Distribution::Uniform(7.0, 30.0)));
    }
}
