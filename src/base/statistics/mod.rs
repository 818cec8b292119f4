//! Intervals, tests and their corrections, as pure functions of numbers.
//!
//! `reports/README.md` explains their meaning for a campaign. Each is compared with the numbers of another program
//! (`tests/reference/statistics`).

mod normal;
mod wilson;
mod exact;
mod student;
mod uncertainty;
mod quantile;
mod mcnemar;
mod sign_flip;
mod adjust;
mod sample;
mod clustered;
mod moments;

pub use adjust::holm;
pub use clustered::ClusteredCount;
pub use exact::{clopper_pearson, disagreement, mean_disagreement};
pub use mcnemar::mcnemar;
pub use moments::{RunningMean, mean, sample_deviation};
pub use normal::{normal_below, normal_quantile};
pub use quantile::quantile;
pub use sample::Sample;
pub use sign_flip::sign_flip;
pub use student::{
    MIN_RUNS, MIN_TESTED, mean_interval, mean_interval_at, mean_p, mean_p_of_rates, student_quantile_at, student_tails,
};
pub use uncertainty::{Uncertainty, bounded_interval};
pub use wilson::{wilson, wilson_at};
