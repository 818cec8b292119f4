use polars::prelude::{AnyValue, DataFrame};

use crate::record::metric::MEAN;
use crate::record::{ColumnReference, metrics};
use crate::report::aggregate::{references, search_cell_columns};

/// A condition under which a run fails, as `preventable_rate > 0.05 and town == village`. It is about the table `cells`, or about `search_cells`
/// when it names a column that only that table has.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    text: String,
    about_searches: bool,
    conditions: Vec<Condition>,
}

/// Why a gate is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GateError {
    /// It is not of the form `COLUMN < NUMBER`.
    #[error("`{text}` is no condition: write COLUMN, one of < <= > >= == !=, and a number; `and` joins several")]
    Form {
        /// Its text.
        text: String,
    },
    /// The table of cells has no such column.
    #[error("`cells` has no column `{name}`{}; it has {}", nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")), columns.join(", "))]
    Column {
        /// The name that was written.
        name: String,
        /// A suggestion for it.
        nearest: Option<String>,
        /// All columns.
        columns: Vec<String>,
    },
    /// A number is compared with a word, or words with an order.
    #[error("`{name}` holds {holds}: {advice}")]
    Kind {
        /// The column.
        name: String,
        /// The kind of its values.
        holds: &'static str,
        /// The valid forms.
        advice: &'static str,
    },
}

/// The result of a gate for a cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Judged {
    /// The condition is false.
    Passed,
    /// The condition is true; the values that it used.
    Broken(Vec<(String, f64)>),
    /// A column has no value there, so the condition cannot be evaluated.
    Missing(String),
    /// The gate is about other cells.
    Elsewhere,
}

#[derive(Debug, Clone, PartialEq)]
struct Condition {
    column: String,
    comparison: Comparison,
    bound: Bound,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Unequal,
}

