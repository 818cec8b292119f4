//! Dimensions and units: `7 m`, `20 Hz`, `60 deg`, `50 km/h` become numbers in SI with a dimension.
//!
//! An angle has a dimension of its own here, although it is a ratio in SI. A bare `60` in place of an angle is the most common
//! silent mistake of scenario authors.

use std::f64::consts::PI;
use std::fmt;

/// Powers of metre, second, radian and kilogram. Its debug form is a part of fingerprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Dimension {
    metre: i8,
    second: i8,
    radian: i8,
    kilogram: i8,
}

/// What the powers of a [`Dimension`] are of.
const BASES: [&str; 4] = ["m", "s", "rad", "kg"];

macro_rules! dimensions {
    ($($(#[$doc:meta])+ $NAME:ident = $powers:expr, $name:literal, $units:expr;)*) => {
        /// The dimensions of quantities, by their short names.
        pub mod dimensions {
            use super::Dimension;

            $($(#[$doc])+ pub const $NAME: Dimension = Dimension::$NAME;)*
        }

        impl Dimension {
            $($(#[$doc])+ pub const $NAME: Self = Self::new($powers);)*

            /// Those with a name, each with the units that a user would write for it.
            const NAMED: &[(Self, &str, &[&str])] = &[$((Self::$NAME, $name, &$units)),*];
        }
    };
}

dimensions! {
    /// A plain number.
    RATIO = [0, 0, 0, 0], "plain number", [];
    /// Metres.
    LENGTH = [1, 0, 0, 0], "length", ["m", "km"];
    /// Seconds.
    TIME = [0, 1, 0, 0], "time", ["s", "ms"];
    /// Radians.
    ANGLE = [0, 0, 1, 0], "angle", ["deg", "rad"];
    /// Kilograms.
    MASS = [0, 0, 0, 1], "mass", ["kg"];
    /// Metres per second.
    SPEED = [1, -1, 0, 0], "speed", ["m/s", "km/h"];
    /// Metres per second squared.
    ACCELERATION = [1, -2, 0, 0], "acceleration", ["m/s^2"];
    /// Metres per second cubed.
    JERK = [1, -3, 0, 0], "jerk", ["m/s^3"];
    /// Per second.
    FREQUENCY = [0, -1, 0, 0], "frequency", ["Hz"];
    /// Radians per second.
    TURN_RATE = [0, -1, 1, 0], "turn rate", ["deg/s", "rad/s"];
}

impl Dimension {
    const fn new([metre, second, radian, kilogram]: [i8; 4]) -> Self {
        Self { metre, second, radian, kilogram }
    }

    fn powers(self) -> [i8; 4] {
        [self.metre, self.second, self.radian, self.kilogram]
    }

    fn combined(self, others: [i8; 4], of: impl Fn(i8, i8) -> Option<i8>) -> Option<Self> {
        let mut powers = self.powers();
        for (own, other) in powers.iter_mut().zip(others) {
            *own = of(*own, other)?;
        }
        Some(Self::new(powers))
    }

    /// The dimension of a product; `None` if a power leaves the range of a byte.
    pub fn times(self, other: Self) -> Option<Self> {
        self.combined(other.powers(), i8::checked_add)
    }

    /// The dimension of a quotient; `None` if a power leaves the range of a byte.
    pub fn over(self, other: Self) -> Option<Self> {
        self.times(other.to_the(-1)?)
    }

    /// The dimension of a power; `None` if it leaves the range of a byte.
    pub fn to_the(self, power: i8) -> Option<Self> {
        self.combined([power; 4], i8::checked_mul)
    }

    /// The dimension of a square root; `None` if a power is odd.
    pub fn root(self) -> Option<Self> {
        self.combined([0; 4], |power, _| (power % 2 == 0).then_some(power / 2))
    }

    fn named(self) -> Option<&'static (Self, &'static str, &'static [&'static str])> {
        Self::NAMED.iter().find(|(dimension, ..)| *dimension == self)
    }

    /// Units a user would write for it, the most common first; empty for dimensions without a name.
    pub fn usual_units(self) -> &'static [&'static str] {
        self.named().map_or(&[], |(.., units)| units)
    }
}

/// Writes the dimension's name, or its powers when it has none.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((_, name, _)) = self.named() {
            return f.write_str(name);
        }
        let powers = BASES.iter().zip(self.powers()).filter(|(_, power)| *power != 0);
        let text = powers.map(|(base, power)| if power == 1 { base.to_string() } else { format!("{base}^{power}") });
        write!(f, "quantity in {}", text.collect::<Vec<_>>().join(" "))
    }
}

