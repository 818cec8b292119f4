use base::statistics::{bounded_interval, mean, mean_interval, sample_deviation};

/// A figure of several runs: its mean, how much the runs differ, and a 95 % interval.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rate {
    /// Mean over the runs that have a value; `None` if no run has one.
    pub value: Option<f64>,
    /// Sample standard deviation over these runs; `None` for a single one.
    pub sd: Option<f64>,
    /// The ends of the interval; `None` if the method has none for so few runs.
    pub interval: Option<(f64, f64)>,
    /// How the interval is made.
    pub method: Method,
    /// The value of each run that has one, in their order.
    pub by_run: Vec<f64>,
}

/// The method behind an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// No interval.
    #[default]
    None,
    /// Wilson's, over the starts, which all runs share.
    Wilson,
    /// Student's, about further runs; for four or more.
    Student,
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

    /// With an interval.
    pub fn within(self, interval: Option<(f64, f64)>, method: Method) -> Self {
        Self { interval, method, ..self }
    }

    /// A figure of at least 0 and at most `greatest`, with Student's interval over the runs that have a value.
    pub fn student(values: impl Iterator<Item = Option<f64>>, greatest: f64) -> Self {
        let by_run: Vec<f64> = values.flatten().collect();
        if by_run.is_empty() {
            return Self::default();
        }
        let (mean, interval) = mean_interval(&by_run);
        let interval = interval.map(|(low, high)| bounded_interval(mean, (high - low) / 2.0, (0.0, greatest)));
        Self { value: Some(mean), ..Self::of_runs(by_run) }.within(interval, Method::Student)
    }

    /// The band of a curve: one standard deviation over runs to either side, for a single run its interval; for a figure with Student's interval that, and
    /// the lowest and the highest of fewer than four runs.
    pub fn band(&self) -> Option<(f64, f64)> {
        let value = self.value?;
        if self.method == Method::Student {
            let runs = self.by_run.iter().copied();
            let ends = runs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), run| (low.min(run), high.max(run)));
            return Some(self.interval.unwrap_or(ends));
        }
        self.sd.map(|sd| ((value - sd).max(0.0), (value + sd).min(1.0))).or(self.interval)
    }
}

#[cfg(test)]
impl Rate {
    /// A single value.
    pub fn single(value: f64) -> Self {
        Self { value: Some(value), ..Self::default() }
    }
}
