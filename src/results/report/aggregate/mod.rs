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
mod searches;
mod published;
mod protocol;
mod ticks;

pub use crate::tables::{BUDGET, METHOD, SEARCH_BLOCK};
pub use aggregates::{Aggregates, aggregate_episodes};
pub use drivers::{DriverResult, SearchFailures, driver_results, worst_failure};
pub use episodes::{Episodes, Run};
pub use failures::Failures;
pub use protocol::{Colour, PROTOCOL, ProtocolCell, layer_cells, passed_share, protocol_table, score};
pub use published::{PublishedComparison, beside};
pub use requirements::{INSTANT, PART, REQUIREMENTS, ROBUSTNESS, ROBUSTNESS_UNIT, requirement_table};
pub use results::{RESULTS, results, results_table};
pub(crate) use searches::search_pairs;
pub use searches::{
    SEARCHES, SearchCell, SearchPair, all_of_searches, search_cell_reference, search_cells, search_key, search_table,
    searches,
};
pub use ticks::{tick_table, ticks};
