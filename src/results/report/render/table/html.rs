use maud::{Markup, html};

use super::{Align, Section, Table, Value};
use crate::report::render::page::{count, paragraph, percent};

/// A table with more rows is folded on a page.
const LONG: usize = 30;

impl Table {
    /// The table for a page, with its title and notes. Columns that do not fit beside the others are in a list that can be unfolded.
    pub fn to_html(&self) -> Markup {
        let rows = self.rows.len();
        if rows <= LONG {
            return html! { @if !self.title.is_empty() { h3 { (self.title) } } (self.unfolded()) };
        }
        let title = if self.title.is_empty() { "All rows" } else { self.title.as_str() };
        html! { details { summary { (title) ", " (rows) " rows" } (self.unfolded()) } }
    }

    fn unfolded(&self) -> Markup {
        let class = |column: usize| (self.head[column].align == Align::Right).then_some("number");
        let shown: Vec<usize> = (0..self.head.len()).filter(|column| self.head[*column].is_shown).collect();
        html! {
            div.wide {
                table.stack {
                    thead {
                        tr { @for column in &shown { th class=[class(*column)] { (self.head[*column].name) } } }
                    }
                    tbody {
                        @for row in &self.rows {
                            tr {
                                @for (place, column) in shown.iter().enumerate() {
                                    @if place == 0 { th scope="row" { (value(&row[*column])) } }
                                    @else {
                                        td class=[class(*column)] data-label=(self.head[*column].name) { (value(&row[*column])) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
            @if shown.len() < self.head.len() {
                details {
                    summary { "All columns" }
                    @for row in &self.rows {
                        dl.row {
                            @for (column, each) in self.head.iter().zip(row) {
                                div { dt { (column.name) } dd { (value(each)) } }
                            }
                        }
                    }
                }
            }
            @for note in &self.notes { (paragraph(note)) }
        }
    }
}

impl Section {
    /// What is below its heading, for a page.
    pub fn to_html(&self) -> Markup {
        html! {
            @for table in &self.tables { (table.to_html()) }
            @if !self.notes.is_empty() {
                details {
                    summary { "How to read this" }
                    @for note in &self.notes { (paragraph(note)) }
                }
            }
        }
    }
}

fn value(value: &Value) -> Markup {
    html! {
        @match value {
            Value::Code(text) => code { (text) },
            Value::Link(text, file) => a href=(file) { (text) },
            Value::Warning(text) => span.warn { (text) },
            Value::Toned(text, tone) => span.tone.(tone) { (text) },
            Value::Played(value, place) => a href=(place) title="play it" { (self::value(value)) },
            Value::Count(number) => (count(*number)),
            Value::Times(runs, each) => { (runs) " × " (count(*each)) },
            Value::Percent(share) => (percent(*share)),
            // The interval is below its number, so that many columns fit side by side.
            Value::Estimate(Some(number), Some((low, high)), digits) if low != high => {
                (format!("{number:.digits$}")) " " small { (format!("{low:.digits$}..{high:.digits$}")) }
            },
            Value::Difference(Some(number), Some((low, high))) => {
                (format!("{number:+.2}")) " " small { (format!("{low:+.2}..{high:+.2}")) }
            },
            Value::Change(before, after) => span.change { (self::value(before)) " " span { "→ " (self::value(after)) } },
            Value::Lines(lines) => @for (place, line) in lines.iter().enumerate() {
                @if place > 0 { " " br; }
                (self::value(line))
            },
            other => (other.to_string()),
        }
    }
}
