use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Width};

use super::{Align, Depth, Mark, Place, Section, Table, Value};

/// The gap before a column.
const GAP: u16 = 2;

impl Table {
    /// The brief columns as text for a terminal of this width (columns), without title and notes.
    ///
    /// Words of wider tables are wrapped. A table that is wider even so comes in parts, each with the key columns.
    pub fn to_terminal(&self, width: u16) -> String {
        let brief: Vec<usize> = (0..self.head.len()).filter(|column| self.head[*column].is_brief).collect();
        let parts: Vec<String> = self.parts(&brief, width.into()).iter().map(|part| self.part(part, width)).collect();
        parts.join("\n")
    }

    /// The columns, in parts for which there is room.
    fn parts(&self, brief: &[usize], width: usize) -> Vec<Vec<usize>> {
        let least = |columns: &[usize]| columns.iter().map(|column| self.least_width(*column)).sum::<usize>();
        let is_key = |column: &usize| self.head[*column].is_key || brief.first() == Some(column);
        let (keys, others): (Vec<usize>, Vec<usize>) = brief.iter().partition(|column| is_key(column));
        if least(brief) <= width || others.is_empty() {
            return vec![brief.to_vec()];
        }
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for column in others {
            match parts.last_mut().filter(|part| least(part) + self.least_width(column) <= width) {
                Some(part) => part.push(column),
                None => parts.push([keys.as_slice(), &[column]].concat()),
            }
        }
        parts
    }

    /// The least width of a column with its gap (columns). Words stay in one piece, and so do numbers and names that a reader copies, with their blanks.
    fn least_width(&self, column: usize) -> usize {
        let head = &self.head[column];
        let values = || self.rows.iter().map(|row| &row[column]);
        let is_whole = head.align == Align::Right
            || values().any(|value| matches!(value, Value::Text(_, Mark::Code | Mark::Failure)));
        let longest = |text: &str| text.split_whitespace().map(|word| word.chars().count()).max().unwrap_or(0);
        let least = |text: String| if is_whole { text.chars().count() } else { longest(&text) };
        let widest = values().map(|value| least(value.to_string())).max().unwrap_or(0);
        widest.max(longest(&head.name)) + usize::from(GAP)
    }

    /// Some columns as text. Words are wrapped where there is no room.
    fn part(&self, columns: &[usize], width: u16) -> String {
        let mut table = self.terminal_table(columns);
        let wide = table.trim_fmt() + "\n";
        if wide.lines().all(|line| line.chars().count() <= width.into()) {
            return wide;
        }
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
        for (column, place) in table.column_iter_mut().zip(columns) {
            if let Ok(least) = u16::try_from(self.least_width(*place)) {
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(least)));
            }
        }
        table.trim_fmt() + "\n"
    }

    fn terminal_table(&self, columns: &[usize]) -> comfy_table::Table {
        let mut table = comfy_table::Table::new();
        table.load_preset(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(columns.iter().map(|column| &self.head[*column].name));
        for row in &self.rows {
            table.add_row(columns.iter().map(|column| row[*column].to_string()));
        }
        for (column, place) in table.column_iter_mut().zip(columns) {
            column.set_padding((GAP, 0));
            column.set_cell_alignment(match self.head[*place].align {
                Align::Left => CellAlignment::Left,
                Align::Right => CellAlignment::Right,
            });
        }
        table
    }
}

impl Section {
    /// Its tables, if it is one of the first or `details` are wanted, and its lines, for a terminal of this width (columns); empty if it has none.
    pub fn to_terminal(&self, width: u16, details: bool) -> String {
        let mut text = String::new();
        let is_shown = details || self.depth == Depth::First;
        for table in self.tables.iter().filter(|table| is_shown && table.place != Place::Report) {
            if !table.title.is_empty() {
                text.push_str(&format!("{}\n", table.title));
            }
            text.push_str(&table.to_terminal(width));
        }
        self.lines.iter().for_each(|line| text.push_str(&format!("{line}\n")));
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::Column;
    use super::*;

    #[test]
    fn a_table_that_is_too_wide_comes_in_parts_with_its_keys() {
        let words = |text: &str| Value::text(text);
        let mut head = vec![Column::text("driver"), Column::number("overlap").key()];
        head.extend((20..26).map(|speed| Column::number(format!("{speed} km/h"))));
        let row = |driver: &str| {
            [words(driver), words("50 %")].into_iter().chain((0..6).map(|_| words("8.6 fails"))).collect()
        };
        let table = Table { head, rows: vec![row("idm"), row("blind")], ..Table::default() };
        let text = table.to_terminal(52);
        assert!(text.lines().all(|line| line.chars().count() <= 52), "{text}");
        let parts: Vec<&str> = text.split("\n\n").collect();
        assert_eq!(parts.len(), 2, "{text}");
        for part in parts {
            assert!(part.contains("driver") && part.contains("overlap") && part.contains("idm"), "{part}");
            assert_eq!(part.matches("8.6 fails").count(), 6, "{part}");
        }
        // In one part where there is room.
        assert_eq!(table.to_terminal(90).matches("driver").count(), 1);
    }

    #[test]
    fn words_are_wrapped_and_not_broken() {
        let words = |text: &str| Value::text(text);
        let head = vec![Column::text("driver"), Column::text("worst failure"), Column::number("rate")];
        let rows = vec![vec![words("idm"), words("fault, 12.5 m/s"), words("0.00 (0.00..0.26)")]];
        let text = Table { head, rows, ..Table::default() }.to_terminal(44);
        assert!(text.contains("fault,") && text.contains("0.00 (0.00..0.26)"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 44), "{text}");
    }
}
