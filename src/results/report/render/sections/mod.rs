//! The sections of a report: each makes its tables once, for the summary and for the page.

mod names;
mod scale;
mod drivers;
mod results;
mod avoidable;
mod further_trainings;
mod learnt;
mod comparisons;
mod transfer;
mod severity;
mod reference_drivers;
mod published;
mod requirements;
mod protocol;
mod searches;
mod search_pairs;
mod estimates;
mod trainings;
mod failures;
mod covers;
mod hardened;

pub use comparisons::comparisons;
pub use covers::{cover_section, covers_for_terminal};
pub use drivers::{drivers, injury, injury_scale};
pub use estimates::estimates;
pub use failures::failures_for_terminal;
pub use hardened::{hardened_for_terminal, hardened_section};
pub use learnt::learnt;
pub use names::{distinct, place, who};
pub use protocol::{PROTOCOL, protocol};
pub use published::published_section;
pub use requirements::requirements;
pub use results::{errors, results};
pub use scale::{RateOf, Scale};
pub use searches::{average, failed_starts, search_section, who as searcher};
pub use trainings::trainings_section;
pub use transfer::transfer;

use super::table::{Section, Table};
use crate::jobs::EstimateResult;
use crate::report::{Cell, CellRequirement, Doubt, DriverResult, Evidence, ProtocolCell, SearchCell, SearchComparison};

/// The rates of a campaign's controllers as text for a terminal of this width (columns); empty without cells.
pub fn results_for_terminal(results: &[DriverResult], cells: &[Cell], width: u16) -> String {
    if cells.is_empty() { String::new() } else { results::rates(cells, Scale::new(results, cells)).to_terminal(width) }
}

/// What was found about each driver as text for a terminal of this width (columns).
pub fn drivers_for_terminal(results: &[DriverResult], cells: &[Cell], width: u16) -> String {
    let section = drivers(results, cells, |_| None);
    let text = |table: Table| {
        let title = if table.title.is_empty() { String::new() } else { format!("{}\n", table.title) };
        format!("{title}{}", table.to_terminal(width))
    };
    section.into_iter().flat_map(|section| section.tables).map(text).collect()
}

/// The results in the tests of a protocol as text for a terminal of this width (columns); empty without a test.
pub fn protocol_for_terminal(cells: &[ProtocolCell], layers: &[ProtocolCell], width: u16) -> String {
    let tables = protocol(cells, layers, &|_| None).map_or_else(Vec::new, |section| section.tables);
    tables.iter().map(|table| format!("{}\n{}", table.title, table.to_terminal(width))).collect()
}

/// The rates of violations of a campaign's requirements as text for a terminal of this width (columns); empty without requirements.
pub fn requirements_for_terminal(cells: &[Cell], found: &[CellRequirement], width: u16) -> String {
    let tables = requirements(cells, found, &|_, _| None).map_or_else(Vec::new, |section| section.tables);
    tables.iter().map(|table| format!("violations of requirements\n{}", table.to_terminal(width))).collect()
}

/// The falsifiers as text for a terminal of this width (columns), and which of them find more than by chance; empty without any.
pub fn searches_for_terminal(cells: &[SearchCell], compared: &[SearchComparison], width: u16) -> String {
    if cells.is_empty() {
        return String::new();
    }
    // Nothing is known of a search that tried no start.
    let known = !cells.iter().any(SearchCell::is_empty);
    let told = search_pairs::findings_of_pairs(compared).filter(|_| known).map(|told| format!("{told}\n"));
    searches::falsifiers(cells).to_terminal(width) + &told.unwrap_or_default()
}

/// How likely failures are as text for a terminal of this width (columns); empty without an estimate.
pub fn estimates_for_terminal(results: &[EstimateResult], width: u16) -> String {
    let ended: Vec<&EstimateResult> = results.iter().filter(|result| result.estimate.is_some()).collect();
    if ended.is_empty() {
        String::new()
    } else {
        format!("how likely in an encounter\n{}", estimates::table(&ended).to_terminal(width))
    }
}

/// The conclusions from the cells, one section each.
pub fn conclusions(cells: &[Cell], evidence: &Evidence, doubts: &[Doubt]) -> Vec<Section> {
    let rows = distinct(cells);
    let is_row = |cell: &Cell| rows.iter().any(|row| std::ptr::eq(*row, cell));
    let both: Vec<_> = cells.iter().zip(&evidence.cells).filter(|(cell, _)| is_row(cell)).collect();
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
