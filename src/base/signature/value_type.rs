use crate::units::Dimension;

/// The minimum positive value, in SI: smaller divisors give quotients that are too large to use.
pub const MIN_POSITIVE: f64 = 1e-12;
/// The maximum absolute value of a quantity of any size, in SI.
pub const MAX_MAGNITUDE: f64 = 1e9;

/// The type of a value in the language.
#[derive(Debug, Clone, PartialEq)]
pub enum Type {
    /// One number with a dimension; bounds are in SI and inclusive.
    Quantity {
        dimension: Dimension,
        /// Minimum.
        min: f64,
        /// Maximum.
        max: f64,
    },
    /// `low .. high`, low not above high; bounds are in SI and inclusive.
    Range {
        /// The dimension of both ends.
        dimension: Dimension,
        /// Minimum of the low end.
        min: f64,
        /// Maximum of the high end.
        max: f64,
    },
    /// A distribution of a quantity: a value, a range, `truncated(normal(mean, deviation), low .. high)`, `choice(a, b)`,
    /// `weighted((2, a), (1, b))`; bounds are in SI and inclusive.
    Distribution {
        dimension: Dimension,
        /// Minimum.
        min: f64,
        /// Maximum.
        max: f64,
    },
    /// A whole number without unit, in inclusive bounds.
    Integer {
        /// Minimum.
        min: i64,
        /// Maximum.
        max: i64,
    },
    /// A whole number of ticks, in inclusive bounds.
    Ticks {
        /// Minimum.
        min: i64,
        /// Maximum.
        max: i64,
    },
    /// `true` or `false`.
    Boolean,
    /// One of these words, bare or in quotes.
    Choice(&'static [&'static str]),
    /// One of these words, as a step of a sequence: a list may have it several times.
    Step(&'static [&'static str]),
    /// A text in quotes.
    Text,
    /// A file's path in quotes, relative to the folder of the file that names it.
    Path,
    /// `(x, y)`, two lengths.
    Point,
    /// `(x, y)`, or one of these words.
    WordOrPoint(&'static [&'static str]),
    /// `(x, y, yaw)`, two lengths and an angle.
    Pose,
    /// The name of a declaration of this form.
    Reference(&'static str),
    /// One of these words, bare or in quotes, or the name of a declaration of this form.
    WordOrReference(Vec<&'static str>, &'static str),
    /// `[a, b, …]` with at least one member; a single value may be written without brackets.
    List(Box<Type>),
    /// A condition over the variables that have a value at this event of the vocabulary.
    Condition(&'static str),
    /// A plain number over the variables that have a value at this event of the vocabulary.
    Formula(&'static str),
    /// A requirement in temporal logic over the variables that have a value at this event of the vocabulary.
    Requirement(&'static str),
}

impl Type {
    /// The dimension of a value's numbers; `None` for values without such numbers.
    pub fn dimension(&self) -> Option<Dimension> {
        match self {
            Self::Quantity { dimension, .. } | Self::Range { dimension, .. } | Self::Distribution { dimension, .. } => {
                Some(*dimension)
            }
            Self::Point | Self::WordOrPoint(_) | Self::Pose => Some(Dimension::LENGTH),
            Self::List(inner) => inner.dimension(),
            _ => None,
        }
    }

    /// The words that it accepts, or that a member of it is; empty for types without words.
    pub fn words(&self) -> &[&'static str] {
        match self {
            Self::Choice(words) | Self::Step(words) | Self::WordOrPoint(words) => words,
            Self::WordOrReference(words, _) => words,
            Self::List(item) => item.words(),
            _ => &[],
        }
    }

    /// A quantity of any size.
    pub fn any(dimension: Dimension) -> Self {
        Self::Quantity { dimension, min: f64::NEG_INFINITY, max: f64::INFINITY }
    }

    /// A quantity that is not negative.
    pub fn non_negative(dimension: Dimension) -> Self {
        Self::Quantity { dimension, min: 0.0, max: MAX_MAGNITUDE }
    }

    /// A quantity above zero.
    pub fn positive(dimension: Dimension) -> Self {
        Self::Quantity { dimension, min: MIN_POSITIVE, max: MAX_MAGNITUDE }
    }

    /// A quantity within inclusive bounds in SI.
    pub fn within(dimension: Dimension, min: f64, max: f64) -> Self {
        Self::Quantity { dimension, min, max }
    }

    /// A plain number from 0 to 1.
    pub fn share() -> Self {
        Self::within(Dimension::RATIO, 0.0, 1.0)
    }

    /// A range between inclusive bounds in SI.
    pub fn range(dimension: Dimension, min: f64, max: f64) -> Self {
        Self::Range { dimension, min, max }
    }

    /// A distribution between inclusive bounds in SI.
    pub fn drawn(dimension: Dimension, min: f64, max: f64) -> Self {
        Self::Distribution { dimension, min, max }
    }

    /// A whole number in inclusive bounds.
    pub fn whole(min: i64, max: i64) -> Self {
        Self::Integer { min, max }
    }

    /// A whole number of ticks in inclusive bounds.
    pub fn ticks(min: i64, max: i64) -> Self {
        Self::Ticks { min, max }
    }

    /// Its name for users, with its bounds if it has any.
    pub fn describe_bounded(&self) -> String {
        match self {
            Type::Quantity { dimension, min, max }
            | Type::Range { dimension, min, max }
            | Type::Distribution { dimension, min, max }
                if *min > f64::NEG_INFINITY || *max < f64::INFINITY =>
            {
                format!("{}, {}", self.describe(), bounds(*min, *max, *dimension))
            }
            Type::List(item) => format!("list, each {}", item.describe_bounded()),
            other => other.describe(),
        }
    }

    /// Its name for users.
    pub fn describe(&self) -> String {
        match self {
            Type::Quantity { dimension, .. } => with_units(*dimension, &dimension.to_string()),
            Type::Range { dimension, .. } => with_units(*dimension, &format!("range of {dimension}")),
            Type::Distribution { dimension, .. } => {
                with_units(*dimension, &format!("{dimension}, range or distribution"))
            }
            Type::Integer { min, max } if *max == i64::MAX => format!("whole number from {min}"),
            Type::Integer { min, max } => format!("whole number from {min} to {max}"),
            Type::Ticks { min, max } => format!("whole number of ticks from {min} to {max}"),
            Type::Boolean => "`true` or `false`".into(),
            Type::Choice(words) | Type::Step(words) => format!("one of {}", words.join(", ")),
            Type::Text => "text in quotes".into(),
            Type::Path => "path in quotes".into(),
            Type::Point => "point `(x, y)`".into(),
            Type::WordOrPoint(words) => format!("{}, or point `(x, y)`", words.join(", ")),
            Type::Pose => "pose `(x, y, yaw)`".into(),
            Type::Reference(form) if form.starts_with(['a', 'e', 'i', 'o']) => format!("name of an {form}"),
            Type::Reference(form) => format!("name of a {form}"),
            Type::WordOrReference(words, form) => format!("one of {}, or the name of a {form}", words.join(", ")),
            Type::List(item) => format!("list, each {}", item.describe()),
            Type::Condition(_) => "condition".into(),
            Type::Formula(_) => "formula of a plain number".into(),
            Type::Requirement(_) => "condition in temporal logic".into(),
        }
    }
}

/// Bounds in SI as a user would write them.
pub fn bounds(min: f64, max: f64, dimension: Dimension) -> String {
    // Bounds are shown in degrees for angles, as a user would write them.
    let (scale, name) = match dimension {
        Dimension::RATIO => (1.0, ""),
        Dimension::ANGLE => (std::f64::consts::PI / 180.0, " deg"),
        _ => (1.0, dimension.usual_units().first().copied().unwrap_or("")),
    };
    let shown = |bound: f64| format!("{} {}", short(bound / scale), name.trim()).trim().to_string();
    match (min, max) {
        (MIN_POSITIVE, max) if max >= MAX_MAGNITUDE => format!("above {}", shown(0.0)),
        (MIN_POSITIVE, max) => format!("above {}, at most {}", shown(0.0), shown(max)),
        (min, max) if max >= MAX_MAGNITUDE => format!("{} or more", shown(min)),
        (min, max) if min <= -MAX_MAGNITUDE => format!("{} or less", shown(max)),
        (min, max) => format!("{} to {}", shown(min), shown(max)),
    }
}

/// A number with few digits.
pub fn short(number: f64) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        format!("{number:e}")
    } else {
        format!("{}", (number * 1e9).round() / 1e9)
    }
}

fn with_units(dimension: Dimension, name: &str) -> String {
    match dimension.usual_units() {
        [] => name.to_string(),
        units => format!("{name} [{}]", units.join(", ")),
    }
}
