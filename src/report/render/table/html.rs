use maud::{Markup, html};

use super::{Align, Section, Table, Value};
use crate::report::render::page::{count, paragraph, percent};

impl Table {
    /// The table for a page, with its title and notes.
    pub fn to_html(&self) -> Markup {
        let class = |column: usize| (self.head[column].align == Align::Right).then_some("number");
        html! {
            @if !self.title.is_empty() { h3 { (self.title) } }
            div.wide {
                table {
                    thead {
                        tr { @for (place, column) in self.head.iter().enumerate() { th class=[class(place)] { (column.name) } } }
                    }
                    tbody {
                        @for row in &self.rows {
                            tr {
                                @for (place, each) in row.iter().enumerate() {
                                    @if place == 0 { th scope="row" { (value(each)) } }
                                    @else { td class=[class(place)] { (value(each)) } }
                                }
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
    /// The section for a page.
    pub fn to_html(&self) -> Markup {
        html! {
            section id=(self.id) {
                h2 { (self.title) }
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
}

fn value(value: &Value) -> Markup {
    html! {
        @match value {
            Value::Code(text) => code { (text) },
            Value::Link(text, file) => a href=(file) { (text) },
            Value::Warning(text) => span.warn { (text) },
            Value::Count(number) => (count(*number)),
            Value::Times(runs, each) => { (runs) " × " (count(*each)) },
            Value::Percent(share) => (percent(*share)),
            Value::Lines(lines) => @for (place, line) in lines.iter().enumerate() {
                @if place > 0 { br; }
                (self::value(line))
            },
            other => (other.to_string()),
        }
    }
}
