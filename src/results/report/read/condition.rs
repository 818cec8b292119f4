use crate::record::{ColumnReference, Role};
use crate::report::infer::{BEATS_UNTRAINED, BeatsUntrained};
use crate::report::metric_table::TRAININGS_DISAGREE;
use crate::tables::METRICS;
use crate::tables::metrics::MEAN;
use crate::tables::{FIRST_FAILURE, FIRST_FAULT};

/// Why a gate is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GateError {
    #[error(
        "`{text}` is not a condition: write COLUMN, one of < <= > >= == !=, and a number; `and` joins several, `max over pedestrians COLUMN` takes the greatest of a place"
    )]
    Form { text: String },
    #[error("`{text}`: `and` joins conditions, and nothing else does; for `or` write several gates")]
    Joined { text: String },
    #[error("nothing that a gate can judge is called `{name}`; {}", nearest.as_ref().map_or_else(|| "reports/README.md lists the metrics".to_string(), |near| format!("did you mean `{near}`?")))]
    Column { name: String, nearest: Option<String> },
    #[error("`{text}` matches no row: {reason}")]
    AboutNothing { text: String, reason: String },
    #[error(
        "`{text}` has `over pedestrians` more than once: which pedestrian would the others be about? Write several gates"
    )]
    Extremes { text: String },
    #[error("`{name}` holds {holds}: {advice}")]
    Kind { name: String, holds: &'static str, advice: String },
    #[error("`{text}` can never be true: no value of `{name}` is as it says")]
    Never { text: String, name: String },
}

/// A part of a gate: a column, a sign, and a number or a word.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condition {
    /// Whether the cell is that of the greatest or least value of the column in its place.
    pub over: Option<Extreme>,
    pub column: ColumnReference,
    /// Of an end of an interval, the columns that answer nearly the same question, the nearest first.
    pub instead: Vec<String>,
    /// Of an adjusted probability, the columns of the pairs in which its figure differs.
    pub differing: Vec<String>,
    pub comparison: Comparison,
    pub bound: Bound,
    /// The least and the greatest value that the column can have.
    range: (f64, f64),
    /// Whether it chooses cells by a word of their key, instead of judging a result.
    pub chooses: bool,
    /// Whether the column has no value where nothing collided, which is not a reason to fail.
    pub is_of_collisions: bool,
}

/// Which controller of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extreme {
    Max,
    Min,
}

impl Extreme {
    /// What comes before the column.
    const WORDS: [(&str, Self); 2] = [("max over pedestrians ", Self::Max), ("min over pedestrians ", Self::Min)];
}

/// How a value is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Unequal,
}

/// What a value is compared with.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Bound {
    Number(f64),
    Word(String),
}

/// The signs, the longer ones first.
const SIGNS: [(&str, Comparison); 6] = [
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("==", Comparison::Equal),
    ("!=", Comparison::Unequal),
    ("<", Comparison::Less),
    (">", Comparison::More),
];

/// A value this near to a bound is the bound: a mean of 0.04, 0.05 and 0.06 is a little more than 0.05.
const ROUNDING: f64 = 1e-12;

impl Comparison {
    /// Whether it is true of a value.
    pub fn holds(self, value: f64, bound: f64) -> bool {
        let value = if (value - bound).abs() <= ROUNDING { bound } else { value };
        match self {
            Self::Less => value < bound,
            Self::AtMost => value <= bound,
            Self::More => value > bound,
            Self::AtLeast => value >= bound,
            Self::Equal => value == bound,
            Self::Unequal => value != bound,
        }
    }
}

impl Condition {
    /// Whether a word is as the condition says.
    pub fn is_true_of(&self, found: &str, word: &str) -> bool {
        (found == word) == (self.comparison == Comparison::Equal)
    }

