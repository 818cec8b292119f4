//! The visible parts of a report: tables as text, pictures, the summary, the page.
//!
//! Nothing here computes a result. [`sections`](sections::sections) makes the sections of a report; each is rendered for a terminal, as Markdown and as HTML. Pictures are drawn
//! with [`svg`].

pub(crate) mod table;
pub(crate) mod svg;
mod sections;
mod town;
mod episode;
mod summary;
mod page;
mod overview;
mod junit;
mod change_report;
mod comparison_sections;
mod recheck_sections;
mod judgement_page;

pub use change_report::{ChangeReport, PlayedPair, change_page, change_text};
pub use comparison_sections::{comparison_report, worsening};
pub use episode::{Narrative, animation, narrative, strip};
pub use judgement_page::judgement_page;
pub use junit::{Suite, junit};
pub use overview::{overview_for_terminal, overview_page};
pub use page::{Replay, Tally, listed, page_examples, write_page};
pub(super) use page::{author_and_date, document};
pub use recheck_sections::recheck_report;
pub(crate) use sections::search_section;
pub use sections::{Group, SectionMaker, failures_for_terminal, sections, share_of_two};
pub(super) use sections::{place, who};
pub use summary::{SMOKE, summary};
pub use table::Section;
pub(super) use table::{Column, Selection, Table, Value};
pub use town::{MapPage, StartLayer, Starts, TownView, map_page, spawn_map, town_map};
pub(super) use {sections::FAULT, summary::LEFT_OUT};
