use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Width};

use super::{Align, Table, Value};

/// The width of a terminal (columns). Words of wider tables are wrapped.
const WIDTH: u16 = 80;
/// The gap before a column.
const GAP: u16 = 2;

impl Table {
    /// The brief columns as text for a terminal, without title and notes.
    pub fn to_terminal(&self) -> String {
        let brief: Vec<usize> = (0..self.head.len()).filter(|column| self.head[*column].is_brief).collect();
        let mut table = self.terminal_table(&brief);
        let wide = table.trim_fmt() + "\n";
        if wide.lines().all(|line| line.chars().count() <= WIDTH.into()) {
            return wide;
        }
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
        for (column, place) in table.column_iter_mut().zip(&brief) {
            // Numbers and names that a reader copies stay in one piece; their heads may be wrapped.
            let values = self.rows.iter().map(|row| &row[*place]);
            let whole =
                self.head[*place].align == Align::Right || values.clone().any(|value| matches!(value, Value::Code(_)));
            let widest = values.map(|value| value.to_string().chars().count()).max().unwrap_or(0);
            if whole && let Ok(widest) = u16::try_from(widest) {
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(widest + GAP)));
            }
        }
        table.trim_fmt() + "\n"
    }

    fn terminal_table(&self, brief: &[usize]) -> comfy_table::Table {
        let mut table = comfy_table::Table::new();
        table.load_preset(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(brief.iter().map(|column| &self.head[*column].name));
        for row in &self.rows {
            table.add_row(brief.iter().map(|column| row[*column].to_string()));
        }
        for (column, place) in table.column_iter_mut().zip(brief) {
            column.set_padding((GAP, 0));
            column.set_cell_alignment(match self.head[*place].align {
                Align::Left => CellAlignment::Left,
                Align::Right => CellAlignment::Right,
            });
        }
        table
    }
}
