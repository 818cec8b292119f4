use std::fmt::Write;

use crate::record::in_block;
use crate::report::render::table::Selection;
use crate::tables::{Cell, Cells};

pub fn names(cells: &Cells) -> Selection<'_, Cell> {
    Selection::new()
        .text("pedestrian", |cell: &Cell| cell.key.controller.clone())
        .text("reward", |cell| cell.key.is_of_reward().then(|| cell.key.reward.clone()))
        .text("trained in, against", training)
        .text("town", |cell| place(cell, cells))
        .text("driver", |cell| cell.key.policy.clone())
}

/// The controller of a cell, with what distinguishes it from the others: its reward if it was trained, and its training if there are several.
pub fn who(cell: &Cell, cells: &Cells) -> String {
    if !cell.key.is_of_reward() {
        return cell.key.controller.clone();
    }
    let reward = format!("{}, {}", cell.key.controller, cell.key.reward);
    if !cell.key.is_trained() {
        return reward;
    }
    if cells.varied().training { format!("{reward} ({})", training(cell)) } else { reward }
}

/// The town and the policy in which the controller of a cell was trained.
pub fn training(cell: &Cell) -> String {
    if cell.key.is_trained() {
        format!("{}, {}", cell.key.train_town, cell.key.train_policy)
    } else {
        "–".to_string()
    }
}

/// The town of a cell, with all else that differs between the cells: vehicle, adversary, world, `evaluate` block.
pub fn place(cell: &Cell, cells: &Cells) -> String {
    let mut text = cell.key.town.clone();
    let varied = cells.varied();
    if varied.vehicle {
        let _ = write!(text, ", {}", cell.key.vehicle);
    }
    if varied.adversary {
        let _ = write!(text, ", {}", cell.key.adversary);
    }
    if varied.world {
        let _ = write!(text, ", {}", cell.key.world);
    }
    text + &in_block("evaluate", cell.key.block)
}
