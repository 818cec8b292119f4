//! The metrics of a requirement, whose rows are those of its episodes.

use polars::prelude::{Expr, col, lit};

use super::metrics::{Metric, count, metrics, share};
use crate::record::columns;

columns! {
    /// name of the requirement
    pub REQUIREMENT: Column<String> = "requirement";
    /// whether the episode violates it
    pub VIOLATED: Column<bool> = "violated";
    /// whether the antecedent of an `implies` of the requirement held in a sample; where it never did, the episode says nothing about the requirement
    pub APPLIES: Column<bool> = "applies";
    /// whether the episode counts
    pub COUNTS: Column<bool> = "counts";
    /// why its violations have no verdict; missing if they have
    pub NO_VERDICT: Column<String> = "no_verdict";
    /// whether all careful drivers would not have violated it
    pub IS_PREVENTABLE: Column<bool> = "is_preventable";
    /// whether the violation counts against the driver
    pub IS_FAULT: Column<bool> = "is_fault";
}

/// The number of those that need no verdict.
pub const WITHOUT_VERDICT: usize = 4;

metrics! {
    all pub REQUIREMENT_METRICS;
    /// number of episodes that count
    pub JUDGED = count("judged", || of(lit(true)));
    /// number of episodes in which the antecedent of an `implies` of that requirement held; 0: nothing is known of its violations
    pub APPLIED = count("applied", || of(col(APPLIES.name)));
    /// number of episodes that violate that requirement of the campaign; missing if it never applied
    pub VIOLATIONS = count("violations", || of(col(VIOLATED.name)));
    /// their share of *applied*
    pub VIOLATION_RATE = share("violation_rate", &VIOLATIONS, &APPLIED);
    /// number of these that all careful drivers avoid
    pub PREVENTABLE_VIOLATIONS = count("preventable_violations", || of(col(IS_PREVENTABLE.name)));
    /// their share of *applied*
    pub PREVENTABLE_VIOLATION_RATE = share("preventable_rate", &PREVENTABLE_VIOLATIONS, &APPLIED);
    /// number of these that count against the driver
    pub FAULT_VIOLATIONS = count("fault_violations", || of(col(IS_FAULT.name)));
    /// their share of *applied*
    pub FAULT_VIOLATION_RATE = share("fault_rate", &FAULT_VIOLATIONS, &APPLIED);
}

/// Of the episodes that count.
fn of(rows: Expr) -> Expr {
    col(COUNTS.name).and(rows)
}
