//! Recordings of numpy, scipy and statsmodels.

/// The cases of a name that `tests/reference/statistics/record_statistics.py` has recorded, each a list of numbers.
pub fn recorded(name: &str) -> Vec<Vec<f64>> {
    const RECORDED: &str = include_str!("../reference/statistics/statistics.json");
    let recorded: serde_json::Value = serde_json::from_str(RECORDED).expect("it is JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let case = |case: &serde_json::Value| case.as_array().expect("a case is a list").iter().map(number).collect();
    recorded[name].as_array().expect("there are cases of this name").iter().map(case).collect()
}