#[derive(Debug, Clone, PartialEq)]
enum Bound {
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

impl Comparison {
    fn holds(self, value: f64, bound: f64) -> bool {
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

impl Gate {
    /// Parses a gate. Its columns are looked up in the tables of cells and of searches, which are the same for all campaigns.
    ///
    /// # Errors
    /// It has another form, or names no column.
    pub fn parse(text: &str) -> Result<Self, GateError> {
        let [_, cells] = references(&metrics());
        let parse = |columns: &[ColumnReference]| -> Result<Vec<Condition>, GateError> {
            text.split(" and ").map(|part| Condition::parse(part, columns)).collect()
        };
        let gate = |conditions, about_searches| Self { text: text.trim().to_string(), about_searches, conditions };
        match parse(&cells.columns) {
            Ok(conditions) => Ok(gate(conditions, false)),
            Err(error @ GateError::Column { .. }) => match parse(&search_cell_columns().reference().columns) {
                Ok(conditions) => Ok(gate(conditions, true)),
                Err(GateError::Column { .. }) => Err(error),
                Err(other) => Err(other),
            },
            Err(error) => Err(error),
        }
    }

    /// Its text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it is about the table `search_cells`.
    pub fn is_about_searches(&self) -> bool {
        self.about_searches
    }

    /// Judges every cell of the table that it is about, in its order.
    pub fn judge(&self, cells: &DataFrame) -> Vec<Judged> {
        (0..cells.height()).map(|row| self.judge_cell(cells, row)).collect()
    }

    fn judge_cell(&self, cells: &DataFrame, row: usize) -> Judged {
        let value = |column: &str| cells.column(column).and_then(|column| column.get(row)).unwrap_or(AnyValue::Null);
        let (mut looked_at, mut missing, mut holds) = (Vec::new(), None, true);
        for condition in &self.conditions {
            match (&condition.bound, value(&condition.column)) {
                (Bound::Word(word), found) => {
                    let equal = found.get_str() == Some(word);
                    if equal != (condition.comparison == Comparison::Equal) {
                        return Judged::Elsewhere;
                    }
                }
                (Bound::Number(bound), found) => match found.extract::<f64>().filter(|number| !number.is_nan()) {
                    Some(number) => {
                        holds &= condition.comparison.holds(number, *bound);
                        looked_at.push((condition.column.clone(), number));
                    }
                    None => missing = missing.or(Some(condition.column.clone())),
                },
            }
        }
        match missing {
            _ if !holds => Judged::Passed,
            Some(column) => Judged::Missing(column),
            None => Judged::Broken(looked_at),
        }
    }
}

impl Condition {
    fn parse(text: &str, columns: &[ColumnReference]) -> Result<Self, GateError> {
        let form = || GateError::Form { text: text.trim().to_string() };
        let at = text.find(['<', '>', '=', '!']).ok_or_else(form)?;
        let (sign, comparison) = SIGNS.into_iter().find(|(sign, _)| text[at..].starts_with(sign)).ok_or_else(form)?;
        let (name, bound) = (text[..at].trim(), text[at + sign.len()..].trim());
        if name.is_empty() || bound.is_empty() {
            return Err(form());
        }
        // Metrics of runs have their mean in the table of cells.
        let names = [name.to_string(), MEAN.name(name)];
        let column = names.iter().find_map(|name| columns.iter().find(|column| column.name == *name));
        let column = column.ok_or_else(|| unknown(name, columns))?;
        let kind = |holds, advice| GateError::Kind { name: name.to_string(), holds, advice };
        let bound = if column.holds.is_string() {
            if !matches!(comparison, Comparison::Equal | Comparison::Unequal) {
                return Err(kind("words", "compare it by == or !="));
            }
            Bound::Word(bound.trim_matches(['"', '\'']).to_string())
        } else {
            let number = bound.parse().ok().filter(|number: &f64| number.is_finite());
            Bound::Number(number.ok_or_else(|| kind("numbers", "compare it with a number, without a unit"))?)
        };
        Ok(Self { column: column.name.to_string(), comparison, bound })
    }
}

fn unknown(name: &str, columns: &[ColumnReference]) -> GateError {
    let columns: Vec<String> = columns.iter().map(|column| column.name.to_string()).collect();
    let suffix = MEAN.name("");
    let bare = |column: &str| column.strip_suffix(&suffix).unwrap_or(column).to_string();
    let distance = |column: &&String| strsim::damerau_levenshtein(name, &bare(column));
    let near = columns.iter().min_by_key(distance).filter(|column| distance(column) <= name.len().div_ceil(3));
    let nearest = near.or_else(|| columns.iter().find(|column| !name.is_empty() && column.starts_with(name))).cloned();
    GateError::Column { name: name.to_string(), nearest, columns }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_searches_alone_makes_a_gate_about_searches() {
        let about = |text: &str| Gate::parse(text).map(|gate| gate.is_about_searches());
        assert_eq!(about("attributable_failures > 0 and town == village"), Ok(true));
        assert_eq!(about("preventable_rate > 0 and town == village"), Ok(false));
        assert_eq!(about("town == village"), Ok(false), "a column of both");
        assert!(matches!(about("attributable_failures > much"), Err(GateError::Kind { .. })));
        let mixed = about("attributable_failures > 0 and preventable_rate > 0");
        assert!(matches!(mixed, Err(GateError::Column { name, .. }) if name == "attributable_failures"));
    }
    use polars::prelude::{Column, NamedFrom, Series};

    fn cells() -> DataFrame {
        let rates: Vec<Option<f64>> = vec![Some(0.04), Some(0.06), None];
        let columns: Vec<Column> = vec![
            Series::new("town".into(), ["harbour", "village", "village"]).into(),
            Series::new("preventable_rate".into(), rates).into(),
            Series::new("errors".into(), [0_u32, 0, 3]).into(),
        ];
        DataFrame::new(3, columns).unwrap()
    }

    fn judged(text: &str) -> String {
        let letter = |judged: &Judged| match judged {
            Judged::Passed => 'p',
            Judged::Broken(_) => 'b',
            Judged::Missing(_) => 'm',
            Judged::Elsewhere => 'e',
        };
        let said = |column: &Column| ColumnReference {
            name: column.name().to_string().into(),
            unit: "".into(),
            doc: "".into(),
            holds: column.dtype().clone(),
        };
        let columns: Vec<ColumnReference> = cells().columns().iter().map(said).collect();
        let conditions = text.split(" and ").map(|part| Condition::parse(part, &columns).unwrap()).collect();
        Gate { text: text.into(), about_searches: false, conditions }.judge(&cells()).iter().map(letter).collect()
    }

    #[test]
    fn a_gate_is_broken_where_all_its_conditions_hold() {
        for (text, wanted) in [
            ("preventable_rate > 0.05", "pbm"),
            ("preventable_rate>=0.04", "bbm"),
            ("preventable_rate < 0.05", "bpm"),
            ("preventable_rate <= 0.04", "bpm"),
            ("preventable_rate == 0.04", "bpm"),
            ("preventable_rate != 0.04", "pbm"),
            ("errors > 0", "ppb"),
            ("preventable_rate > 0.01 and town == village", "ebm"),
            ("preventable_rate > 0.01 and town != \"village\"", "bee"),
            ("preventable_rate > 0.05 and errors > 0", "ppm"),
            ("preventable_rate > 0.05 and errors < 1", "pbp"),
        ] {
            assert_eq!(judged(text), wanted, "{text}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused_and_the_column_meant_is_named() {
        let said = |text: &str| Gate::parse(text).unwrap_err().to_string();
        assert!(Gate::parse("preventable_rate_wilson_low > 0.05 and town == village").is_ok());
        assert_eq!(Gate::parse("preventable_rate > 0.05").unwrap().conditions[0].column, "preventable_rate_mean");
        assert!(said("preventible_rate > 0.05").contains("did you mean `preventable_rate_mean`?"));
        assert!(said("xyz > 1").contains("it has reward, train_town"));
        for text in ["", "preventable_rate", "preventable_rate = 1", "> 1", "preventable_rate >", "a > 1 and "] {
            assert!(matches!(Gate::parse(text), Err(GateError::Form { .. } | GateError::Column { .. })), "{text}");
        }
        assert!(said("preventable_rate > 5 %").contains("without a unit"));
        assert!(said("town > a").contains("== or !="));
    }
}
