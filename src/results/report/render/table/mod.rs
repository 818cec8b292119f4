//! Tables for people: made once, rendered for a terminal, as Markdown and as HTML.

mod value;
mod terminal;
mod markdown;
mod html;

pub use value::{Mark, Value};

use maud::Markup;

use super::svg::Figure;

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

/// Where a section is read. The page shows all, and a terminal too with `--details`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Depth {
    /// At the end of a run, in the summary, and on the page.
    #[default]
    First,
    /// In the summary and on the page.
    Summary,
    /// On the page.
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
                vec![Value::Text("c".into(), Mark::Link("c.svg".into())), Value::none(), Value::Of(1, 2)],
            ],
            notes: vec!["A *rate* is `hits` of all.".into()],
        }
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