    /// Parses a part of a gate on these columns.
    ///
    /// # Errors
    /// It has another form, or names no column.
    pub fn parse(text: &str, columns: &[ColumnReference]) -> Result<Self, GateError> {
        let form = || GateError::Form { text: text.trim().to_string() };
        let over =
            Extreme::WORDS.iter().find_map(|(words, over)| Some((text.trim_start().strip_prefix(words)?, *over)));
        let (text, over) = over.map_or((text, None), |(rest, over)| (rest, Some(over)));
        let at = text.find(['<', '>', '=', '!']).ok_or_else(form)?;
        let (sign, comparison) = SIGNS.into_iter().find(|(sign, _)| text[at..].starts_with(sign)).ok_or_else(form)?;
        let (name, bound) = (text[..at].trim(), text[at + sign.len()..].trim());
        if name.is_empty() || bound.is_empty() || name.contains(' ') {
            return Err(form());
        }
        // Metrics of runs have their mean in the table of cells.
        let names = [name.to_string(), MEAN.name(name)];
        let column = names.iter().find_map(|name| columns.iter().find(|column| column.name == *name));
        let column = column.ok_or_else(|| unknown(name, columns))?;
        let kind = |holds, advice: &str| GateError::Kind { name: name.to_string(), holds, advice: advice.into() };
        let role = value_of_figure(column, columns).map_or(column.role, |value| value.role);
        let bound = if column.holds.is_string() {
            if !matches!(comparison, Comparison::Equal | Comparison::Unequal) {
                return Err(kind("words", "compare it by == or !="));
            }
            if over.is_some() {
                return Err(kind("words", "only numbers have a greatest or least value"));
            }
            Bound::Word(bound.trim_matches(['"', '\'']).to_string())
        } else {
            let number = bound.parse().ok().filter(|number: &f64| number.is_finite());
            let number = number.ok_or_else(|| kind("numbers", "compare it with a number, without a unit"))?;
            // More than a whole is never true, and would pass for ever.
            let is_out_of_reach = number.abs() > 1.0 || number == 1.0 && comparison == Comparison::More;
            match role {
                Role::Share | Role::ShareDifference | Role::RunShare if is_out_of_reach => {
                    return Err(kind("shares from 0 to 1", "write 5 % as 0.05, 1 % as 0.01"));
                }
                Role::Risk if is_out_of_reach => {
                    let advice = "write 5 in 1,000 episodes as 0.005";
                    return Err(kind("severe injuries of one episode, from 0 to 1", advice));
                }
                _ => {}
            }
            Bound::Number(number)
        };
        let known: Option<Vec<&str>> = match &*column.name {
            name if name == BEATS_UNTRAINED.name => {
                Some(BeatsUntrained::ALL.iter().map(|answer| answer.name()).collect())
            }
            name if name == TRAININGS_DISAGREE.name => Some(vec!["yes", "no"]),
            _ => None,
        };
        if let (Bound::Word(word), Some(known)) = (&bound, &known)
            && !known.contains(&word.as_str())
        {
            return Err(kind("words", &format!("write one of {}", known.join(", "))));
        }
        let chooses = matches!(bound, Bound::Word(_)) && known.is_none();
        let range = match role {
            Role::Share | Role::RunShare | Role::Risk | Role::AdjustedP => (0.0, 1.0),
            Role::ShareDifference => (-1.0, 1.0),
            Role::Deviation => (0.0, f64::INFINITY),
            _ if column.holds.is_unsigned_integer() => (0.0, f64::INFINITY),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let is_of_collisions = is_of_collisions(&column.figure);
        let of_figure = |other: &&ColumnReference| other.figure == column.figure && other.name != column.name;
        let of_role = |role: Role| columns.iter().filter(of_figure).find(|other| other.role == role);
        let others = [of_role(column.role), of_role(Role::AdjustedP), value_of_figure(column, columns)];
        let others = others.into_iter().flatten().filter(|_| is_end(column));
        let instead = others.map(|other| other.name.to_string()).collect();
        let differing = columns.iter().filter(of_figure).filter(|other| other.role == Role::Differing);
        let differing = differing.filter(|_| column.role == Role::AdjustedP).map(|other| other.name.to_string());
        let differing = differing.collect();
        let column = column.clone();
        Ok(Self { over, column, instead, differing, comparison, bound, range, chooses, is_of_collisions })
    }

    /// Whether it judges a result that only trainings have.
    pub fn is_of_trainings(&self) -> bool {
        matches!(self.bound, Bound::Word(_)) && !self.chooses
    }

    /// Whether some value of its column is as all of these say that are about this column.
    pub fn can_hold_with(&self, all: &[Self]) -> bool {
        let own = || all.iter().filter(|other| other.column.name == self.column.name);
        let words = own().filter_map(|each| if let Bound::Word(word) = &each.bound { Some(&**word) } else { None });
        if words.chain([""]).any(|word| {
            let is_true = |each: &Self| matches!(&each.bound, Bound::Word(of) if each.is_true_of(word, of));
            own().all(is_true)
        }) {
            return true;
        }
        let mut ends: Vec<f64> =
            own().filter_map(|each| if let Bound::Number(bound) = each.bound { Some(bound) } else { None }).collect();
        let (least, greatest) = self.range;
        ends.extend([least, greatest].into_iter().filter(|end| end.is_finite()));
        ends.sort_by(f64::total_cmp);
        // Between two ends all values are alike.
        let between = ends.windows(2).map(|pair| f64::midpoint(pair[0], pair[1]));
        let beyond = ends.iter().flat_map(|end| [*end, end - 1.0, end + 1.0]);
        let round = |value: f64| if self.column.holds.is_unsigned_integer() { value.floor() } else { value };
        let mut values = between.chain(beyond).map(round).filter(|value| (least..=greatest).contains(value));
        values.any(|value| {
            own().all(|each| matches!(each.bound, Bound::Number(bound) if each.comparison.holds(value, bound)))
        })
    }
}

/// Whether a column has the ends of an interval.
pub(super) fn is_end(column: &ColumnReference) -> bool {
    matches!(column.role, Role::LowerBound | Role::UpperBound)
}

/// The column with the values of the figure of a column of interval ends; `None` of other columns. The interval of a comparison is that of the difference.
fn value_of_figure<'a>(column: &ColumnReference, columns: &'a [ColumnReference]) -> Option<&'a ColumnReference> {
    let of_figure = |other: &&ColumnReference| is_end(column) && other.figure == column.figure;
    let of_role = |role: Role| columns.iter().filter(of_figure).find(|other| other.role == role);
    [Role::ShareDifference, Role::Plain, Role::Share, Role::Risk].into_iter().find_map(of_role)
}

