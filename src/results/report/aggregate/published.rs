use polars::prelude::DataFrame;

use super::{Cell, Spread};
use crate::record::{CellKey, Column, Interval, Table, cell_key};
use crate::report::{CellEvidence, Figure};
use base::choice;
use base::statistics::{MIN_RUNS, Uncertainty};
use compile::{Published, PublishedCell, PublishedFigure};

/// The least power with which a test for equivalence is worth its answer.
const POWER: f64 = 0.8;
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
    pub key: CellKey,
    /// The number of our trainings.
    pub runs: u32,
    /// The published figure; its column names the column of the cell that it is compared with.
    pub published: PublishedFigure,
    /// The number of trainings in its average.
    pub published_runs: u32,
    /// Our figure.
    pub ours: Spread,
    /// Our figure less the published one; none when ours has no value.
    pub difference: Option<f64>,
    /// The standard error of the difference: of ours over trainings and starts, of the published one over its trainings alone, since
    /// no publication states what its starts add. None without spreads. A published spread of 0.00 counts as 0.004.
    pub uncertainty: Option<Uncertainty>,
}

choice! {
    /// How near our figure is.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Agreement {
        /// Two one-sided tests at 5 % show that the difference is smaller than the margin.
        Equivalent = "equivalent",
        /// The difference is significant at 5 %, and equivalence is not shown.
        Differs = "differs",
        /// Neither is shown, although the test would show equivalence of equal figures in 80 of 100 campaigns.
        Inconclusive = "inconclusive",
        /// Neither is shown, and with so few runs or so much spread equivalence of equal figures would seldom be shown.
        Underpowered = "underpowered",
        /// There are no spreads.
        Unknown = "unknown",
    }
}

impl PublishedComparison<'_> {
    /// The published mean and spread.
    pub fn theirs(&self) -> Spread {
        Spread { mean: Some(self.published.mean), sd: self.published.sd }
    }

    /// How near our figure is.
    pub fn agreement(&self) -> Agreement {
        let Some(p) = self.p() else { return Agreement::Unknown };
        if self.equivalence_p().is_some_and(|p| p < 0.05) {
            Agreement::Equivalent
        } else if p < 0.05 {
            Agreement::Differs
        } else if self.equivalence_power().is_some_and(|power| power < POWER) {
            Agreement::Underpowered
        } else {
            Agreement::Inconclusive
        }
    }

    /// Student's 95 % interval of the difference; none where either side has fewer than four trainings.
    pub fn interval(&self) -> Option<(f64, f64)> {
        let few = |runs: u32| (runs as usize) < MIN_RUNS;
        if few(self.runs) || few(self.published_runs) {
            return None;
        }
        Some(self.uncertainty?.interval(self.difference?))
    }

    /// The two-sided p-value of the hypothesis that there is no difference; none without spreads.
    pub fn p(&self) -> Option<f64> {
        Some(self.uncertainty?.p(self.difference?))
    }

    /// The probability that equivalence of equal figures would be shown; none without a margin or spreads.
    pub fn equivalence_power(&self) -> Option<f64> {
        Some(self.uncertainty?.equivalence_power(self.published.margin?))
    }

    /// The p-value of the hypothesis that the difference is as large as the margin; none without a margin or spreads.
    pub fn equivalence_p(&self) -> Option<f64> {
        Some(self.uncertainty?.equivalence_p(self.difference?, self.published.margin?))
    }
}

/// Compares published figures with those of our trained pedestrians, in the order of the published cells.
///
/// `evidence` has the evidence on the cells.
pub fn beside<'a>(
    published: &'a [Published],
    cells: &[Cell],
    evidence: &[CellEvidence],
) -> Vec<PublishedComparison<'a>> {
    let mut all = Vec::new();
    for table in published {
        for (theirs, cell) in table.cells.iter().flat_map(|theirs| matching(theirs, cells)) {
            let found = evidence.iter().find(|found| found.key == cell.key);
            all.extend(theirs.figures.iter().map(|figure| compare(table, *figure, cell, found)));
        }
    }
    all
}

fn matching<'a>(theirs: &'a PublishedCell, cells: &'a [Cell]) -> impl Iterator<Item = (&'a PublishedCell, &'a Cell)> {
    let trained = |cell: &&Cell| ["trained", "stochastic"].contains(&cell.key.controller.as_str());
    let same = move |cell: &&Cell| {
        theirs.rewards.contains(&cell.key.reward)
            && theirs.towns.contains(&cell.key.town)
            && theirs.policies.contains(&cell.key.policy)
    };
    cells.iter().filter(trained).filter(same).map(move |cell| (theirs, cell))
}

fn compare<'a>(
    table: &'a Published,
    published: PublishedFigure,
    cell: &Cell,
    evidence: Option<&CellEvidence>,
) -> PublishedComparison<'a> {
    let (ours, figure) = figure(cell, published.column).expect("checked: every published figure is one of a cell");
    let difference = ours.mean.map(|mean| mean - published.mean);
    let here = evidence.and_then(|found| found.between(figure).uncertainty);
    let there = published.sd.and_then(|sd| Uncertainty::of_mean(sd.max(ROUNDED_AWAY), table.runs));
    let uncertainty = here.zip(there).map(|(here, there)| here.of_difference(there));
    let (source, docs) = (&table.source, &table.docs);
    PublishedComparison {
        source,
        docs,
        key: cell.key.clone(),
        runs: cell.runs,
        published,
        published_runs: table.runs,
        ours,
        difference,
        uncertainty,
    }
}

