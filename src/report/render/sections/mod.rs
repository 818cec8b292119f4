//! The sections of a report: each makes its tables once, for the summary and for the page.

mod names;
mod results;
mod avoidable;
mod further_trainings;
mod learnt;
mod comparisons;
mod transfer;
mod severity;
mod reference_drivers;
mod published;
mod searches;
mod trainings;
mod failures;

pub use comparisons::comparisons;
pub use failures::failures_for_terminal;
pub use learnt::learnt;
pub use names::{place, training};
pub use published::published_section;
pub use results::{errors, results};
pub use searches::search_section;
pub use trainings::trainings_section;
pub use transfer::transfer;

use super::table::{Section, Table};
use crate::report::{Cell, Doubt, Evidence, SearchCell};

/// The results of a campaign as text for a terminal.
pub fn results_for_terminal(campaign: &str, cells: &[Cell]) -> String {
    let table = if cells.is_empty() { String::new() } else { results(cells).to_terminal() };
    format!("campaign {campaign}\n{table}")
}

/// The comparison of falsifiers as text for a terminal.
pub fn searches_for_terminal(cells: &[SearchCell]) -> String {
    search_section(cells).tables.iter().map(Table::to_terminal).collect()
}

/// The conclusions from the cells, one section each.
pub fn conclusions(cells: &[Cell], evidence: &Evidence, doubts: &[Doubt]) -> Vec<Section> {
    let both: Vec<_> = cells.iter().zip(&evidence.cells).collect();
    let all = [
        avoidable::avoidable(cells),
        learnt(cells, evidence, doubts),
        further_trainings::further_trainings(cells, &both),
        comparisons(evidence),
        transfer(evidence),
        severity::severity(cells, &both),
        reference_drivers::reference_drivers(cells, &both),
    ];
    all.into_iter().flatten().collect()
}
