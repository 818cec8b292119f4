use std::fmt::Write;

use crate::report::Cell;
use crate::report::render::table::{Column, Value};

/// The columns that name a cell.
pub fn head() -> Vec<Column> {
    ["controller", "reward", "trained in, against", "town", "policy"].map(Column::text).into()
}

/// The values that name a cell.
pub fn names(cell: &Cell, cells: &[Cell]) -> Vec<Value> {
    vec![
        Value::from(&cell.key.controller),
        Value::from(&cell.key.reward),
        training(cell).into(),
        place(cell, cells).into(),
        Value::from(&cell.key.policy),
    ]
}

/// The town and the policy in which the controller of a cell was trained.
pub fn training(cell: &Cell) -> String {
    if cell.key.is_trained() {
        format!("{}, {}", cell.key.train_town, cell.key.train_policy)
    } else {
        "–".to_string()
    }
}

/// The town of a cell, with all else that differs between the cells: vehicle, adversary, `evaluate` block.
pub fn place(cell: &Cell, cells: &[Cell]) -> String {
    let mut text = cell.key.town.clone();
    if cells.iter().any(|other| other.key.vehicle != cell.key.vehicle) {
        let _ = write!(text, ", {}", cell.key.vehicle);
    }
    if cells.iter().any(|other| other.key.adversary != cell.key.adversary) {
        let _ = write!(text, ", {}", cell.key.adversary);
    }
    if cells.iter().any(|other| other.key.block != cell.key.block) {
        let _ = write!(text, " #{}", cell.key.block);
    }
    text
}
