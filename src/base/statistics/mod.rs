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
mod adjust;
mod sample;
mod clustered;
mod moments;

pub use adjust::holm;
pub use clustered::ClusteredCount;
pub use exact::{clopper_pearson, disagreement};
pub use mcnemar::mcnemar;
pub use moments::{RunningMean, mean, sample_deviation};
pub use normal::{normal_below, normal_quantile};
pub use quantile::quantile;
pub use sample::Sample;
pub use student::{MIN_RUNS, mean_interval, mean_interval_at, mean_p, student_quantile_at, student_tails};
pub use uncertainty::Uncertainty;
pub use wilson::wilson;

/// The cases of a name that `tests/reference/statistics/record_statistics.py` has recorded, each a list of numbers.
#[cfg(test)]
fn recorded(name: &str) -> Vec<Vec<f64>> {
    const RECORDED: &str = include_str!("../../../tests/reference/statistics/statistics.json");
    let recorded: serde_json::Value = serde_json::from_str(RECORDED).expect("it is JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let case = |case: &serde_json::Value| case.as_array().expect("a case is a list").iter().map(number).collect();
    recorded[name].as_array().expect("there are cases of this name").iter().map(case).collect()
}
