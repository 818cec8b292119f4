//! What drivers give for safety, over all towns: their progress, and needless braking.

use polars::prelude::{DataFrame, DataType, IntoLazy, NULL, PolarsResult, col, len, lit, when};

use super::{ReadError, StoredReport};
use crate::jobs::{NEEDLESS, PRICES, PROGRESS, SPARED};
use crate::record::columns::DRIVER;
use crate::tables::{Row, Rows};
use base::statistics::wilson;

const DELAYED: &str = "delayed_encounters";
/// The standard error of the progress.
const ERROR: &str = "progress_error";
/// A report has a row for each driver and town.
const MAX_ROWS: usize = 1 << 20;
/// The 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.96;

/// The price of a driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriverPrice {
    /// The mean over the towns, and its standard error; `None` if a town has a single start.
    pub progress: f64,
    error: Option<f64>,
    /// Encounters whom the car passes with room to spare without braking, and those of them in which it is delayed.
    pub spared: u64,
    pub delayed: u64,
}

impl DriverPrice {
    /// Those of a table of prices, with the names of their drivers.
    ///
    /// # Errors
    /// It is no table of prices.
    pub fn all(prices: &DataFrame) -> PolarsResult<Vec<(String, Self)>> {
        // The lower end is cut at 0.
        let error = (col(format!("{}_high", PROGRESS.name)) - col(PROGRESS.name)) / lit(NORMAL);
        let is_known = error.clone().null_count().eq(lit(0));
        let errors = when(is_known).then(error.pow(2.0).sum().sqrt()).otherwise(lit(NULL));
        let figures = [
            col(PROGRESS.name).mean(),
            (errors / len().cast(DataType::Float64)).alias(ERROR),
            col(SPARED.name).sum(),
            (col(NEEDLESS) * col(SPARED.name)).sum().alias(DELAYED),
        ];
        let known = prices.clone().lazy().filter(col(PROGRESS.name).is_not_null());
        let drivers = known.group_by_stable([col(DRIVER.name)]).agg(figures).collect()?;
        let rows = Rows::new(drivers, |table, row| Ok(DRIVER.value(table, row)?.unwrap_or_default()))?;
        let price = |row: &Row<String>| {
            let (progress, error) = (row.number(PROGRESS.name)?, row.number(ERROR));
            let [spared, delayed] =
                [SPARED.name, DELAYED].map(|count| row.number(count).unwrap_or_default().round() as u64);
            Some((row.key.clone(), Self { progress, error, spared, delayed }))
        };
        Ok(rows.iter().filter_map(price).collect())
    }

    /// Those of a report; empty if it has none.
    ///
    /// # Errors
    /// A table that is damaged.
    pub fn stored(report: &StoredReport) -> Result<Vec<(String, Self)>, ReadError> {
        let mut all = Vec::new();
        if report.written(PRICES).is_some() {
            report.each_part(PRICES, MAX_ROWS, |rows| Self::all(rows).map(|rows| all = rows))?;
        }
        Ok(all)
    }

    /// The 95 % interval of the progress; `None` of a single start.
    pub fn ends(&self) -> Option<(f64, f64)> {
        self.error.map(|error| ((self.progress - NORMAL * error).max(0.0), self.progress + NORMAL * error))
    }

    /// Half of the 95 % interval of a difference; infinite if one is not known.
    fn uncertain(&self, other: &Self) -> f64 {
        self.error.zip(other.error).map_or(f64::INFINITY, |(one, other)| NORMAL * one.hypot(other))
    }

    /// The share of encounters with needless braking, and Wilson's 95 % interval; `None` without any.
    pub fn needless(&self) -> Option<(f64, (f64, f64))> {
        (self.spared > 0).then(|| (self.delayed as f64 / self.spared as f64, wilson(self.delayed, self.spared)))
    }

    /// Whether another driver is surely slower than this one, or brakes needlessly more often.
    pub fn is_below(&self, other: &Self) -> bool {
        let is_slower = self.progress - other.progress > self.uncertain(other);
        let needless = self.needless().zip(other.needless());
        is_slower || needless.is_some_and(|((_, (_, high)), (_, (low, _)))| low > high)
    }

    /// What another driver costs beside this one: `progress 0.93 -> 0.90, 3 % slower`.
    pub fn beside(&self, other: &Self) -> String {
        let change = other.progress - self.progress;
        let word = match 100.0 * change / self.progress {
            _ if change.abs() <= self.uncertain(other) => "no difference is shown".into(),
            less if less < 0.0 => format!("{:.0} % slower", -less),
            more => format!("{more:.0} % faster"),
        };
        let [before, after] = [self, other].map(|price| format!("{} of {}", price.delayed, price.spared));
        format!(
            "progress {:.2} -> {:.2}, {word}; braked needlessly in {before} -> {after} encounters",
            self.progress, other.progress
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_price_is_a_mean_over_towns_and_a_change_within_the_error_is_none() {
        let prices = polars::prelude::df!(
            "driver" => ["a", "b", "a"],
            "progress" => [0.8, 0.5, 0.9],
            "progress_low" => [0.78, 0.46, 0.88],
            "progress_high" => [0.82, 0.54, 0.92],
            "spared_encounters" => [10_u64, 20, 30],
            "needless_braking" => [0.1, 0.5, 0.2]
        );
        let all = DriverPrice::all(&prices.unwrap()).unwrap();
        let [(first, a), (second, b)] = &all[..] else { panic!("{all:?}") };
        assert_eq!((first.as_str(), second.as_str()), ("a", "b"));
        assert!((a.progress - 0.85).abs() < 1e-12 && (a.error.unwrap() - 0.02 / 1.96 / 2_f64.sqrt()).abs() < 1e-12);
        assert_eq!((a.delayed, a.spared, b.delayed, b.spared), (7, 40, 10, 20));
        assert_eq!(
            a.beside(b),
            "progress 0.85 -> 0.50, 41 % slower; braked needlessly in 7 of 40 -> 10 of 20 encounters"
        );
        let near = DriverPrice { progress: 0.86, ..*a };
        assert!(a.beside(&near).contains("no difference is shown"));
        assert!(a.is_below(b) && !b.is_below(a) && !a.is_below(&near));
        assert!(a.is_below(&DriverPrice { delayed: 30, ..*a }), "it stands for most");
    }
}
