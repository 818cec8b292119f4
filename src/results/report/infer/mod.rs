//! The evidence of the results for further trainings and episodes: intervals, and comparisons on common starts.
//!
//! Episodes come run by run. They stay in memory while runs of their place come. A place is a town, a vehicle, an adversary and a world of one
//! `evaluate` block. All controllers and all driving policies of a place have the same starts.

mod evaluated_run;
mod common_starts;
mod cell;
mod comparison;
mod learning;
mod evidence_builder;
mod tables;
mod pair;
#[cfg(test)]
mod tests;

pub use cell::CellEvidence;
pub use comparison::{Comparison, Test};
pub use evaluated_run::{EvaluatedRun, MAX_KEPT};
pub use evidence_builder::{Evidence, EvidenceBuilder};
pub use learning::{BeatsUntrained, Doubt, Learning, Reason, Untrained, doubts};
pub use pair::compare_pair;
pub use tables::{BEATS_UNTRAINED, COMPARISONS, IMPACT_SPEED_P90, comparison_table, comparisons, reference_rates};