/// Whether a figure of cells or searches has no value where there was no collision.
fn is_of_collisions(figure: &str) -> bool {
    let mut of_metrics = METRICS.into_iter().filter(|metric| metric.is_of_collisions());
    [FIRST_FAILURE, FIRST_FAULT].contains(&figure) || of_metrics.any(|metric| metric.name == figure)
}

fn unknown(name: &str, columns: &[ColumnReference]) -> GateError {
    // A mean has the name of its metric, too.
    let suffix = MEAN.name("");
    let columns = columns.iter().map(|column| column.name.strip_suffix(&*suffix).unwrap_or(&column.name).to_string());
    let distance = |column: &String| strsim::damerau_levenshtein(name, column);
    // A rate of a requirement is written with its name.
    let of_requirement =
        columns.clone().find(|column| column.strip_prefix(name).is_some_and(|rest| rest.starts_with('(')));
    let near = columns.clone().min_by_key(distance).filter(|column| distance(column) <= name.len().div_ceil(3));
    let nearest =
        of_requirement.or(near).or_else(|| columns.clone().find(|column| !name.is_empty() && column.starts_with(name)));
    GateError::Column { name: name.to_string(), nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn injuries_of_a_thousand_crossings_may_be_more_than_one() {
        let parsed = |text: &str| Condition::parse(text, &crate::report::crossed_reference().columns);
        assert!(parsed("avoidable_injury_after > 2.5").is_ok() && parsed("fault_share_after > 2.5").is_err());
    }

    #[test]
    fn a_mean_that_is_the_bound_but_for_its_last_bits_is_the_bound() {
        assert!(
            !Comparison::More.holds(0.05000000000000001, 0.05) && Comparison::AtLeast.holds(0.049999999999999996, 0.05)
        );
        assert!(Comparison::More.holds(0.0500001, 0.05));
    }
}
