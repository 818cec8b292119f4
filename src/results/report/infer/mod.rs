//! The evidence of the results for further trainings and episodes: intervals, comparisons on common starts, transfer gaps.
//!
//! Episodes come run by run. They stay in memory while runs of their place come. A place is a town, a vehicle and an adversary of one
//! `evaluate` block. All controllers and all driving policies of a place have the same starts.

mod figure;
mod tried;
mod place;
mod cell;
mod comparison;
mod transfer;
mod learning;
mod gather;
mod tables;
mod sides;
#[cfg(test)]
mod tests;

pub use cell::{CellEvidence, Quantiles};
pub use comparison::{Comparison, Test, adjust};
pub use figure::Figure;
pub use gather::{Evidence, Gathering};
pub use learning::{Baseline, Doubt, Learning, Learnt, Reason, TrainingDifference, Untrained, doubts};
pub use sides::sides;
pub use tables::{
    LEARNT, QUANTILES, cell_table, comparison_columns, comparison_table, evident_cells, reference_metrics,
    transfer_columns, transfer_table,
};
pub use transfer::{Change, Transfer};
