//! Tables for people: made once, rendered for a terminal, as Markdown and as HTML.

mod value;
mod terminal;
mod markdown;
mod html;

pub use value::{Mark, Value};

use std::rc::Rc;

use maud::Markup;

use super::svg::Figure;
use crate::tables::{Cell, Metric};

/// The alignment of a column's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// The head of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, with the unit if there is one.
    pub name: String,
    pub align: Align,
    /// Whether each part of a table that is too wide for a terminal has it, as always the first column.
    pub is_key: bool,
    /// Whether a terminal shows it.
    pub is_brief: bool,
    /// Whether a page shows it at once; else it shows it in a list of all columns that can be unfolded.
    pub is_shown: bool,
}

impl Column {
    /// A column of words.
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Left, is_key: false, is_brief: true, is_shown: true }
    }

    /// A column of numbers.
    pub fn number(name: impl Into<String>) -> Self {
        Self { align: Align::Right, ..Self::text(name) }
    }

    /// The same column, in each part of a table that is too wide for a terminal.
    pub fn key(self) -> Self {
        Self { is_key: true, ..self }
    }

    /// The same column, but not in a terminal, and folded on a page.
    pub fn detail(self) -> Self {
        Self { is_brief: false, is_shown: false, ..self }
    }

    /// The same column, but not in a terminal.
    pub fn page_only(self) -> Self {
        Self { is_brief: false, ..self }
    }
}

/// Where a table is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Place {
    /// In the summary and on the page.
    #[default]
    Report,
    /// At the end of a run, in a terminal.
    Terminal,
    /// In both.
    Everywhere,
}

/// A table for people.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    pub place: Place,
    /// Its heading; empty when the surrounding text names it.
    pub title: String,
    pub head: Vec<Column>,
    /// Its rows, each with a value for every column.
    pub rows: Vec<Vec<Value>>,
    /// Notes on how to read it, in Markdown, a paragraph each.
    pub notes: Vec<String>,
}

/// The value of a column in a row.
type ValueOf<'t, R> = Rc<dyn Fn(&R) -> Value + 't>;

/// What a table shows of rows of a kind: its columns, and the value of each in a row.
pub struct Selection<'t, R> {
    columns: Vec<(Column, ValueOf<'t, R>)>,
}

impl<'t, R> Selection<'t, R> {
    /// A selection without columns.
    pub fn new() -> Self {
        Self { columns: Vec::new() }
    }

    /// Adds a column.
    #[must_use]
    pub fn column<V: Into<Value>>(mut self, column: Column, value: impl Fn(&R) -> V + 't) -> Self {
        self.columns.push((column, Rc::new(move |row| value(row).into())));
        self
    }

    /// Adds a column of words.
    #[must_use]
    pub fn text<V: Into<Value>>(self, head: impl Into<String>, value: impl Fn(&R) -> V + 't) -> Self {
        self.column(Column::text(head), value)
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn number<V: Into<Value>>(self, head: impl Into<String>, value: impl Fn(&R) -> V + 't) -> Self {
        self.column(Column::number(head), value)
    }

    /// Adds a column for each of these.
    #[must_use]
    pub fn each<T: 't, V: Into<Value>>(
        self,
        items: impl IntoIterator<Item = T>,
        column: impl Fn(&T) -> Column,
        value: impl Fn(&T, &R) -> V + 't,
    ) -> Self {
        let value = Rc::new(value);
        items.into_iter().fold(self, |selection, item| {
            let value = value.clone();
            selection.column(column(&item), move |row| value(&item, row))
        })
    }

    /// The same of rows that have such a row as a part.
    pub fn of<S>(self, part: impl Fn(&S) -> &R + Copy + 't) -> Selection<'t, S>
    where
        R: 't,
    {
        let columns = self.columns.into_iter();
        columns.fold(Selection::new(), |all, (column, value)| all.column(column, move |row| value(part(row))))
    }

    /// Adds more columns where this is true.
    #[must_use]
    pub fn when(self, is_shown: bool, more: impl FnOnce(Self) -> Self) -> Self {
        if is_shown { more(self) } else { self }
    }

    /// The table of some rows.
    pub fn table<'r>(&self, rows: impl IntoIterator<Item = &'r R>) -> Table
    where
        R: 'r,
    {
        Table { head: self.head(), rows: rows.into_iter().map(|row| self.row(row)).collect(), ..Table::default() }
    }

    /// The table of groups of rows, each below a row with its heading.
    pub fn grouped<'r>(&self, groups: impl IntoIterator<Item = (String, Vec<&'r R>)>) -> Table
    where
        R: 'r,
    {
        let mut rows = Vec::new();
        for (heading, members) in groups {
            let blank = std::iter::repeat_n("".into(), self.columns.len() - 1);
            rows.push(std::iter::once(heading.into()).chain(blank).collect());
            rows.extend(members.into_iter().map(|row| self.row(row)));
        }
        Table { head: self.head(), rows, ..Table::default() }
    }

    fn head(&self) -> Vec<Column> {
        self.columns.iter().map(|(column, _)| column.clone()).collect()
    }

    fn row(&self, row: &R) -> Vec<Value> {
        self.columns.iter().map(|(_, value)| value(row)).collect()
    }
}

