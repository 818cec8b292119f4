//! What people see of a report: tables as text, pictures, the summary, the page.
//!
//! Nothing here computes a result. Each file is a function from numbers to text.

mod episode;
mod junit;
mod modes;
mod page;
mod summary;
mod svg;
mod town;

pub use episode::{Narrative, animation, narrative, strip};
pub use junit::{Suite, junit, shown};
pub use modes::{accumulation_figure, file_names, mode_panels, modes_summary, rule_bars};
pub use page::{Tally, write_page};
pub use summary::{place, search_summary, search_table, spread, summary, table, training};
pub use town::{Starts, spawn_map, town_map};
