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
        include(&mut self.totals, &self.metrics, part, || 0..part.height())
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
        include(&mut totals, metrics, episodes, || rows.iter().copied()).map(|()| totals)
    };
    let all = groups.rows().iter().map(of_run).collect::<PolarsResult<Vec<_>>>()?;
    table(groups.table()?, metrics, &all)
}

/// Adds some rows of a table of episodes to the totals of a run.
fn include<R: Iterator<Item = usize>>(
    totals: &mut [Total],
    metrics: &[Metric],
    episodes: &DataFrame,
    rows: impl Fn() -> R,
) -> PolarsResult<()> {
    let outcome = columns::OUTCOME.read(episodes)?;
    // An episode without error counts.
    let valid = |row: usize| outcome.get(row).is_some_and(|outcome| outcome != record::IN_ERROR);
    for (metric, total) in metrics.iter().zip(totals) {
        match (*metric, total) {
            (Metric::Count(count), Total::Count(total)) => *total += counted(&count, episodes, valid, rows())?,
            (Metric::Mean(mean), Total::Mean(total)) => {
                let values = episodes.column(mean.column)?.f64()?;
                match mean.over {
                    Over::Valid => {
                        rows().filter(|row| valid(*row)).for_each(|row| total.include(values.get(row).unwrap_or(0.0)));
                    }
                    Over::Present => rows().filter_map(|row| values.get(row)).for_each(|value| total.include(value)),
                    Over::Collisions => {
                        let collisions = rows().filter(|row| outcome.get(*row) == Some(named::COLLISION));
                        collisions.filter_map(|row| values.get(row)).for_each(|value| total.include(value));
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The number of episodes that count.
fn counted(
    count: &Count,
    episodes: &DataFrame,
    valid: impl Fn(usize) -> bool,
    rows: impl Iterator<Item = usize>,
) -> PolarsResult<u32> {
    let outcome = columns::OUTCOME.read(episodes)?;
    let touched = |row: usize| outcome.get(row).is_some_and(named::is_touch);
    let number = match count.which {
        Which::Valid => rows.filter(|row| valid(*row)).count(),
        Which::InError => rows.filter(|row| !valid(*row)).count(),
        Which::True(column) => {
            let flags = episodes.column(column)?.bool()?;
            rows.filter(|row| flags.get(*row) == Some(true)).count()
        }
        Which::Ended(how) => rows.filter(|row| outcome.get(*row) == Some(how)).count(),
        Which::Touched => rows.filter(|row| touched(*row)).count(),
        Which::Passed => rows.filter(|row| valid(*row) && !touched(*row)).count(),
        Which::Counts(class) => {
            let counts = columns::COUNTS_AS.read(episodes)?;
            rows.filter(|row| counts.get(*row) == Some(class.name())).count()
        }
        Which::Labelled(label) => {
            let verdicts = columns::VERDICT.read(episodes)?;
            rows.filter(|row| verdicts.get(*row) == Some(label.name())).count()
        }
    };
    Ok(number as u32)
}

/// The table of runs with these keys and totals.
fn table(mut runs: DataFrame, metrics: &[Metric], totals: &[Vec<Total>]) -> PolarsResult<DataFrame> {
    for (place, metric) in metrics.iter().enumerate() {
        let of_runs = || totals.iter().map(|run| run[place]);
        let column = match *metric {
            Metric::Count(count) => Column::new(count.name().into(), of_runs().map(Total::count).collect::<Vec<_>>()),
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
