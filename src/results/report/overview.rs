//! Several reports of one call side by side: the variants of a matrix, and the campaigns of several files.

use polars::prelude::{DataFrame, DataType, Expr, LazyFrame, NULL, PolarsResult, UnionArgs, concat, lit};

use super::{Doubt, DriverResult};
use crate::tables::{Cells, OTHER, Rows, overview};
use compile::SearchKey;

/// The setting that tells the seeds of a call apart.
const SEED: &str = "seed";

/// The results of a report for an overview.
#[derive(Debug, Clone)]
pub struct Variant<'a> {
    /// The name of the report's folder, which is beside the overview.
    pub report: String,
    /// The settings of the campaign, as `name = value`.
    pub settings: &'a [String],
    pub cells: &'a Cells,
    /// What was found about each driver.
    pub drivers: &'a [DriverResult],
    /// Means of its searches.
    pub searches: &'a Rows<SearchKey>,
    /// The doubts about its trainings.
    pub doubts: &'a [Doubt],
}

/// The reports of a call side by side.
#[derive(Debug, Clone)]
pub struct Overview<'a> {
    /// The names of the settings that differ between the reports.
    pub parameters: Vec<&'a str>,
    pub variants: &'a [Variant<'a>],
    /// A row for each cell and each cell of searches of each report, in the order in which the reports were made.
    rows: DataFrame,
}

impl<'a> Overview<'a> {
    /// Puts reports side by side.
    ///
    /// # Errors
    /// Those of polars; none.
    pub fn new(variants: &'a [Variant<'a>]) -> PolarsResult<Self> {
        let mut parameters: Vec<&str> = Vec::new();
        for (name, _) in variants.iter().flat_map(|variant| variant.settings).filter_map(|setting| parts(setting)) {
            let first = variants.first().and_then(|variant| value(variant, name));
            if !parameters.contains(&name) && variants.iter().any(|variant| value(variant, name) != first) {
                parameters.push(name);
            }
        }
        let tables = variants.iter().flat_map(|variant| {
            let tables = [(variant.cells.table(), false), (variant.searches.table(), true)].into_iter();
            let more = columns(variant, &parameters);
            tables
                .filter(|(table, _)| table.height() > 0)
                .map(move |(table, are_searches)| overview::rows(table, are_searches, more.clone()))
        });
        let tables: Vec<LazyFrame> = tables.collect();
        let rows = match tables.is_empty() {
            true => overview::no_rows(&parameters)?,
            false => concat(tables, UnionArgs::default())?.collect()?,
        };
        Ok(Self { parameters, variants, rows })
    }

    /// The value of each parameter in a report; `None` if its campaign does not have it.
    pub fn values(&self, variant: &Variant<'_>) -> Vec<Option<String>> {
        self.parameters.iter().map(|name| value(variant, name).map(str::to_string)).collect()
    }

    /// The overview as a table, with a column of text for each parameter at its end.
    ///
    /// # Errors
    /// Those of polars, for two parameters of one name.
    pub fn table(&self) -> PolarsResult<DataFrame> {
        let mut table = self.rows.select(overview::file_columns())?;
        for name in &self.parameters {
            table.with_column(self.rows.column(&overview::setting_column(name))?.clone().with_name((*name).into()))?;
        }
        Ok(table)
    }

    /// Whether the rows differ in a column.
    pub fn varies(&self, column: &str) -> bool {
        self.rows.column(column).and_then(polars::prelude::Column::n_unique).is_ok_and(|values| values > 1)
    }

    /// The parameters but the seed.
    pub fn settings(&self) -> Vec<String> {
        self.parameters.iter().filter(|name| **name != SEED).map(ToString::to_string).collect()
    }

    /// Whether there are several seeds.
    pub fn has_seeds(&self) -> bool {
        self.parameters.contains(&SEED) && self.rows.height() > 0
    }

    /// The rows that differ in the seed alone, together, by their numbers; empty for a single seed.
    ///
    /// # Errors
    /// Those of polars; none.
    pub fn over_seeds(&self) -> PolarsResult<Rows<u32>> {
        if !self.has_seeds() {
            return Ok(Rows::default());
        }
        Rows::new(overview::over_seeds(&self.rows, &self.settings())?, |table, row| overview::group(table, row, ""))
    }

    /// The pairs of these in one town against one driver: a later one and an earlier one, or, without `all`, the first.
    ///
    /// # Errors
    /// Those of polars; none.
    pub fn seed_pairs(&self, all: bool) -> PolarsResult<Rows<[u32; 2]>> {
        if !self.has_seeds() {
            return Ok(Rows::default());
        }
        let pairs = overview::seed_pairs(&self.rows, &self.settings(), all)?;
        Rows::new(pairs, |table, row| Ok([overview::group(table, row, "")?, overview::group(table, row, OTHER)?]))
    }
}

