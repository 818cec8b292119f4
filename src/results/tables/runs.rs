use polars::prelude::{
    Column as Values, DataFrame, Expr, IntoLazy, PolarsResult, Scalar, UnionArgs, col, concat, lit, when,
};

use super::cells::{IS_COPY, IS_FIXED_CASES};
use super::metrics::{HIDDEN, METRICS};
use super::requirements::{NO_VERDICT, REQUIREMENT, REQUIREMENT_METRICS};
use super::{Cells, Metric};
use crate::record::columns::{RUN, RUN_ID};
use crate::record::{DEGREES, RunKey, Table, cell_key};

/// The number of rows that are summed at once. The sums of a run depend on it, and so do their last digits.
const ROWS: usize = 10_000;

/// The place of a run among those of the campaign.
const PLACE: &str = "place";

/// The runs of a campaign, from their episodes, in memory that does not grow with these.
#[derive(Debug, Clone)]
pub struct Runs {
    /// The metrics of which sums are kept.
    metrics: Vec<&'static Metric>,
    /// Columns of the episodes besides, each value of which has a row of its own in each run.
    by: &'static [&'static str],
    keys: Vec<(RunKey, bool, bool)>,
    /// Episodes that are not summed yet, and their number.
    waiting: Vec<DataFrame>,
    rows: usize,
    /// Sums of parts of runs.
    sums: Vec<DataFrame>,
}

impl Default for Runs {
    fn default() -> Self {
        Self::new(METRICS.into_iter().chain(HIDDEN).collect(), &[])
    }
}

impl Runs {
    fn new(metrics: Vec<&'static Metric>, by: &'static [&'static str]) -> Self {
        Self { metrics, by, keys: Vec::new(), waiting: Vec::new(), rows: 0, sums: Vec::new() }
    }

    /// Those of the requirements of a campaign, from the table of requirements in their episodes.
    pub fn of_requirements() -> Self {
        Self::new(REQUIREMENT_METRICS.into(), &[REQUIREMENT.name, NO_VERDICT.name])
    }

    /// Begins a run, whose episodes follow.
    pub fn begin(&mut self, key: &RunKey, is_fixed_cases: bool, is_copy: bool) {
        self.keys.push((key.clone(), is_fixed_cases, is_copy));
    }

    /// Adds episodes of the run that was begun last.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::record::episodes).
    pub fn add(&mut self, part: &DataFrame) -> PolarsResult<()> {
        let place = Values::new_scalar(PLACE.into(), Scalar::from(self.keys.len() as u32 - 1), part.height());
        // Only some runs have degrees, and no metric is made of them.
        let mut part = part.drop_many([DEGREES.name]);
        part.with_column(place)?;
        self.rows += part.height();
        self.waiting.push(part);
        if self.rows >= ROWS { self.sum() } else { Ok(()) }
    }

    /// Sums the episodes that wait.
    fn sum(&mut self) -> PolarsResult<()> {
        let parts: Vec<_> = self.waiting.drain(..).map(IntoLazy::lazy).collect();
        self.rows = 0;
        if !parts.is_empty() {
            let sum = |metric: &&Metric| (metric.part)().sum().alias(metric.part_column());
            let sums: Vec<Expr> = self.metrics.iter().map(sum).collect();
            self.sums.push(concat(parts, UnionArgs::default())?.group_by_stable(self.groups()).agg(sums).collect()?);
        }
        Ok(())
    }

    /// The table of runs: the key, and the value and the sums of each metric. A run without any episode has no row.
    ///
    /// # Errors
    /// As [`Runs::add`].
    pub fn table(mut self) -> PolarsResult<DataFrame> {
        self.sum()?;
        let keys = Table::<(RunKey, bool, bool)>::new("runs", "")
            .column(RUN_ID.of(|row: &(RunKey, bool, bool)| row.0.id.to_string()))
            .columns(cell_key(|row: &(RunKey, bool, bool)| &row.0.cell))
            .column(RUN.of(|row: &(RunKey, bool, bool)| row.0.run))
            .column(IS_FIXED_CASES.of(|row: &(RunKey, bool, bool)| row.1))
            .column(IS_COPY.of(|row: &(RunKey, bool, bool)| row.2));
        let (groups, metrics) = (self.groups(), self.metrics);
        let parts: Vec<_> = self.sums.into_iter().map(IntoLazy::lazy).collect();
        if parts.is_empty() {
            return Ok(keys.frame(&[]));
        }
        let sums: Vec<Expr> = metrics.iter().map(|metric| col(metric.part_column()).sum()).collect();
        let values: Vec<Expr> =
            metrics.iter().filter(|metric| !metric.is_count()).map(|metric| value(metric)).collect();
        let sums =
            concat(parts, UnionArgs::default())?.group_by_stable(groups).agg(sums).with_columns(values).collect()?;
        let places: Vec<u32> = sums.column(PLACE)?.u32()?.into_no_null_iter().collect();
        let found: Vec<_> = places.iter().map(|place| self.keys[*place as usize].clone()).collect();
        keys.frame(&found).hstack(sums.drop(PLACE)?.columns())
    }

    /// The cells of the runs, and copies of them: of untrained pedestrians, for further rewards.
    ///
    /// # Errors
    /// As [`Runs::add`].
    pub fn cells(self) -> PolarsResult<[Cells; 2]> {
        let (metrics, by) = (self.metrics.clone(), self.by);
        Cells::new(&self.table()?, &metrics, by)?.without_copies()
    }

    fn groups(&self) -> Vec<Expr> {
        std::iter::once(PLACE).chain(self.by.iter().copied()).map(col).collect()
    }
}

/// The value of a ratio in a run; missing where its whole is 0.
fn value(metric: &Metric) -> Expr {
    let whole = metric.whole.map_or_else(|| lit(1), |whole| col(whole.name));
    let ratio = col(metric.part_column()).cast(polars::prelude::DataType::Float64) / whole.clone();
    when(whole.gt(lit(0))).then(ratio).otherwise(lit(polars::prelude::NULL)).alias(metric.name)
}
