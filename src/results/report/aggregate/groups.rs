use polars::prelude::{Column, DataFrame, Float64Chunked, GroupsIndicator, NamedFrom, PolarsResult, Series};

use base::statistics::{mean, sample_deviation};

/// The rows of a table that have the same keys, in the order of first appearance.
pub struct Groups {
    keys: Vec<Column>,
    rows: Vec<Vec<usize>>,
}

impl Groups {
    /// Groups the rows of a table by columns.
    ///
    /// # Errors
    /// A column is missing.
    pub fn new(table: &DataFrame, keys: impl IntoIterator<Item = String>) -> PolarsResult<Self> {
        let grouped = table.group_by_stable(keys)?;
        let indices = |group: GroupsIndicator<'_>| match group {
            GroupsIndicator::Idx((_, rows)) => rows.iter().map(|row| *row as usize).collect(),
            GroupsIndicator::Slice([first, length]) => (first as usize..(first + length) as usize).collect(),
        };
        Ok(Self { keys: grouped.keys(), rows: grouped.get_groups().iter().map(indices).collect() })
    }

    /// A table of a row for each group, with the keys alone.
    ///
    /// # Errors
    /// None; polars checks the lengths of the columns again.
    pub fn table(&self) -> PolarsResult<DataFrame> {
        DataFrame::new(self.rows.len(), self.keys.clone())
    }

    /// The rows of each group.
    pub fn rows(&self) -> &[Vec<usize>] {
        &self.rows
    }

    /// The number of rows of each group.
    pub fn sizes(&self, name: &str) -> Column {
        self.column(name, |rows| rows.len() as u32)
    }

    /// The sum of a whole number over each group.
    pub fn sum(&self, name: &str, value: impl Fn(usize) -> u32) -> Column {
        self.column(name, |rows| rows.iter().map(|row| value(*row)).sum::<u32>())
    }

    /// The mean over the rows of each group that have a value; missing without any.
    pub fn mean(&self, name: &str, value: impl Fn(usize) -> Option<f64>) -> Column {
        self.column(name, |rows| mean(rows.iter().filter_map(|row| value(*row))))
    }

    /// The sample standard deviation over the rows of each group that have a value; missing with fewer than two.
    pub fn deviation(&self, name: &str, values: &Float64Chunked) -> Column {
        self.column(name, |rows| sample_deviation(rows.iter().filter_map(|row| values.get(*row))))
    }

    fn column<T>(&self, name: &str, of: impl Fn(&[usize]) -> T) -> Column
    where
        Series: NamedFrom<Vec<T>, [T]>,
    {
        let values: Vec<T> = self.rows.iter().map(|rows| of(rows)).collect();
        Series::new(name.into(), values).into()
    }
}
