use crate::tables::{Cell, Metric};
use std::fmt;

use crate::report::Rate;

/// A value of a table. `Display` gives its text; Markdown and HTML add markup for code, links and lines.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Words.
    Text(String),
    /// Words that a reader may copy: a name, a command.
    Code(String),
    /// Words with a link: text, and the file in the folder of the report.
    Link(String, String),
    Count(u64),
    /// A count of a total.
    Of(u64, u64),
    /// Number of runs, and the amount of each of them.
    Times(u64, u64),
    /// A number, and its number of digits after the point.
    Number(Option<f64>, usize),
    /// A mean with its standard deviation.
    Spread(Option<f64>, Option<f64>),
    Interval(Option<(f64, f64)>),
    /// A number with its interval, and their number of digits after the point.
    Estimate(Option<f64>, Option<(f64, f64)>, usize),
    /// The same for a difference, with its sign.
    Difference(Option<f64>, Option<(f64, f64)>),
    /// The values of single runs, too few for an interval, their number of digits after the point, and whether they are differences with a sign.
    Runs(Vec<f64>, usize, bool),
    /// A share of a whole.
    Percent(f64),
    Warning(String),
    /// Words on a colour of the page's style sheet: `green`, `yellow`, `orange`, `brown` or `red`.
    Toned(String, &'static str),
    /// The name of a failure. The page leads to its player.
    Failure(String),
    /// A value that a failure made, and the name of the failure.
    Played(Box<Self>, String),
    /// A value, and what it became.
    Change(Box<Value>, Box<Value>),
    /// Several values below each other.
    Lines(Vec<Value>),
}

/// Shown in place of a missing value.
const NONE: &str = "–";

/// Below this a rate would be printed as 0.00.
const RARE: f64 = 0.005;

impl Value {
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
            return Self::Text(format!("{part} of {whole} (below {bound:.digits$})"));
        }
        Self::or_count(Self::Estimate(rate.value, rate.interval, 2), rate.value, part, whole)
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
            (None, 2..) => Self::Runs(rate.by_run.clone(), digits, false),
            (interval, _) => Self::Estimate(rate.value, interval, digits),
        }
    }
}

/// The digits after the point that show the ends of an interval of this width apart.
pub(super) fn digits(width: f64) -> usize {
    match width {
        0.000_1..0.005 => 4,
        0.005..0.05 => 3,
        _ => 2,
    }
}

/// A number to two digits, a large one in powers of ten.
fn short(number: f64) -> String {
    if number.abs() < 1e5 { format!("{number:.2}") } else { format!("{number:.2e}") }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text)
            | Self::Code(text)
            | Self::Failure(text)
            | Self::Link(text, _)
            | Self::Warning(text)
            | Self::Toned(text, _) => f.write_str(text),
            Self::Played(value, _) => value.fmt(f),
            Self::Count(count) => write!(f, "{count}"),
            Self::Of(part, whole) => write!(f, "{part} of {whole}"),
            Self::Times(runs, each) => write!(f, "{runs} × {each}"),
            Self::Number(Some(number), digits) => write!(f, "{number:.digits$}"),
            Self::Spread(Some(mean), None) => f.write_str(&short(*mean)),
            Self::Spread(Some(mean), Some(sd)) => write!(f, "{} ± {}", short(*mean), short(*sd)),
            Self::Interval(Some((_, high))) if *high < RARE => f.write_str("< 0.01"),
            Self::Interval(Some((low, high))) => write!(f, "{low:.2}..{high:.2}"),
            Self::Estimate(Some(number), None, digits) => write!(f, "{number:.digits$}"),
            // Runs that are all equal, as those of deterministic controllers, show no spread.
            Self::Estimate(Some(number), Some((low, high)), digits) if low == high => {
                write!(f, "{number:.digits$} (all alike)")
            }
            Self::Estimate(Some(number), Some((low, high)), digits) => {
                write!(f, "{number:.digits$} ({low:.digits$}..{high:.digits$})")
            }
            Self::Difference(Some(number), None) => write!(f, "{number:+.2}"),
            Self::Difference(Some(number), Some((low, high))) => {
                let digits = digits(high - low);
                write!(f, "{number:+.digits$} ({low:+.digits$}..{high:+.digits$})")
            }
            Self::Runs(values, digits, signed) => {
                let value =
                    |value: &f64| if *signed { format!("{value:+.digits$}") } else { format!("{value:.digits$}") };
                let each: Vec<String> = values.iter().map(value).collect();
                write!(f, "{} ({} runs)", each.join(" "), values.len())
            }
            Self::Percent(share) => write!(f, "{:.0} %", 100.0 * share),
            Self::Change(before, after) => write!(f, "{before} → {after}"),
            Self::Lines(lines) => {
                let texts: Vec<String> = lines.iter().map(Self::to_string).collect();
                f.write_str(&texts.join("; "))
            }
            Self::Number(None, _)
            | Self::Spread(None, _)
            | Self::Interval(None)
            | Self::Estimate(None, ..)
            | Self::Difference(None, _) => f.write_str(NONE),
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<&String> for Value {
    fn from(text: &String) -> Self {
        Self::Text(text.clone())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&Rate> for Value {
    fn from(rate: &Rate) -> Self {
        Self::Spread(rate.value, rate.sd)
    }
}
