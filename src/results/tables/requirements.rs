//! The metrics of a requirement, whose rows are those of its episodes.

use polars::prelude::{Expr, col, lit};

use super::metrics::Metric;
use crate::record::Column;

pub const REQUIREMENT: Column<String> = Column::new("requirement", "", "name of the requirement");
pub const VIOLATED: Column<bool> = Column::new("violated", "", "whether the episode violates it");
pub const APPLIES: Column<bool> = Column::new(
    "applies",
    "",
    "whether the antecedent of an `implies` of the requirement held in a sample; where it never did, the episode says nothing about the requirement",
);
pub const COUNTS: Column<bool> = Column::new("counts", "", "whether the episode counts");
pub const NO_VERDICT: Column<String> =
    Column::new("no_verdict", "", "why its violations have no verdict; missing if they have");
pub const IS_PREVENTABLE: Column<bool> =
    Column::new("is_preventable", "", "whether all careful drivers would not have violated it");
pub const IS_FAULT: Column<bool> = Column::new("is_fault", "", "whether the violation counts against the driver");

/// The metrics of a requirement: those of an episode are counts, those of violations rates of the episodes in which it applied.
pub const REQUIREMENT_METRICS: [&Metric; 8] = [
    &JUDGED,
    &APPLIED,
    &VIOLATIONS,
    &VIOLATION_RATE,
    &PREVENTABLE_VIOLATIONS,
    &PREVENTABLE_VIOLATION_RATE,
    &FAULT_VIOLATIONS,
    &FAULT_VIOLATION_RATE,
];

/// The number of those that need no verdict.
pub const WITHOUT_VERDICT: usize = 4;

pub const JUDGED: Metric = Metric::count("judged", "number of episodes that count", || of(lit(true)));
pub const APPLIED: Metric = Metric::count(
    "applied",
    "number of episodes in which the antecedent of an `implies` of that requirement held; 0: nothing is known of its violations",
    || of(col(APPLIES.name)),
);
pub const VIOLATIONS: Metric = Metric::count(
    "violations",
    "number of episodes that violate that requirement of the campaign; missing if it never applied",
    || of(col(VIOLATED.name)),
);
pub const PREVENTABLE_VIOLATIONS: Metric =
    Metric::count("preventable_violations", "number of these that all careful drivers avoid", || {
        of(col(IS_PREVENTABLE.name))
    });
pub const FAULT_VIOLATIONS: Metric =
    Metric::count("fault_violations", "number of these that count against the driver", || of(col(IS_FAULT.name)));
const SHARE: &str = "their share of *applied*";
pub const VIOLATION_RATE: Metric = Metric::share("violation_rate", &VIOLATIONS, &APPLIED, SHARE);
pub const PREVENTABLE_VIOLATION_RATE: Metric =
    Metric::share("preventable_rate", &PREVENTABLE_VIOLATIONS, &APPLIED, SHARE);
pub const FAULT_VIOLATION_RATE: Metric = Metric::share("fault_rate", &FAULT_VIOLATIONS, &APPLIED, SHARE);

/// Of the episodes that count.
fn of(rows: Expr) -> Expr {
    col(COUNTS.name).and(rows)
}
