//! Turns conditions of a spawn into sampling where possible, and finds contradictions between them.
//!
//! `distance > 10 m` cuts the distribution of the distance, which gives the same draws as rejection. Every other condition
//! is evaluated over the bounds of its variables. A condition that is never true is a contradiction, and one that is always true
//! is dropped. The rest is left to rejection, unless ever smaller boxes of starts show that it is never true together.

use base::diagnostic::{Diagnostic, Label, Span};
use base::signature::{BinaryOperator, Bounds, Distribution, Formula, VariableId, Vocabulary};
use base::units::Dimension;
use lang::diagnostics;

/// A quantity that is drawn independently.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    variable: &'static str,
    dimension: Dimension,
    pub distribution: Distribution,
    /// The places in the file that set its least and its greatest value.
    low: Span,
    high: Span,
}

/// The quantities that a start is drawn from.
#[derive(Debug, Clone)]
pub(super) struct Sector<'a> {
    vocabulary: &'a Vocabulary,
    drawn: [Drawn; 3],
}

impl<'a> Sector<'a> {
    /// Starts with the values of the keys, each with its place.
    pub fn new(
        vocabulary: &'a Vocabulary,
        bearing: (&Distribution, Span),
        distance: (&Distribution, Span),
        ego_speed: (&Distribution, Span),
    ) -> Self {
        let drawn = |variable, dimension, (distribution, span): (&Distribution, Span)| Drawn {
            variable,
            dimension,
            distribution: distribution.clone(),
            low: span,
            high: span,
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
        let drawn = &mut self.drawn[place];
        let (a, b) = drawn.distribution.support();
        let upper = matches!(operator, BinaryOperator::Less | BinaryOperator::LessEqual);
        let (low, high) = if upper { (a, bound) } else { (bound, b) };
        let rare = low <= b && a <= high;
        let kept = drawn.distribution.truncated(low, high);
        let strict = matches!(operator, BinaryOperator::Less | BinaryOperator::Greater);
        let Some(kept) = kept.and_then(|kept| if strict { kept.without(bound) } else { Some(kept) }) else {
            let mut diagnostic = self.contradiction(condition, span);
            if rare && low < high {
                diagnostic.message = "this is never drawn".into();
                diagnostic.primary.text = "its share of the distribution is too small to be counted with".into();
            }
            return Err(diagnostic.into());
        };
        drawn.distribution = kept;
        *(if upper { &mut drawn.high } else { &mut drawn.low }) = span;
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

    /// Checks that conditions can be true together, as far as that can be decided.
    ///
    /// # Errors
    /// A minimal set of conditions that are never true together, the last one first.
    pub fn require_together(&self, conditions: &[(Formula, Span)]) -> Result<(), Box<Diagnostic>> {
        let mut clash: Vec<&(Formula, Span)> = conditions.iter().collect();
        if clash.is_empty() || !self.excludes(&clash) {
            return Ok(());
        }
        let mut place = 0;
        while place < clash.len() {
            let without: Vec<_> = [&clash[..place], &clash[place + 1..]].concat();
            if !without.is_empty() && self.excludes(&without) { clash = without } else { place += 1 }
        }
        let all = clash.iter().map(|(condition, _)| condition.clone());
        let and = |a: Formula, b: Formula| Formula::Binary(BinaryOperator::And, a.into(), b.into());
        let whole = all.reduce(and).expect("something clashes");
        let ((_, span), others) = clash.split_last().expect("something clashes");
        let mut diagnostic = self.contradiction(&whole, *span);
        if !others.is_empty() {
            diagnostic.message = "these never hold together".into();
            diagnostic
                .labels
                .splice(0..0, others.iter().map(|(_, span)| Label { span: *span, text: "and this".into() }));
        }
        Err(diagnostic.into())
    }

    /// Whether no start satisfies all of these conditions, as far as ever smaller boxes of starts can show it.
    fn excludes(&self, conditions: &[&(Formula, Span)]) -> bool {
        let mut named = Vec::new();
        conditions.iter().for_each(|(condition, _)| variables(condition, &mut named));
        let named: Vec<&str> = named.iter().map(|id| self.vocabulary.variables[id.0].name).collect();
        let derived = named.iter().any(|name| matches!(*name, "ahead" | "aside"));
        let mut open = vec![Region { drawn: [(0.0, 0.0); 3], facing: (-std::f64::consts::PI, std::f64::consts::PI) }];
        for (place, drawn) in self.drawn.iter().enumerate() {
            let pieces = drawn.distribution.pieces();
            if open.len().saturating_mul(pieces.len()) > MOST_REGIONS / 2 {
                return false;
            }
            let with = |region: &Region, piece: &(f64, f64)| {
                let mut region = *region;
                region.drawn[place] = *piece;
                region
            };
            open = open.iter().flat_map(|region| pieces.iter().map(move |piece| with(region, piece))).collect();
        }
        let matters = |place: usize| match place {
            3 => named.contains(&"facing"),
            2 => named.contains(&"ego_speed"),
            place => derived || named.contains(&self.drawn[place].variable),
        };
        let splits: Vec<usize> = (0..4).filter(|place| matters(*place)).collect();
        for _ in 0..MOST_REGIONS {
            let Some(region) = open.pop() else { return true };
            let bounds = |condition: &Formula, region: &Region| {
                condition.bounds(&|id| region.bounds(self.vocabulary.variables[id.0].name))
            };
            let found: Vec<_> = conditions.iter().map(|(condition, _)| bounds(condition, &region)).collect();
            if found.contains(&(0.0, 0.0)) {
                continue;
            }
            let middle = region.middle();
            if conditions.iter().all(|(condition, _)| bounds(condition, &middle).0 > 0.0) {
                return false;
            }
            let Some(halves) = region.halves(&splits) else { return false };
            open.extend(halves);
        }
        false
    }

    /// The least and the greatest value of a variable.
    fn bounds(&self, id: VariableId) -> (f64, f64) {
        let drawn = std::array::from_fn(|place| self.drawn[place].distribution.support());
        let region = Region { drawn, facing: (-std::f64::consts::PI, std::f64::consts::PI) };
        region.bounds(self.vocabulary.variables[id.0].name)
    }

    fn contradiction(&self, condition: &Formula, span: Span) -> Diagnostic {
        let mut diagnostic = diagnostics::contradiction(span, "this is never true".into());
        let mut named = Vec::new();
        variables(condition, &mut named);
        let derived = |name: &str| matches!(name, "ahead" | "aside");
        let names: Vec<&str> = named.iter().map(|id| self.vocabulary.variables[id.0].name).collect();
        for drawn in &self.drawn {
            let through = names.iter().any(|name| derived(name)) && drawn.variable != "ego_speed";
            if names.contains(&drawn.variable) || through {
                let (low, high) = drawn.distribution.support();
                let (low, high) = (shown(low, drawn.dimension), shown(high, drawn.dimension));
                // If one condition has narrowed a key, the key only gives the other end.
                diagnostic = match drawn.low == drawn.high {
                    true => diagnostic.label(drawn.low, format!("{} is {low} .. {high}", drawn.variable)),
                    false => diagnostic
                        .label(drawn.low, format!("{} is {low} or more", drawn.variable))
                        .label(drawn.high, format!("{} is {high} or less", drawn.variable)),
                };
            }
        }
        for id in named {
            let variable = &self.vocabulary.variables[id.0];
            if derived(variable.name) {
                let (low, high) = self.bounds(id);
                let (low, high) = (shown(low, variable.dimension), shown(high, variable.dimension));
                diagnostic = diagnostic.help(format!("there `{}` is {low} .. {high}", variable.name));
            }
        }
        diagnostic
    }
}

/// Whether a condition names a variable.
pub(super) fn names(condition: &Formula, vocabulary: &Vocabulary, variable: &str) -> bool {
    let mut named = Vec::new();
    variables(condition, &mut named);
    named.iter().any(|id| vocabulary.variables[id.0].name == variable)
}

/// The greatest number of boxes to examine for whether conditions can be true together.
const MOST_REGIONS: usize = 2048;

/// A box of starts.
#[derive(Debug, Clone, Copy)]
struct Region {
    /// Bounds of the drawn quantities: bearing, distance, speed of the ego.
    drawn: [Bounds; 3],
    /// Bounds of the pedestrian's facing.
    facing: Bounds,
}

impl Region {
    /// The least and the greatest value of a variable within it.
    fn bounds(&self, name: &str) -> Bounds {
        let [bearing, distance, ego_speed] = self.drawn;
        match name {
            "bearing" => bearing,
            "distance" => distance,
            "ego_speed" => ego_speed,
            "ahead" => rounded(product(distance, cosine(bearing))),
            "aside" => rounded(product(distance, cosine((bearing.0 - QUARTER, bearing.1 - QUARTER)))),
            "facing" => self.facing,
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    fn sides(&mut self) -> [&mut Bounds; 4] {
        let [bearing, distance, ego_speed] = &mut self.drawn;
        [bearing, distance, ego_speed, &mut self.facing]
    }

    fn middle(mut self) -> Self {
        self.sides()
            .into_iter()
            .for_each(|side| *side = (f64::midpoint(side.0, side.1), f64::midpoint(side.0, side.1)));
        self
    }

    /// Its halves along the longest of these sides; none when all are short.
    fn halves(mut self, splits: &[usize]) -> Option<[Self; 2]> {
        /// Sides that count as equally long: an angle of 1 rad, 10 m, 10 m/s.
        const SCALE: [f64; 4] = [1.0, 10.0, 10.0, 1.0];
        const SHORTEST: f64 = 1e-3;
        let sides = self.sides().map(|side| *side);
        let length = |place: &usize| (sides[*place].1 - sides[*place].0) / SCALE[*place];
        let longest = splits.iter().copied().max_by(|a, b| length(a).total_cmp(&length(b)))?;
        if length(&longest) < SHORTEST {
            return None;
        }
        let (low, high) = sides[longest];
        let middle = f64::midpoint(low, high);
        let (mut lower, mut upper) = (self, self);
        *lower.sides()[longest] = (low, middle);
        *upper.sides()[longest] = (middle, high);
        Some([lower, upper])
    }
}

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// The bounds of the cosine of an angle within bounds.
fn cosine((low, high): (f64, f64)) -> (f64, f64) {
    use std::f64::consts::{PI, TAU};
    // Whether an angle `at + 2 π k` lies between the bounds.
    let holds = |at: f64| low <= at + ((high - at) / TAU).floor() * TAU;
    let (a, b) = (libm::cos(low), libm::cos(high));
    (if holds(PI) { -1.0 } else { a.min(b) }, if holds(0.0) { 1.0 } else { a.max(b) })
}

/// Bounds with room for rounding: the computed cosine of a right angle is not exactly 0.
fn rounded((low, high): Bounds) -> Bounds {
    const LOST: f64 = 1e-9;
    (low - LOST, high + LOST)
}

fn product((a, b): (f64, f64), (c, d): (f64, f64)) -> (f64, f64) {
    let corners = [a * c, a * d, b * c, b * d];
    (corners.iter().copied().fold(f64::INFINITY, f64::min), corners.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

fn variables(formula: &Formula, found: &mut Vec<VariableId>) {
    match formula {
        Formula::Constant(_) => {}
        Formula::Variable(id) => {
            if !found.contains(id) {
                found.push(*id);
            }
        }
        Formula::Negate(inner) | Formula::Not(inner) => variables(inner, found),
        Formula::Binary(_, left, right) => {
            variables(left, found);
            variables(right, found);
        }
        Formula::Call(_, arguments) => arguments.iter().for_each(|argument| variables(argument, found)),
    }
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
    use proptest::prelude::*;
    use world::env::vocabulary;

    fn sector(vocabulary: &Vocabulary) -> Sector<'_> {
        let span = Span { source: Sources::default().add("test", ""), start: 0, end: 0 };
        let (bearing, distance) = (Distribution::Uniform(-3.0, 3.0), Distribution::Uniform(5.0, 50.0));
        Sector::new(vocabulary, (&bearing, span), (&distance, span), (&Distribution::Constant(0.0), span))
    }

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
        let mut sector = sector(&vocabulary);
        let span = sector.drawn[0].low;
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

    proptest! {
        #[test]
        fn ahead_and_aside_stay_within_their_bounds(low in -3.1..3.1, width in 0.0..3.0, share in 0.0..=1.0, d in 5.0..50.0) {
            let vocabulary = vocabulary();
            let mut sector = sector(&vocabulary);
            sector.drawn[0].distribution = Distribution::Uniform(low, low + width);
            let angle: f64 = low + share * width;
            for (name, value) in [("ahead", d * libm::cos(angle)), ("aside", d * libm::sin(angle))] {
                let Formula::Variable(id) = variable(&vocabulary, name) else { unreachable!() };
                let (a, b) = sector.bounds(id);
                prop_assert!(a - 1e-9 <= value && value <= b + 1e-9, "{} in {} .. {}", value, a, b);
            }
        }
    }
}
