//! Two sides, start by start: two reports, or two driving policies of one report.
//!
//! Runs are matched by their keys, and episodes by their numbers where their starts are equal by hash. So every difference is between two
//! episodes that began alike. Searches are matched by falsifier, town, budget and first start, and compared over the starts that both tried. What differs between the reports besides is a [`Caveat`].

mod caveat;
mod matching;
mod paired_rate;
mod episodes;
mod comparison;
mod searches;
mod table;

pub use caveat::Caveat;
pub use comparison::{ALL_UNTRAINED, ComparedCell, ReportComparison, compare_reports, drivers};
pub use matching::Side;
pub use paired_rate::{CountedEvent, PairedRate};
pub use searches::{ComparedSearch, TRIED_STARTS, compared_search_table};
pub use table::{COMMON_STARTS, DIFFERING, compared_cells, comparison_reference};
