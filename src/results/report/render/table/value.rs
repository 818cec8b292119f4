use std::fmt;

use crate::tables::{Cell, Metric, Rate};

/// A value of a table. `Display` gives its text; Markdown and HTML add markup for marks and lines.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Words.
    Text(String, Mark),
    Count(u64),
    /// A count of a total.
    Of(u64, u64),
    /// Number of runs, and the amount of each of them.
    Times(u64, u64),
    /// A share of a whole.
    Percent(f64),
    Number(Number),
    /// A value that a failure made, and the name of the failure.
    Played(Box<Self>, String),
    /// A value, and what it became.
    Change(Box<Value>, Box<Value>),
    /// Several values below each other.
    Lines(Vec<Value>),
}

/// How words are shown.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Mark {
    #[default]
    Plain,
    /// A reader may copy them: a name, a command.
    Code,
    /// With a link to this file in the folder of the report.
    Link(String),
    Warning,
    /// On a colour of the page's style sheet: `green`, `yellow`, `orange`, `brown` or `red`.
    Tone(&'static str),
    /// The name of a failure. The page leads to its player.
    Failure,
}

/// A number, and how sure it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Number {
    /// `None` of an interval that stands alone, of single runs, and where it is missing.
    value: Option<f64>,
    spread: Spread,
    /// The digits after the point; `None` for as many as show the ends of the interval apart.
    digits: Option<usize>,
    /// Whether it is a difference, which has a sign.
    is_signed: bool,
}

/// What is known of a number besides.
#[derive(Debug, Clone, PartialEq, Default)]
enum Spread {
    #[default]
    None,
    Deviation(f64),
    Interval(f64, f64),
    /// The values of single runs, too few for an interval.
    Runs(Vec<f64>),
}

/// Shown in place of a missing value.
const NONE: &str = "–";

/// Below this a rate would be printed as 0.00.
const RARE: f64 = 0.005;

impl Value {
    pub fn text(words: impl Into<String>) -> Self {
        Self::Text(words.into(), Mark::Plain)
    }

    pub fn code(words: impl Into<String>) -> Self {
        Self::Text(words.into(), Mark::Code)
    }

    pub fn warning(words: impl Into<String>) -> Self {
        Self::Text(words.into(), Mark::Warning)
    }

    pub fn failure(name: impl Into<String>) -> Self {
        Self::Text(name.into(), Mark::Failure)
    }

    pub fn number(value: Option<f64>, digits: usize) -> Self {
        Self::Number(Number { value, digits: Some(digits), ..Number::default() })
    }

    /// The ends of an interval alone.
    pub fn interval(ends: Option<(f64, f64)>) -> Self {
        Self::Number(Number { spread: Spread::of(ends), digits: Some(2), ..Number::default() })
    }

    /// A number with its interval, and their number of digits after the point.
    pub fn estimate(value: Option<f64>, ends: Option<(f64, f64)>, digits: usize) -> Self {
        Self::Number(Number { value, spread: Spread::of(value.and(ends)), digits: Some(digits), ..Number::default() })
    }

    /// A difference with its interval.
    pub fn difference(value: Option<f64>, ends: Option<(f64, f64)>) -> Self {
        Self::Number(Number { value, spread: Spread::of(value.and(ends)), digits: None, is_signed: true })
    }

    /// The values of single runs, their number of digits after the point, and whether they are differences with a sign.
    pub fn runs(values: Vec<f64>, digits: usize, is_signed: bool) -> Self {
        Self::Number(Number { value: None, spread: Spread::Runs(values), digits: Some(digits), is_signed })
    }

    /// A metric of a cell by its role: a count, a share with its interval, a mean with the deviation of the runs.
    pub fn metric(cell: &Cell, metric: &Metric) -> Self {
        match () {
            () if metric.is_count() => cell.count(metric).into(),
            () if metric.is_share() => Self::share(cell, metric),
            () => (&cell.rate(metric)).into(),
        }
    }

    /// A rate with its interval; the number of `whole` episodes and the upper end of the interval if the rate is too small for two digits.
    pub fn share(cell: &Cell, metric: &Metric) -> Self {
        Self::rate(&cell.rate(metric), cell.part(metric), cell.whole(metric))
    }

    /// The same of a rate of `whole` episodes.
    pub fn rate(rate: &Rate, part: u32, whole: u32) -> Self {
        if let (Some(..RARE), Some((_, high))) = (rate.value, rate.interval) {
            // Rounded up: it is a bound.
            let (digits, steps) = if high < 0.01 { (4, 1e4) } else { (2, 1e2) };
            let bound = (high * steps).ceil() / steps;
            return format!("{part} of {whole} (below {bound:.digits$})").into();
        }
        Self::or_count(Self::estimate(rate.value, rate.interval, 2), rate.value, part, whole)
    }

