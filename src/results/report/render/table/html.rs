use maud::{Markup, html};

use super::{Align, Mark, Section, Table, Value};
use crate::report::render::page::{count, paragraph, percent};

/// The place of the player of a failure on the page; `None` if it is not played.
pub type PlayerOf<'a> = &'a dyn Fn(&str) -> Option<String>;

/// A table with more rows is folded on a page.
const LONG: usize = 30;

impl Table {
    /// The table for a page, with its title and notes. Columns that do not fit beside the others are in a list that can be unfolded.
    pub fn to_html(&self) -> Markup {
        self.to_html_with(&|_| None)
    }

    /// The same with links to the players of failures.
    pub fn to_html_with(&self, player: PlayerOf<'_>) -> Markup {
        let rows = self.rows.len();
        if rows <= LONG {
            return html! { @if !self.title.is_empty() { h3 { (self.title) } } (self.unfolded(player)) };
        }
        let title = if self.title.is_empty() { "All rows" } else { self.title.as_str() };
        html! { details { summary { (title) ", " (rows) " rows" } (self.unfolded(player)) } }
    }

    fn unfolded(&self, player: PlayerOf<'_>) -> Markup {
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
                                    @if place == 0 { th scope="row" { (value(&row[*column], player)) } }
                                    @else {
                                        td class=[class(*column)] data-label=(self.head[*column].name) { (value(&row[*column], player)) }
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
                                div { dt { (column.name) } dd { (value(each, player)) } }
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
    pub fn to_html(&self, player: PlayerOf<'_>) -> Markup {
        html! {
            @for paragraph in &self.lead { (self::paragraph(paragraph)) }
            @for figure in &self.figures { (figure.to_html()) }
            @match &self.picture {
                Some(picture) => (picture),
                None => @for table in self.tables_of_report() { (table.to_html_with(player)) },
            }
            @if !self.notes.is_empty() {
                details {
                    summary { "How to read this" }
                    @for note in &self.notes { (paragraph(note)) }
                }
            }
        }
    }
}

fn value(value: &Value, player: PlayerOf<'_>) -> Markup {
    html! {
        @match value {
            Value::Text(words, mark) => (marked(words, mark, player)),
            Value::Played(value, name) => @match player(name) {
                Some(place) => a href=(place) title="play it" { (self::value(value, player)) },
                None => (self::value(value, player)),
            },
            Value::Count(number) => (count(*number)),
            Value::Times(runs, each) => { (runs) " × " (count(*each)) },
            Value::Percent(share) => (percent(*share)),
            // The interval is below its number, so that many columns fit side by side.
            Value::Number(number) => @match number.with_ends() {
                Some((number, ends)) => { (number) " " small { (ends) } },
                None => (number.to_string()),
            },
            Value::Change(before, after) => span.change { (self::value(before, player)) " " span { "→ " (self::value(after, player)) } },
            Value::Lines(lines) => @for (place, line) in lines.iter().enumerate() {
                @if place > 0 { " " br; }
                (self::value(line, player))
            },
            Value::Of(..) => (value.to_string()),
        }
    }
}

fn marked(words: &str, mark: &Mark, player: PlayerOf<'_>) -> Markup {
    html! {
        @match mark {
            Mark::Plain => (words),
            Mark::Code => code { (words) },
            Mark::Link(file) => a href=(file) { (words) },
            Mark::Warning => span.warn { (words) },
            Mark::Tone(tone) => span.tone.(tone) { (words) },
            Mark::Failure => {
                @if let Some(place) = player(words) { a.play href=(place) { "play" } " " }
                code { (words) }
            },
        }
    }
}