/// A unit: how many SI units it is, and of what dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// SI units per one of these.
    pub factor: f64,
    pub dimension: Dimension,
}

/// The names a unit may be built from.
pub const UNIT_NAMES: &[(&str, Unit)] = &[
    ("m", Unit { factor: 1.0, dimension: Dimension::LENGTH }),
    ("km", Unit { factor: 1000.0, dimension: Dimension::LENGTH }),
    ("cm", Unit { factor: 0.01, dimension: Dimension::LENGTH }),
    ("mm", Unit { factor: 0.001, dimension: Dimension::LENGTH }),
    ("s", Unit { factor: 1.0, dimension: Dimension::TIME }),
    ("ms", Unit { factor: 0.001, dimension: Dimension::TIME }),
    ("min", Unit { factor: 60.0, dimension: Dimension::TIME }),
    ("h", Unit { factor: 3600.0, dimension: Dimension::TIME }),
    ("Hz", Unit { factor: 1.0, dimension: Dimension::FREQUENCY }),
    ("rad", Unit { factor: 1.0, dimension: Dimension::ANGLE }),
    ("deg", Unit { factor: PI / 180.0, dimension: Dimension::ANGLE }),
    ("kg", Unit { factor: 1.0, dimension: Dimension::MASS }),
    ("kph", Unit { factor: 1.0 / 3.6, dimension: Dimension::SPEED }),
    ("mph", Unit { factor: 0.44704, dimension: Dimension::SPEED }),
    ("percent", Unit { factor: 0.01, dimension: Dimension::RATIO }),
];

/// Why a unit could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnitError {
    /// A part of it is not the name of a unit.
    Unknown { name: String },
    /// A power is not a whole number from −9 to 9, or the dimension is out of range.
    BadPower,
}

/// Reads a unit such as `m`, `km/h` or `m/s^2`.
///
/// # Errors
/// Names the first part that is not known.
///
/// # Example
/// ```
/// use base::units::{Dimension, parse_unit};
/// let unit = parse_unit("km/h").unwrap();
/// assert_eq!(unit.dimension, Dimension::SPEED);
/// assert!((36.0 * unit.factor - 10.0).abs() < 1e-12);
/// ```
pub fn parse_unit(text: &str) -> Result<Unit, UnitError> {
    let mut unit = Unit { factor: 1.0, dimension: Dimension::RATIO };
    let mut rest = text;
    let mut sign = 1;
    loop {
        let end = rest.find(['/', '*']).unwrap_or(rest.len());
        let (name, power) = match rest[..end].split_once('^') {
            Some((name, power)) => (name, power.parse::<i8>().ok().filter(|p| p.abs() <= 9)),
            None => (&rest[..end], Some(1)),
        };
        let power = sign * power.ok_or(UnitError::BadPower)?;
        let base = UNIT_NAMES
            .iter()
            .find(|(known, _)| *known == name)
            .ok_or_else(|| UnitError::Unknown { name: name.to_string() })?
            .1;
        let dimension =
            base.dimension.to_the(power).and_then(|d| unit.dimension.times(d)).ok_or(UnitError::BadPower)?;
        unit = Unit { factor: unit.factor * base.factor.powi(i32::from(power)), dimension };
        match rest[end..].chars().next() {
            None => return Ok(unit),
            Some(operator) => {
                sign = if operator == '/' { -1 } else { 1 };
                rest = &rest[end + 1..];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compound_units_have_the_right_size_and_dimension() {
        for (text, factor, dimension) in [
            ("m/s^2", 1.0, Dimension::ACCELERATION),
            ("km/h", 1000.0 / 3600.0, Dimension::SPEED),
            ("mph", 1609.344 / 3600.0, Dimension::SPEED),
            ("deg/s", PI / 180.0, Dimension::TURN_RATE),
            ("percent", 0.01, Dimension::RATIO),
        ] {
            let unit = parse_unit(text).unwrap();
            assert!((unit.factor - factor).abs() < 1e-12, "{text}");
            assert_eq!(unit.dimension, dimension, "{text}");
        }
    }

    #[test]
    fn unknown_parts_are_named() {
        assert_eq!(parse_unit("m/v_c"), Err(UnitError::Unknown { name: "v_c".into() }));
        assert_eq!(parse_unit("m^x"), Err(UnitError::BadPower));
        assert_eq!(parse_unit("m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9*m^9"), Err(UnitError::BadPower));
    }
}
