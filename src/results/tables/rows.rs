use std::ops::Deref;
use std::sync::Arc;

use polars::prelude::{DataFrame, PolarsResult};

use super::Rate;
use super::metrics::MEAN;
use crate::record::Column;

/// A table in memory, with the key of each row.
#[derive(Debug, Clone)]
pub struct Rows<K> {
    table: Arc<DataFrame>,
    rows: Vec<Row<K>>,
}

/// A row of a table, which its key tells apart.
#[derive(Debug, Clone, Default)]
pub struct Row<K> {
    pub key: K,
    table: Arc<DataFrame>,
    row: usize,
}

impl<K> Rows<K> {
    /// The rows of a table, with the key that is read from each.
    ///
    /// # Errors
    /// Those of the keys.
    pub fn new(table: DataFrame, key: impl Fn(&DataFrame, usize) -> PolarsResult<K>) -> PolarsResult<Self> {
        let table = Arc::new(table);
        let row = |row| Ok(Row { key: key(&table, row)?, table: table.clone(), row });
        let rows = (0..table.height()).map(row).collect::<PolarsResult<_>>()?;
        Ok(Self { table, rows })
    }

    pub fn table(&self) -> &DataFrame {
        &self.table
    }
}

impl<K> Default for Rows<K> {
    fn default() -> Self {
        Self { table: Arc::default(), rows: Vec::new() }
    }
}

impl<K> Deref for Rows<K> {
    type Target = [Row<K>];

    fn deref(&self) -> &[Row<K>] {
        &self.rows
    }
}

impl<K> Row<K> {
    /// The table that it is a row of.
    pub fn table(&self) -> &DataFrame {
        &self.table
    }

    /// The number in a column; `None` if it is missing.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.table.column(column).ok()?.get(self.row).ok()?.extract()
    }

    /// The text in a column; empty if it is missing.
    pub fn text(&self, column: &Column<String>) -> String {
        self.text_of(column.name)
    }

    /// The same of a column whose name is computed.
    pub fn text_of(&self, column: &str) -> String {
        let text = || self.table.column(column).ok()?.str().ok()?.get(self.row);
        text().unwrap_or_default().into()
    }

    /// The whole number in a column; 0 if it is missing.
    pub fn whole_number(&self, column: &str) -> u64 {
        self.number(column).map_or(0, |number| number as u64)
    }

    pub fn holds(&self, column: &Column<bool>) -> bool {
        column.value(&self.table, self.row).is_ok_and(|value| value == Some(true))
    }

    /// The list in a column; empty if it is missing.
    pub fn list(&self, column: &str) -> Vec<f64> {
        let list = || self.table.column(column).ok()?.list().ok()?.get_as_series(self.row);
        list().and_then(|list| Some(list.f64().ok()?.into_no_null_iter().collect())).unwrap_or_default()
    }

    /// Both ends of an interval; `None` if it is missing.
    pub fn ends(&self, interval: &str) -> Option<(f64, f64)> {
        self.number(&format!("{interval}_low")).zip(self.number(&format!("{interval}_high")))
    }

    /// A figure over runs, with the interval `FIGURE_low` to `FIGURE_high`, or that of a method.
    pub fn figure(&self, name: &str, method: &str) -> Rate {
        Rate {
            value: self.number(&MEAN.name(name)),
            sd: self.number(&format!("{name}_sd")),
            interval: self.ends(&format!("{name}{method}")),
            by_run: self.list(&format!("{name}_by_run")),
        }
    }
}