/// The columns that all rows of a report share.
fn columns(variant: &Variant<'_>, parameters: &[&str]) -> Vec<Expr> {
    let text = |value: Option<&str>| value.map_or_else(|| lit(NULL).cast(DataType::String), lit);
    let seed = value(variant, SEED);
    let campaign = variant.report.replace(&format!("-seed-{}", seed.unwrap_or_default()), "");
    let settings = parameters.iter().map(|name| text(value(variant, name)).alias(overview::setting_column(name)));
    let report = lit(&*variant.report).alias(overview::REPORT);
    let own = [report, lit(campaign).alias(overview::CAMPAIGN), text(seed).alias(overview::SEED)];
    own.into_iter().chain(settings).collect()
}

/// A setting's name and value.
fn parts(setting: &str) -> Option<(&str, &str)> {
    setting.split_once('=').map(|(name, value)| (name.trim(), value.trim()))
}

/// The value of a setting; of a setting that is given twice the last.
fn value<'a>(variant: &Variant<'a>, name: &str) -> Option<&'a str> {
    variant
        .settings
        .iter()
        .rev()
        .filter_map(|setting| parts(setting))
        .find(|found| found.0 == name)
        .map(|found| found.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::report::Rate;
    use crate::tables::Cell;
    use crate::tables::metrics::COLLISION_RATE;

    #[test]
    fn each_controller_of_each_value_has_a_row_with_its_spread() {
        let cell = |controller: &str, collision: f64, sd: Option<f64>| {
            let key = CellKey {
                policy: "a".into(),
                town: "x".into(),
                controller: controller.into(),
                reward: "r".into(),
                world: "there".into(),
                ..CellKey::default()
            };
            let ends = Some((collision - 0.1, collision + 0.1));
            let rate = Rate { sd, ..Rate::single(collision) }.within(ends);
            Cell::example(key, &[], &[(&COLLISION_RATE, rate)])
        };
        let cells = Cells::example(&[cell("trained", 0.2, Some(0.03)), cell("random", 0.5, None)]);
        let searches = Rows::default();
        let settings = [3, 8].map(|weight| vec!["same = 1".to_string(), format!("weight = {weight}")]);
        let variants: Vec<Variant<'_>> = settings
            .iter()
            .map(|settings| Variant {
                report: "r".into(),
                settings,
                cells: &cells,
                drivers: &[],
                searches: &searches,
                doubts: &[],
            })
            .collect();
        let overview = Overview::new(&variants).unwrap();
        assert_eq!(overview.parameters, ["weight"]);
        let table = overview.table().unwrap();
        assert_eq!(table.height(), 4, "two values, two controllers");
        assert_eq!(table.column("weight").unwrap().str().unwrap().get(2), Some("8"));
        assert_eq!(overview.rows.column(overview::WHO).unwrap().str().unwrap().get(3), Some("random"));
        assert_eq!(table.column("world").unwrap().str().unwrap().get(0), Some("there"));
        assert_eq!(table.column("collision_rate_sd").unwrap().f64().unwrap().get(1), None);
    }
}
