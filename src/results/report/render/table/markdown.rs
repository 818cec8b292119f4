use std::fmt::Write;

use super::{Align, Mark, Section, Table, Value};

impl Table {
    /// The table as Markdown, with its title and notes.
    pub fn to_markdown(&self) -> String {
        let mut page = String::new();
        if !self.title.is_empty() {
            let _ = writeln!(page, "{}:\n", self.title);
        }
        let names: Vec<&str> = self.head.iter().map(|column| column.name.as_str()).collect();
        let _ = writeln!(page, "| {} |", names.join(" | "));
        for column in &self.head {
            page.push_str(if column.align == Align::Right { "|--:" } else { "|---" });
        }
        page.push_str("|\n");
        for row in &self.rows {
            let values: Vec<String> = row.iter().map(value).collect();
            let _ = writeln!(page, "| {} |", values.join(" | "));
        }
        self.notes.iter().for_each(|note| page.push_str(&format!("\n{note}\n")));
        page
    }
}

impl Section {
    /// The section as Markdown, below a heading of the second level.
    pub fn to_markdown(&self) -> String {
        let mut page = format!("\n## {}\n", self.title);
        self.lead.iter().for_each(|paragraph| page.push_str(&format!("\n{paragraph}\n")));
        self.tables_of_report().for_each(|table| page.push_str(&format!("\n{}", table.to_markdown())));
        self.notes.iter().for_each(|note| page.push_str(&format!("\n{note}\n")));
        page
    }
}

fn value(value: &Value) -> String {
    match value {
        Value::Text(words, Mark::Code | Mark::Failure) => format!("`{words}`"),
        Value::Text(words, Mark::Link(file)) => format!("[{}]({file})", escaped(words)),
        Value::Text(words, Mark::Warning) => format!("**{}**", escaped(words)),
        Value::Lines(lines) => lines.iter().map(self::value).collect::<Vec<_>>().join("<br>"),
        other => escaped(&other.to_string()),
    }
}

/// A vertical bar would end the column.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|")
}
