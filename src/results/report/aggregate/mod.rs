//! Aggregates episodes to runs, runs to cells, and searches to cells of searches; defines their tables.
//!
//! Metrics are aggregated in two steps, as in the paper: episodes → run → cell. A "±" is the standard deviation over runs, that is
//! over trainings. An interval is Wilson's over the starts, which all runs share, and says nothing about further trainings;
//! [`infer`](super::infer) has intervals that do.

mod episodes;
mod failures;
mod drivers;
mod results;
mod requirements;
mod aggregates;
mod search_figures;
mod searches;
mod search_cells;
mod search_comparisons;
mod published;
mod protocol;
mod ticks;

pub use aggregates::{Aggregates, aggregate_episodes};
pub use drivers::{DriverResult, SearchFailures, driver_results, worst_failure};
pub use episodes::{Episodes, Run};
pub use failures::Failures;
pub use protocol::{Colour, PROTOCOL, ProtocolCell, layer_cells, passed_share, protocol_table, score};
pub use published::{PublishedComparison, beside};
pub use requirements::{
    APPLIES, CellRequirement, Counted, GATED, INSTANT, PART, REQUIREMENT, REQUIREMENTS, ROBUSTNESS, ROBUSTNESS_UNIT,
    requirement_table,
};
pub use results::{RESULTS, results, results_table};
pub use search_cells::{SearchCell, search_cell_table, search_cells};
pub use search_comparisons::{SearchComparison, search_comparisons};
pub use search_figures::{FIRST_FAILURE, FIRST_FAULT};
pub use searches::{
    BUDGET, FIRST_START, METHOD, SEARCH_BLOCK, SEARCH_RUN, SEARCHES, STARTS, TRIED, search_key, search_table, searches,
};
pub use ticks::{tick_table, ticks};
