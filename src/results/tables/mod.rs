//! The tables of a report, in the order of the flow: episodes → runs → cells, requirements of episodes likewise, and searches → cells and pairs of searches.
//!
//! Each is an expression list over the one before. A [`Metric`] is one entry; the sums of a run, its value, and mean, deviation, values of the runs and interval
//! of a cell follow from it.

pub mod metrics;
pub mod overview;
mod requirements;
mod rate;
mod rows;
mod statistics;
mod cells;
mod runs;
mod searches;
pub mod pairs;

pub use cells::{Cell, Cells, IS_FIXED_CASES, Varied, cell_columns, key_columns};
pub use metrics::{METRICS, Metric};
pub use pairs::Changed;
pub use rate::Rate;
pub use requirements::{
    APPLIED, APPLIES, COUNTS, FAULT_VIOLATION_RATE, FAULT_VIOLATIONS, IS_FAULT, IS_PREVENTABLE, JUDGED, NO_VERDICT,
    PREVENTABLE_VIOLATION_RATE, PREVENTABLE_VIOLATIONS, REQUIREMENT, REQUIREMENT_METRICS, VIOLATED, VIOLATION_RATE,
    VIOLATIONS, WITHOUT_VERDICT,
};
pub use rows::{Row, Rows};
pub use runs::Runs;
pub(crate) use searches::{BREACH_COUNT, search_cells, search_pairs, searched_drivers};
pub use searches::{
    BUDGET, DIFFERENCE, DIFFERENCES, EVALUATED_EPISODES, EVALUATED_FAULTS, FAILED_STARTS, FAILURE_COUNT, FALSIFIED,
    FAULT_COUNT, FAULT_START_RATE, FAULT_STARTS, FIGURE, FIRST_FAILURE, FIRST_FAULT, FIRST_SIMULATIONS, FIRST_START,
    GOAL, INJURY, IS_OF_METHODS, METHOD, OTHER, P_HOLM, PAIR, PLACE, PREVENTABLE_COUNT, SEARCH_BLOCK, SEARCH_EPISODES,
    SEARCH_RUN, SIMULATIONS_MEAN, SIMULATIONS_MEDIAN, STARTS, TRIED, USED, median_column, search_cell_columns,
};
pub use statistics::student as student_interval;
pub(crate) use statistics::{adjusted, interval, statistic};
