//! What a campaign shows and what it does not: intervals over trainings, comparisons on common beginnings, transfer gaps.
//!
//! Episodes come run by run and are kept only as long as the place is at hand in which they were tried: a town, a policy, a vehicle and
//! an adversary of one `evaluate` block. All pedestrians of a place meet the same beginnings.

mod figure;
mod tried;
mod place;
mod cell;
mod comparison;
mod transfer;
mod gather;
mod columns;
mod tables;
#[cfg(test)]
mod tests;

pub use cell::{Between, CellEvidence, Quantiles};
pub use comparison::{Comparison, Test};
pub use figure::Figure;
pub use gather::{Evidence, Gathering};
pub use tables::{cell_columns, comparison_table, transfer_table};
pub use transfer::{Change, Transfer};
