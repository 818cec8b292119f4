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
mod comparison_text;
mod comparison_page;
mod recheck_text;

pub use comparison_page::{PlayedPair, comparison_page};
pub use comparison_text::{
    comparison_for_terminal, search_title as compared_search_title, title as comparison_title, worst_changes,
};
pub use episode::{Narrative, animation, narrative, strip};
pub use junit::{Suite, junit, shown};
pub use modes::{file_names, mode_panels, modes_section, rule_bars};
pub use overview::{overview_for_terminal, overview_page};
pub use page::{Replay, Tally, page_examples, write_page};
pub use recheck_text::{crossed_title, recheck_for_terminal, rechecked_title};
pub use sections::{
    cover_section, covers_for_terminal, drivers_for_terminal, estimates, estimates_for_terminal, failures_for_terminal,
    hardened_for_terminal, hardened_section, protocol, protocol_for_terminal, published_section, requirements,
    requirements_for_terminal, results_for_terminal, search_section, searches_for_terminal, trainings_section,
};
pub use summary::summary;
pub use table::Section;
pub use town::{MapPage, StartLayer, Starts, TownView, map_page, spawn_map, town_map};
