//! The tables of a report, in the order of the flow: episodes → runs → cells.
//!
//! Each is an expression list over the one before. A [`Metric`] is one entry; the sums of a run, its value, and mean, deviation, values of the runs and interval
//! of a cell follow from it.

pub mod metrics;
mod rate;
mod cells;
mod runs;
pub mod pairs;

pub use cells::{Cell, Cells, IS_FIXED_CASES, Varied, cell_columns, key_columns};
pub use metrics::{METRICS, Metric};
pub use pairs::Changed;
pub use rate::{Method, Rate};
pub use runs::Runs;
