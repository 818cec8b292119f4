use polars::prelude::{Column, DataFrame, NamedFrom, Series};

/// The columns of a table, over rows of any kind.
pub struct Columns<'a, T> {
    rows: &'a [T],
    columns: Vec<Column>,
}

impl<'a, T> Columns<'a, T> {
    /// No column yet.
    pub fn new(rows: &'a [T]) -> Self {
        Self { rows, columns: Vec::new() }
    }

    /// Adds words.
    pub fn text(&mut self, name: &str, value: impl Fn(&T) -> String) {
        let values: Vec<String> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    /// Adds counts.
    pub fn count(&mut self, name: &str, value: impl Fn(&T) -> u64) {
        let values: Vec<u64> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    /// Adds numbers that things are counted from.
    pub fn index(&mut self, name: &str, value: impl Fn(&T) -> u32) {
        let values: Vec<u32> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    /// Adds numbers, some of which may be missing.
    pub fn number(&mut self, name: &str, value: impl Fn(&T) -> Option<f64>) {
        let values: Vec<Option<f64>> = self.rows.iter().map(value).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    /// Adds the two ends of an interval.
    pub fn interval(&mut self, name: &str, value: impl Fn(&T) -> Option<(f64, f64)>) {
        self.number(&format!("{name}_low"), |row| value(row).map(|(low, _)| low));
        self.number(&format!("{name}_high"), |row| value(row).map(|(_, high)| high));
    }

    /// The columns.
    pub fn into_columns(self) -> Vec<Column> {
        self.columns
    }

    /// The table.
    pub fn table(self) -> DataFrame {
        DataFrame::new(self.rows.len(), self.columns).expect("all columns have a value for every row")
    }
}
