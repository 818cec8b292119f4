use polars::prelude::DataFrame;

use super::{Cell, Spread};
use crate::compile::{Published, PublishedCell, PublishedFigure};
use crate::record::{Column, Interval, Table, cell_key, metric};
use crate::statistics::student_quantile;

/// The largest spread that is printed as 0.00.
const ROUNDED_AWAY: f64 = 0.004;

/// One of our figures compared with a published one.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedComparison<'a> {
    /// The source of the published one.
    pub source: &'a str,
    /// Its documentation in the scenario.
    pub docs: &'a str,
    /// Our cell.
    pub cell: &'a Cell,
    /// The published figure; its column names the column of the cell that it is compared with.
    pub published: PublishedFigure,
    /// The number of trainings in its average.
    pub published_runs: u32,
    /// Our figure.
    pub ours: Spread,
    /// Our figure less the published one; none when ours has no value.
    pub difference: Option<f64>,
    /// Welch's 95 % interval of the difference, where both spreads are between trainings; none without spreads.
    ///
    /// # Source
    /// Welch, *The generalization of "Student's" problem*, Biometrika 34, 1947. A published spread of 0.00 counts as 0.004.
    pub interval: Option<(f64, f64)>,
}

/// How near our figure is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreement {
    /// No farther from the published mean than the published standard deviation.
    Within,
    /// Farther, but the interval of the difference contains 0.
    Indistinct,
    /// The interval of the difference does not contain 0.
    Differs,
    /// There is not enough data.
    Unknown,
}

impl Agreement {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "within its spread",
            Self::Indistinct => "indistinct",
            Self::Differs => "differs",
            Self::Unknown => "unknown",
        }
    }
}

impl PublishedComparison<'_> {
    /// The published mean and spread.
    pub fn theirs(&self) -> Spread {
        Spread { mean: Some(self.published.mean), sd: self.published.sd }
    }

    /// How near our figure is.
    pub fn agreement(&self) -> Agreement {
        let (Some(difference), Some((low, high))) = (self.difference, self.interval) else { return Agreement::Unknown };
        if self.published.sd.is_some_and(|sd| difference.abs() <= sd.max(ROUNDED_AWAY)) {
            Agreement::Within
        } else if low <= 0.0 && high >= 0.0 {
            Agreement::Indistinct
        } else {
            Agreement::Differs
        }
    }
}

/// Compares published figures with those of our trained pedestrians, in the order of the published cells.
pub fn beside<'a>(published: &'a [Published], cells: &'a [Cell]) -> Vec<PublishedComparison<'a>> {
    let mut all = Vec::new();
    for table in published {
        for (theirs, cell) in table.cells.iter().flat_map(|theirs| matching(theirs, cells)) {
            all.extend(theirs.figures.iter().map(|figure| compare(table, *figure, cell)));
        }
    }
    all
}

fn matching<'a>(theirs: &'a PublishedCell, cells: &'a [Cell]) -> impl Iterator<Item = (&'a PublishedCell, &'a Cell)> {
    let trained = |cell: &&Cell| ["trained", "sampled"].contains(&cell.key.controller.as_str());
    let same = move |cell: &&Cell| {
        theirs.rewards.contains(&cell.key.reward)
            && theirs.towns.contains(&cell.key.town)
            && theirs.policies.contains(&cell.key.policy)
    };
    cells.iter().filter(trained).filter(same).map(move |cell| (theirs, cell))
}

fn compare<'a>(table: &'a Published, published: PublishedFigure, cell: &'a Cell) -> PublishedComparison<'a> {
    let ours = figure(cell, published.column).expect("checked: every published figure is one of a cell");
    let difference = ours.mean.map(|mean| mean - published.mean);
    let interval = difference.zip(ours.sd).zip(published.sd).and_then(|((difference, sd), theirs)| {
        let half = welch((sd, cell.runs), (theirs.max(ROUNDED_AWAY), table.runs))?;
        Some((difference - half, difference + half))
    });
    let (source, docs) = (&table.source, &table.docs);
    PublishedComparison { source, docs, cell, published, published_runs: table.runs, ours, difference, interval }
}