    /// A rate with its standard deviation; the number of `whole` episodes if the rate is too small for two digits.
    pub fn spread(cell: &Cell, metric: &Metric) -> Self {
        let rate = cell.rate(metric);
        Self::or_count((&rate).into(), rate.value, cell.part(metric), cell.whole(metric))
    }

    /// A rate of `whole` episodes, or their number if it is too small for two digits.
    pub fn or_count(rate: Self, mean: Option<f64>, part: u32, whole: u32) -> Self {
        match mean {
            Some(mean) if mean < RARE => Self::Of(part.into(), whole.into()),
            _ => rate,
        }
    }

    /// A mean over runs with its interval; of two or three runs the single values.
    pub fn average(rate: &Rate, digits: usize) -> Self {
        match (rate.interval, rate.by_run.len()) {
            (None, 2..) => Self::runs(rate.by_run.clone(), digits, false),
            (interval, _) => Self::estimate(rate.value, interval, digits),
        }
    }
}

impl Spread {
    fn of(ends: Option<(f64, f64)>) -> Self {
        ends.map_or(Self::None, |(low, high)| Self::Interval(low, high))
    }
}

impl Number {
    /// A number with its digits and its sign; a large one in powers of ten, unless the digits are stated.
    fn text(&self, number: f64) -> String {
        let digits = match (self.digits, &self.spread) {
            (Some(digits), _) => digits,
            (None, Spread::Interval(low, high)) => digits(high - low),
            (None, _) => 2,
        };
        match self.is_signed {
            true => format!("{number:+.digits$}"),
            false if self.digits.is_none() && number.abs() >= 1e5 => format!("{number:.2e}"),
            false => format!("{number:.digits$}"),
        }
    }

    /// The number and the ends of its interval; `None` without both. Runs that are all equal, as those of deterministic controllers, show no spread.
    pub(super) fn with_ends(&self) -> Option<(String, String)> {
        match (self.value, &self.spread) {
            (Some(value), Spread::Interval(low, high)) if low != high || self.is_signed => {
                Some((self.text(value), format!("{}..{}", self.text(*low), self.text(*high))))
            }
            _ => None,
        }
    }
}

/// The digits after the point that show the ends of an interval of this width apart.
fn digits(width: f64) -> usize {
    match width {
        0.000_1..0.005 => 4,
        0.005..0.05 => 3,
        _ => 2,
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((number, ends)) = self.with_ends() {
            return write!(f, "{number} ({ends})");
        }
        match (self.value, &self.spread) {
            (_, Spread::Runs(values)) => {
                let each: Vec<String> = values.iter().map(|value| self.text(*value)).collect();
                write!(f, "{} ({} runs)", each.join(" "), values.len())
            }
            (Some(value), Spread::None) => f.write_str(&self.text(value)),
            (Some(value), Spread::Deviation(sd)) => write!(f, "{} ± {}", self.text(value), self.text(*sd)),
            (Some(value), Spread::Interval(..)) => write!(f, "{} (all alike)", self.text(value)),
            (None, Spread::Interval(_, high)) if *high < RARE => f.write_str("< 0.01"),
            (None, Spread::Interval(low, high)) => write!(f, "{}..{}", self.text(*low), self.text(*high)),
            (None, _) => f.write_str(NONE),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(words, _) => f.write_str(words),
            Self::Count(count) => write!(f, "{count}"),
            Self::Of(part, whole) => write!(f, "{part} of {whole}"),
            Self::Times(runs, each) => write!(f, "{runs} × {each}"),
            Self::Percent(share) => write!(f, "{:.0} %", 100.0 * share),
            Self::Number(number) => number.fmt(f),
            Self::Played(value, _) => value.fmt(f),
            Self::Change(before, after) => write!(f, "{before} → {after}"),
            Self::Lines(lines) => {
                let texts: Vec<String> = lines.iter().map(Self::to_string).collect();
                f.write_str(&texts.join("; "))
            }
        }
    }
}

/// Words and counts as they are; a value that is missing is a dash.
macro_rules! from {
    ($($of:ty => $value:expr),*) => {
        $(impl From<$of> for Value {
            fn from(value: $of) -> Self {
                $value(value)
            }
        })*
    };
}

from!(&str => Self::text, &String => Self::text, String => Self::text, u64 => Self::Count);
from!(u32 => |count| Self::Count(u64::from(count)), usize => |count| Self::Count(count as u64));

impl<V: Into<Self>> From<Option<V>> for Value {
    fn from(value: Option<V>) -> Self {
        value.map_or(Self::Number(Number::default()), Into::into)
    }
}

impl From<&Rate> for Value {
    fn from(rate: &Rate) -> Self {
        let spread = rate.sd.map_or(Spread::None, Spread::Deviation);
        Self::Number(Number { value: rate.value, spread, ..Number::default() })
    }
}
