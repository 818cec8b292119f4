use crate::record::CellKey;
use crate::report::failure_modes::CellModes;

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A file name for each cell, as short as is unique.
pub fn file_names(cells: &[CellModes<'_>]) -> Vec<String> {
    let short = |CellModes { key, .. }: &CellModes<'_>| {
        format!("{}-{}-{}-{}", key.controller, key.reward, key.town, key.policy)
    };
    let long = |CellModes { key, .. }: &CellModes<'_>| {
        let CellKey { block, town, policy, vehicle, adversary, controller, reward, train_town, train_policy } = key;
        let from = if key.is_trained() { format!("-from-{train_town}-{train_policy}") } else { String::new() };
        format!("{controller}-{reward}{from}-{town}-{policy}-{vehicle}-{adversary}-{block}")
    };
    let name = |cell: &CellModes<'_>| {
        let alike = cells.iter().filter(|other| short(other) == short(cell)).count();
        if alike > 1 { long(cell) } else { short(cell) }
    };
    cells.iter().map(name).collect()
}
