use polars::prelude::{Column, DataFrame, PolarsResult};

use super::groups::Groups;
use crate::record::episodes::named;
use crate::record::metric::{Count, Over, Which};
use crate::record::{self, Metric, columns};
use base::statistics::RunningMean;

/// The metrics of one run, from its episodes part by part, in memory that does not grow with their number.
#[derive(Debug, Clone)]
pub struct RunTotals {
    metrics: Vec<Metric>,
    /// The keys of the run in a table of one row; none without any episode.
    keys: Option<DataFrame>,
    totals: Vec<Total>,
}

/// A metric while episodes are added.
#[derive(Debug, Clone, Copy)]
enum Total {
    Count(u32),
    Mean(RunningMean),
    /// A ratio of two counts, which needs no episodes.
    Rate,
}

impl Total {
    fn none(metric: &Metric) -> Self {
        match *metric {
            Metric::Count(_) => Self::Count(0),
            Metric::Mean(_) => Self::Mean(RunningMean::default()),
            Metric::Rate(_) => Self::Rate,
        }
    }

    fn count(self) -> u32 {
        if let Self::Count(count) = self { count } else { 0 }
    }

    fn mean(self) -> Option<f64> {
        if let Self::Mean(mean) = self { mean.value() } else { None }
    }
}

impl RunTotals {
    /// Starts without any episode.
    pub fn new() -> Self {
        let metrics = record::metrics();
        let totals = metrics.iter().map(Total::none).collect();
        Self { metrics, keys: None, totals }
    }

    /// Adds episodes: a part of the table of the run.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::record::episodes).
    pub fn add(&mut self, part: &DataFrame) -> PolarsResult<()> {
        if self.keys.is_none() && part.height() > 0 {
            self.keys = Some(part.select(record::run_key_names())?.head(Some(1)));
        }
        include(&mut self.totals, &self.metrics, part, 0..part.height())
    }

    /// The table of the run, of one row; of none without any episode.
    ///
    /// # Errors
    /// As [`RunTotals::add`].
    pub fn table(self) -> PolarsResult<DataFrame> {
        match self.keys {
            Some(keys) => table(keys, &self.metrics, &[self.totals]),
            None => to_runs(&record::episodes(&[]), &self.metrics),
        }
    }
}

/// Aggregates episodes to runs, in the order of first appearance.
pub(super) fn to_runs(episodes: &DataFrame, metrics: &[Metric]) -> PolarsResult<DataFrame> {
    let groups = Groups::new(episodes, record::run_key_names())?;
    let of_run = |rows: &Vec<usize>| {
        let mut totals: Vec<Total> = metrics.iter().map(Total::none).collect();
        include(&mut totals, metrics, episodes, rows.iter().copied()).map(|()| totals)
    };
    let all = groups.rows().iter().map(of_run).collect::<PolarsResult<Vec<_>>>()?;
    table(groups.table()?, metrics, &all)
}

/// Adds some rows of a table of episodes to the totals of a run.
fn include(
    totals: &mut [Total],
    metrics: &[Metric],
    episodes: &DataFrame,
    rows: impl Iterator<Item = usize>,
) -> PolarsResult<()> {
    let parts = Parts::new(episodes, rows)?;
    for (metric, total) in metrics.iter().zip(totals) {
        match (*metric, total) {
            (Metric::Count(count), Total::Count(total)) => *total += parts.count(&count, episodes)? as u32,
            (Metric::Mean(mean), Total::Mean(total)) => {
                let values = episodes.column(mean.column)?.f64()?;
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
    fn new(episodes: &DataFrame, rows: impl Iterator<Item = usize>) -> PolarsResult<Self> {
        let (outcome, left_out) = (columns::OUTCOME.read(episodes)?, columns::LEFT_OUT.read(episodes)?);
        let mut parts = Self { valid: Vec::new(), all: Vec::new(), collisions: Vec::new(), in_error: 0 };
        for row in rows {
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

/// The table of runs with these keys and totals.
fn table(mut runs: DataFrame, metrics: &[Metric], totals: &[Vec<Total>]) -> PolarsResult<DataFrame> {
    for (place, metric) in metrics.iter().enumerate() {
        let of_runs = || totals.iter().map(|run| run[place]);
        let column = match *metric {
            Metric::Count(count) => Column::new(count.name.into(), of_runs().map(Total::count).collect::<Vec<_>>()),
            Metric::Mean(mean) => Column::new(mean.name.into(), of_runs().map(Total::mean).collect::<Vec<_>>()),
            Metric::Rate(_) => continue,
        };
        runs.with_column(column)?;
    }
    for metric in metrics {
        if let Metric::Rate(rate) = *metric {
            let (part, whole) = (rate.part.read(&runs)?, rate.whole.read(&runs)?);
            // A share is missing when the whole is zero.
            let share = |(part, whole)| (whole > 0).then(|| f64::from(part) / f64::from(whole));
            let shares = part.into_no_null_iter().zip(whole.into_no_null_iter()).map(share);
            let column = Column::new(rate.name.into(), shares.collect::<Vec<Option<f64>>>());
            runs.with_column(column)?;
        }
    }
    Ok(runs)
}