/// The figure of a cell that published ones are compared with, by its column without `_mean`.
fn figure(cell: &Cell, column: &str) -> Option<(Spread, Figure)> {
    let figures = [
        (Figure::Touch, cell.touch),
        (Figure::Front, cell.front),
        (Figure::Collision, cell.collision),
        (Figure::Reward, cell.reward_sum),
        (Figure::Length, cell.length),
        (Figure::ImpactSpeed, cell.impact_speed),
    ];
    figures.into_iter().find(|(figure, _)| figure.name() == column).map(|(figure, spread)| (spread, figure))
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
    .columns(cell_key(|row: &Row<'_>| &row.key))
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
    .column(Column::<u32>::new("runs", "", "number of our trainings").of(|row: &Row<'_>| row.runs))
    .column(number("difference", "as the figure", "ours less theirs").of(|row: &Row<'_>| row.difference))
    .columns(
        Interval::new(
            "difference",
            "as the figure",
            "Student's 95 % interval of the difference with Welch's degrees of freedom. Its variance is that between trainings here and there, plus \
             that of our starts; what the starts there add is not published, so the interval is rather too narrow. A published spread of 0.00 counts \
             as 0.004. Missing where either side has fewer than four trainings",
        )
        .of(|row: &Row<'_>| row.interval()),
    )
    .column(
        number("p", "", "two-sided p-value of the hypothesis that there is no difference, by the same variance; not adjusted for the number of rows")
            .of(|row: &Row<'_>| row.p()),
    )
    .column(
        number("margin", "as the figure", "differences below it count as none: `margins` of the published figures; missing where none is stated")
            .of(|row: &Row<'_>| row.published.margin),
    )
    .column(
        number(
            "equivalence_p",
            "",
            "p-value of the hypothesis that the difference is `margin` or more: the larger one of two one-sided tests (TOST)",
        )
        .of(|row: &Row<'_>| row.equivalence_p()),
    )
    .column(
        number(
            "equivalence_power",
            "",
            "probability that these tests show equivalence when there is no difference, from `margin` and the variance of the difference (shifted central t)",
        )
        .of(|row: &Row<'_>| row.equivalence_power()),
    )
    .column(
        text(
            "agreement",
            "",
            "`equivalent` (`equivalence_p` is below 0.05: the difference is shown to be below the margin), else `differs` (`p` is below 0.05), \
             else `underpowered` (neither is shown, and `equivalence_power` is below 0.8: too few runs for their spread), else `inconclusive` (neither \
             is shown), or `unknown` without spreads",
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
    use crate::record::metric;

    #[test]
    fn a_source_is_no_formula() {
        assert_eq!(no_formula("=HYPERLINK(1)"), "'=HYPERLINK(1)");
        assert_eq!(no_formula("Table 2, a = b"), "Table 2, a = b");
    }

    #[test]
    fn every_figure_that_can_be_published_is_one_of_a_cell() {
        let row = crate::record::episodes(&[]);
        let metrics = crate::report::metrics(&row).unwrap();
        for column in compile::published_columns() {
            assert!(figure(&Cell::default(), column).is_some(), "{column}");
            assert!(metrics.cells.column(&metric::MEAN.name(column)).is_ok(), "{column}");
        }
    }

    #[test]
    fn agreement_needs_a_margin_and_a_precise_difference() {
        let table = |margin| Published {
            source: "a paper".into(),
            docs: String::new(),
            runs: 5,
            cells: vec![PublishedCell {
                rewards: vec!["r1".into()],
                towns: vec!["a".into()],
                policies: vec!["p".into()],
                figures: vec![PublishedFigure { column: "collision_rate", mean: 0.5, sd: Some(0.02), margin }],
            }],
        };
        let agreement = |mean: f64, error: f64, margin: Option<f64>| {
            let mut cell = Cell { collision: Spread { mean: Some(mean), sd: Some(0.0) }, ..Cell::default() };
            (cell.key.controller, cell.key.reward) = ("trained".into(), "r1".into());
            (cell.key.town, cell.key.policy) = ("a".into(), "p".into());
            let mut found = CellEvidence::default();
            found.key.clone_from(&cell.key);
            found.between[Figure::Collision as usize].uncertainty = Some(Uncertainty { error, degrees: 4.0 });
            let (table, cells) = ([table(margin)], [cell]);
            beside(&table, &cells, &[found])[0].agreement()
        };
        assert_eq!(agreement(0.51, 0.01, Some(0.05)), Agreement::Equivalent);
        assert_eq!(agreement(0.51, 0.01, Some(0.02)), Agreement::Underpowered, "the margin is too small to show it");
        assert_eq!(agreement(0.51, 0.05, Some(0.05)), Agreement::Underpowered, "the difference is too uncertain");
        assert_eq!(agreement(0.51, 0.01, None), Agreement::Inconclusive, "without a margin equivalence means nothing");
        assert_eq!(agreement(0.545, 0.003, Some(0.05)), Agreement::Differs, "not below the margin, but not 0 either");
        assert_eq!(
            agreement(0.528, 0.0106, Some(0.05)),
            Agreement::Inconclusive,
            "a test with power that shows nothing"
        );
        assert_eq!(agreement(0.7, 0.01, Some(0.05)), Agreement::Differs);
        assert_eq!(agreement(0.53, 0.001, Some(0.1)), Agreement::Equivalent, "significant, but below the margin");
    }
}
