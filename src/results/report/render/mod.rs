//! The visible parts of a report: tables as text, pictures, the summary, the page.
//!
//! Nothing here computes a result. A [`table`] is made once and rendered for a terminal, as Markdown and as HTML; a [`section`](table::Section) is a
//! heading with tables, for the summary and the page. Pictures are drawn with [`svg`].

mod table;
mod svg;
mod sections;
mod modes;
mod town;
mod episode;
mod summary;
mod page;
mod overview;
mod junit;
mod change_report;
mod comparison_sections;
mod recheck_sections;

pub use change_report::{ChangeReport, PlayedPair, change_page, change_text};
pub use comparison_sections::comparison_report;
pub use episode::{Narrative, animation, narrative, strip};
pub use junit::{Suite, junit, shown};
pub use modes::{file_names, mode_panels, modes_section, rule_bars};
pub use overview::{overview_for_terminal, overview_page};
pub use page::{Replay, Tally, page_examples, write_page};
pub use recheck_sections::recheck_report;
pub use sections::{
    cover_section, covers_for_terminal, drivers_for_terminal, estimates, estimates_for_terminal, failures_for_terminal,
    hardened_for_terminal, hardened_section, protocol, protocol_for_terminal, published_section, requirements,
    requirements_for_terminal, results_for_terminal, search_section, searches_for_terminal, trainings_section,
};
pub use summary::summary;
pub use table::Section;
pub use town::{MapPage, StartLayer, Starts, TownView, map_page, spawn_map, town_map};