impl<'t> Selection<'t, Cell> {
    /// Adds a column of a metric in the form of its role.
    #[must_use]
    pub fn metric(self, column: Column, metric: &'static Metric) -> Self {
        self.column(column, |cell| Value::metric(cell, metric))
    }
}

/// The values that differ, in the order of first appearance.
pub fn unique<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// Where a section is read. The page shows all, and a terminal too with `--details`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Depth {
    /// At the end of a run, in the summary, and on the page.
    #[default]
    First,
    /// In the summary and on the page.
    Summary,
    Page,
}

/// A part of a report: a heading with figures and tables, and how to read them. The summary, the page and a terminal show it.
#[derive(Debug, Clone, Default)]
pub struct Section {
    /// Its `id` on the page.
    pub id: &'static str,
    /// Its name in a list of contents.
    pub name: &'static str,
    /// The heading.
    pub title: &'static str,
    pub depth: Depth,
    /// What must be read before the tables, in Markdown, a paragraph each.
    pub lead: Vec<String>,
    /// Pictures, for the page.
    pub figures: Vec<Figure>,
    pub tables: Vec<Table>,
    /// A picture that the page shows in place of the tables.
    pub picture: Option<Markup>,
    /// How to read them, in Markdown, a paragraph each.
    pub notes: Vec<String>,
    /// Lines below the tables in a terminal, of any depth.
    pub lines: Vec<String>,
}

impl Section {
    /// Those that the summary and the page show.
    pub fn tables_of_report(&self) -> impl Iterator<Item = &Table> {
        self.tables.iter().filter(|table| table.place != Place::Terminal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Rate;

    fn table() -> Table {
        Table {
            place: Place::Everywhere,
            title: "Rates".into(),
            head: vec![Column::text("who"), Column::number("rate"), Column::number("runs").detail()],
            rows: vec![
                vec![
                    "a|<b>".into(),
                    (&Rate { value: Some(0.5), sd: Some(0.125), ..Rate::default() }).into(),
                    Value::Count(1234),
                ],
                vec![Value::Text("c".into(), Mark::Link("c.svg".into())), Value::number(None, 2), Value::Of(1, 2)],
            ],
            notes: vec!["A *rate* is `hits` of all.".into()],
        }
    }

    #[test]
    fn a_selection_has_a_heading_and_a_value_for_each_column() {
        let shown = Selection::new()
            .text("name", |(name, _): &(&str, [u64; 2])| (*name).to_owned())
            .each([0, 1], |run| Column::number(format!("run {run}")), |run, (_, counts)| counts[*run])
            .when(false, |shown| shown.text("absent", |_| "x"));
        let rows = [("a", [1, 2]), ("b", [3, 4])];
        let groups = [("first".to_owned(), vec![&rows[0]]), ("second".to_owned(), vec![&rows[1]])];
        assert_eq!(
            shown.table(&rows).to_terminal(80),
            "  name  run 0  run 1\n  a         1      2\n  b         3      4\n"
        );
        assert_eq!(shown.grouped(groups).rows[2], vec!["second".into(), Value::from(""), "".into()]);
        assert_eq!(unique([2, 1, 2]), [2, 1]);
    }

    #[test]
    fn a_table_is_the_same_in_three_forms() {
        assert_eq!(table().to_terminal(80), "  who           rate\n  a|<b>  0.50 ± 0.12\n  c                –\n");
        assert_eq!(
            table().to_markdown(),
            "Rates:\n\n| who | rate | runs |\n|---|--:|--:|\n| a\\|<b> | 0.50 ± 0.12 | 1234 |\n| [c](c.svg) | – | 1 of 2 |\n\n\
             A *rate* is `hits` of all.\n"
        );
        let html = table().to_html().into_string();
        for part in [
            "<h3>Rates</h3>",
            "<th class=\"number\">rate</th>",
            "<th scope=\"row\">a|&lt;b&gt;</th>",
            "<summary>All columns</summary>",
            "<dt>runs</dt><dd>1\u{202f}234</dd>",
            "<td class=\"number\" data-label=\"rate\">0.50 ± 0.12</td>",
            "<a href=\"c.svg\">c</a>",
            "A <em>rate</em> is <code>hits</code> of all.",
        ] {
            assert!(html.contains(part), "{part}: {html}");
        }
        assert!(!html.contains("<th class=\"number\">runs</th>"), "a detail has no column of its own: {html}");
    }
}