/// The figure of a cell that published ones are compared with, by its column without `_mean`.
fn figure(cell: &Cell, column: &str) -> Option<Spread> {
    let figures = [
        (metric::COLLISION_RATE.name, cell.collision),
        (metric::FRONT_RATE.name, cell.front),
        (metric::MOVING_RATE.name, cell.moving),
        (metric::EPISODE_REWARD.name, cell.reward_sum),
        (metric::EPISODE_LENGTH.name, cell.length),
        (metric::IMPACT_SPEED.name, cell.impact_speed),
    ];
    figures.into_iter().find(|(name, _)| *name == column).map(|(_, spread)| spread)
}

/// Half the width of Welch's 95 % interval of a difference of two means, from their standard deviations and numbers.
fn welch((a, n): (f64, u32), (b, m): (f64, u32)) -> Option<f64> {
    if n < 2 || m < 2 {
        return None;
    }
    let (a, b) = (a * a / f64::from(n), b * b / f64::from(m));
    let degrees = (a + b) * (a + b) / (a * a / f64::from(n - 1) + b * b / f64::from(m - 1));
    Some(student_quantile(degrees) * (a + b).sqrt())
}

/// Published figures compared with ours as a table, one row for each figure.
pub fn published(all: &[PublishedComparison<'_>]) -> DataFrame {
    published_table().frame(&all.iter().collect::<Vec<_>>())
}

/// The columns of [`published`].
pub fn published_table<'a>() -> Table<'a, &'a PublishedComparison<'a>> {
    type Row<'a> = &'a PublishedComparison<'a>;
    let (text, number) = (Column::<String>::new, Column::<f64>::new);
    Table::new(
        "published",
        "One row for each figure that others have published and the campaign names with `beside`, with ours and the difference.",
    )
    .column(text("source", "", "where the published figure is from").of(|row: &Row<'_>| no_formula(row.source)))
    .columns(cell_key(|row: &Row<'_>| &row.cell.key))
    .column(
        text("figure", "", "our column for the figure, without `_mean`").of(|row: &Row<'_>| row.published.column),
    )
    .column(number("published_mean", "as the figure", "published mean").of(|row: &Row<'_>| row.published.mean))
    .column(
        number("published_sd", "as the figure", "published standard deviation").of(|row: &Row<'_>| row.published.sd),
    )
    .column(
        Column::<u32>::new("published_runs", "", "number of trainings of the published figure")
            .of(|row: &Row<'_>| row.published_runs),
    )
    .column(number("mean", "as the figure", "our mean").of(|row: &Row<'_>| row.ours.mean))
    .column(number("sd", "as the figure", "our standard deviation").of(|row: &Row<'_>| row.ours.sd))
    .column(Column::<u32>::new("runs", "", "number of our trainings").of(|row: &Row<'_>| row.cell.runs))
    .column(number("difference", "as the figure", "ours less theirs").of(|row: &Row<'_>| row.difference))
    .columns(
        Interval::new(
            "difference",
            "as the figure",
            "Welch's 95 % interval of the difference between trainings here and there; a published spread of 0.00 counts as 0.004",
        )
        .of(|row: &Row<'_>| row.interval),
    )
    .column(
        text(
            "agreement",
            "",
            "`within its spread` (no farther from the published mean than its standard deviation), `indistinct` (farther, but the interval \
             contains 0), `differs`, or `unknown` without spreads",
        )
        .of(|row: &Row<'_>| row.agreement().name()),
    )
}

/// A text that spreadsheets do not take for a formula.
fn no_formula(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { format!("'{text}") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_no_formula() {
        assert_eq!(no_formula("=HYPERLINK(1)"), "'=HYPERLINK(1)");
        assert_eq!(no_formula("Table 2, a = b"), "Table 2, a = b");
    }

    #[test]
    fn every_figure_that_can_be_published_is_one_of_a_cell() {
        let row = crate::record::episodes(&[]);
        let metrics = crate::report::metrics(&row).unwrap();
        for column in crate::compile::published_columns() {
            assert!(figure(&Cell::default(), column).is_some(), "{column}");
            assert!(metrics.cells.column(&metric::MEAN.name(column)).is_ok(), "{column}");
        }
    }

    #[test]
    fn welchs_interval_is_scipys() {
        // scipy 1.17.1: stats.t.ppf(0.975, 2.391412) times the standard error, for 0.02 of 5 and 0.05 of 3.
        let half = welch((0.02, 5), (0.05, 3)).unwrap();
        assert!((half - 0.111_622_865_793).abs() < 1e-9, "{half}");
        assert_eq!(welch((0.02, 1), (0.05, 3)), None);
    }
}
