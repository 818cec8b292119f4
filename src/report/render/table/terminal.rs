use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ContentArrangement};

use super::{Align, Table};

impl Table {
    /// The brief columns as text for a terminal, without title and notes.
    pub fn to_terminal(&self) -> String {
        let brief: Vec<usize> = (0..self.head.len()).filter(|column| self.head[*column].is_brief).collect();
        let mut table = comfy_table::Table::new();
        table.load_preset(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(brief.iter().map(|column| &self.head[*column].name));
        for row in &self.rows {
            table.add_row(brief.iter().map(|column| row[*column].to_string()));
        }
        for (column, place) in table.column_iter_mut().zip(&brief) {
            column.set_padding((2, 0));
            column.set_cell_alignment(match self.head[*place].align {
                Align::Left => CellAlignment::Left,
                Align::Right => CellAlignment::Right,
            });
        }
        table.trim_fmt() + "\n"
    }
}
