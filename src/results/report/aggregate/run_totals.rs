use polars::prelude::{DataFrame, PolarsResult};

use crate::record::episodes::named;
use crate::record::metric::{Count, Over, Which};
use crate::record::{self, Metric, RunKey, columns};
use base::statistics::RunningMean;

/// A run: a controller of one training in one town against one policy.
#[derive(Debug, Clone, PartialEq)]
pub struct RunRow {
    pub key: RunKey,
    /// Whether its episodes are the cases of a test, each once. They are no sample, and nothing has an interval.
    pub is_of_cases: bool,
    /// Each metric with its value, in the order of [`metrics`](record::metrics); `None` without an episode that it is of.
    pub values: Vec<(Metric, Option<f64>)>,
}

impl RunRow {
    /// The value of a metric, by its name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(metric, _)| metric.name() == name)?.1
    }
}

/// The metrics of one run, from its episodes part by part, in memory that does not grow with their number.
#[derive(Debug, Clone)]
pub struct RunTotals {
    /// The key of the run; `None` without any episode.
    key: Option<RunKey>,
    is_of_cases: bool,
    totals: Vec<(Metric, Total)>,
}

/// A metric while episodes are added.
#[derive(Debug, Clone, Copy)]
enum Total {
    Count(u32),
    Mean(RunningMean),
    /// A ratio of two counts, which needs no episodes.
    Rate,
}

impl RunTotals {
    /// Starts without any episode.
    pub fn new(metrics: Vec<Metric>) -> Self {
        let none = |metric: Metric| match metric {
            Metric::Count(_) => (metric, Total::Count(0)),
            Metric::Mean(_) => (metric, Total::Mean(RunningMean::default())),
            Metric::Rate(_) => (metric, Total::Rate),
        };
        Self { key: None, is_of_cases: false, totals: metrics.into_iter().map(none).collect() }
    }

    /// The same of the cases of a test.
    #[must_use]
    pub fn of_cases(self, is_of_cases: bool) -> Self {
        Self { is_of_cases, ..self }
    }

    /// Adds episodes: a part of the table of the run.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::record::episodes).
    pub fn add(&mut self, part: &DataFrame) -> PolarsResult<()> {
        if self.key.is_none() && part.height() > 0 {
            self.key = Some(RunKey::read(part, 0)?);
        }
        let parts = Parts::new(part)?;
        for (metric, total) in &mut self.totals {
            match (metric, total) {
                (Metric::Count(count), Total::Count(total)) => *total += parts.count(count, part)? as u32,
                (Metric::Mean(mean), Total::Mean(total)) => {
                    let values = part.column(mean.column)?.f64()?;
                    let rows = match mean.over {
                        Over::All => &parts.all,
                        Over::Collisions => &parts.collisions,
                        Over::Valid => &parts.valid,
                    };
                    // A missing value of an episode that counts is 0.
                    let missing = (mean.over == Over::Valid).then_some(0.0);
                    let found = rows.iter().filter_map(|row| values.get(*row).or(missing));
                    found.for_each(|value| total.include(value));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The run; `None` without any episode.
    pub fn row(self) -> Option<RunRow> {
        let count = |count: &Count| {
            let of = |(metric, total): &(Metric, Total)| match total {
                Total::Count(number) if metric.name() == count.name => Some(f64::from(*number)),
                _ => None,
            };
            self.totals.iter().find_map(of).unwrap_or_default()
        };
        let value = |(metric, total): &(Metric, Total)| {
            let value = match (metric, total) {
                (_, Total::Count(count)) => Some(f64::from(*count)),
                (_, Total::Mean(mean)) => mean.value(),
                (Metric::Rate(rate), _) => {
                    Some(count(&rate.whole)).filter(|whole| *whole > 0.0).map(|whole| count(&rate.part) / whole)
                }
                _ => None,
            };
            (*metric, value)
        };
        let is_of_cases = self.is_of_cases;
        Some(RunRow { key: self.key.clone()?, is_of_cases, values: self.totals.iter().map(value).collect() })
    }
}

/// Rows of a table of episodes, each list in the order of the table.
struct Parts {
    /// Those that count.
    valid: Vec<usize>,
    /// Those without error: also the ones that are left out.
    all: Vec<usize>,
    /// Those that count and ended in a collision.
    collisions: Vec<usize>,
    in_error: usize,
}

impl Parts {
    fn new(episodes: &DataFrame) -> PolarsResult<Self> {
        let (outcome, left_out) = (columns::OUTCOME.read(episodes)?, columns::LEFT_OUT.read(episodes)?);
        let mut parts = Self { valid: Vec::new(), all: Vec::new(), collisions: Vec::new(), in_error: 0 };
        for row in 0..episodes.height() {
            if outcome.get(row).is_none_or(|outcome| outcome == record::IN_ERROR) {
                parts.in_error += 1;
                continue;
            }
            parts.all.push(row);
            if left_out.get(row).is_none_or(str::is_empty) {
                parts.valid.push(row);
                if outcome.get(row) == Some(named::COLLISION) {
                    parts.collisions.push(row);
                }
            }
        }
        Ok(parts)
    }

    /// The number of episodes that a count is of.
    fn count(&self, count: &Count, episodes: &DataFrame) -> PolarsResult<usize> {
        let valid = self.valid.iter();
        let outcome = columns::OUTCOME.read(episodes)?;
        let touched = |row: usize| outcome.get(row).is_some_and(named::is_touch);
        Ok(match count.which {
            Which::Valid => self.valid.len(),
            Which::InError => self.in_error,
            Which::LeftOut => self.all.len() - self.valid.len(),
            Which::LeftOutFor(reason) => {
                let left_out = columns::LEFT_OUT.read(episodes)?;
                self.all.iter().filter(|row| left_out.get(**row) == Some(reason.name())).count()
            }
            Which::All => self.all.len(),
            Which::True(column) => {
                let flags = episodes.column(column)?.bool()?;
                valid.filter(|row| flags.get(**row) == Some(true)).count()
            }
            Which::TrueOfAll(column) => {
                let flags = episodes.column(column)?.bool()?;
                self.all.iter().filter(|row| flags.get(**row) == Some(true)).count()
            }
            Which::Ended(how) => valid.filter(|row| outcome.get(**row) == Some(how)).count(),
            Which::Touched => valid.filter(|row| touched(**row)).count(),
            Which::Labelled(label) => {
                let verdicts = columns::VERDICT.read(episodes)?;
                valid.filter(|row| verdicts.get(**row) == Some(label.name())).count()
            }
        })
    }
}
