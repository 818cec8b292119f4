use base::statistics::{mean, sample_deviation};

/// A figure of several runs: its mean, how much the runs differ, and a 95 % interval.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rate {
    /// Mean over the runs that have a value; `None` if no run has one.
    pub value: Option<f64>,
    /// Sample standard deviation over these runs; `None` for a single one.
    pub sd: Option<f64>,
    /// The ends of the interval; `None` if the method has none for so few runs.
    pub interval: Option<(f64, f64)>,
    /// The value of each run that has one, in their order.
    pub by_run: Vec<f64>,
}

impl Rate {
    /// The mean and the spread of runs, without an interval.
    pub fn of_runs(by_run: Vec<f64>) -> Self {
        Self {
            value: mean(by_run.iter().copied()),
            sd: sample_deviation(by_run.iter().copied()),
            by_run,
            ..Self::default()
        }
    }

    pub fn within(self, interval: Option<(f64, f64)>) -> Self {
        Self { interval, ..self }
    }
}

#[cfg(test)]
impl Rate {
    pub fn single(value: f64) -> Self {
        Self { value: Some(value), ..Self::default() }
    }
}
