use super::{student_quantile_at, student_tails};

/// An interval of this half width about an estimate that has bounds, without an impossible value: of a figure with a lower bound symmetric on the logarithm,
/// of a fraction on the logit (the delta method). About an estimate at a bound it is cut there.
pub fn bounded_interval(estimate: f64, half: f64, (least, greatest): (f64, f64)) -> (f64, f64) {
    let (above, below) = (estimate - least, greatest - estimate);
    if above <= 0.0 || below <= 0.0 || above.is_infinite() {
        return ((estimate - half).max(least), (estimate + half).min(greatest));
    }
    if below.is_infinite() {
        let factor = libm::exp(half / above);
        return (least + above / factor, least + above * factor);
    }
    let factor = libm::exp(half * (above + below) / (above * below));
    let at = |odds: f64| least + (above + below) * odds / (1.0 + odds);
    (at(above / below / factor), greatest - (greatest - least) / (1.0 + above / below * factor))
}

/// The uncertainty of an estimate: its standard error, and the degrees of freedom of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// The standard error, in the unit of the estimate.
    pub error: f64,
    /// The degrees of freedom of Student's t.
    pub degrees: f64,
}

impl Uncertainty {
    /// That of a mean of `n` independent values with this sample standard deviation; `None` for fewer than two.
    pub fn of_mean(sd: f64, n: u32) -> Option<Self> {
        (n > 1).then(|| Self { error: sd / f64::from(n).sqrt(), degrees: f64::from(n - 1) })
    }

    /// That of the difference of two independent estimates.
    ///
    /// # Source
    /// Welch, *The generalization of "Student's" problem when several different population variances are involved*, Biometrika 34,
    /// 1947.
    pub fn of_difference(self, other: Self) -> Self {
        let (a, b) = (self.error * self.error, other.error * other.error);
        let squares = a * a / self.degrees + b * b / other.degrees;
        let degrees = if squares > 0.0 { (a + b) * (a + b) / squares } else { self.degrees.min(other.degrees) };
        Self { error: (a + b).sqrt(), degrees }
    }

    /// The 95 % interval of an estimate: low and high end.
    pub fn interval(&self, estimate: f64) -> (f64, f64) {
        self.interval_at(estimate, 0.05)
    }

    /// [`interval`](Self::interval) where a share `alpha` of all intervals may miss the truth, instead of 0.05.
    pub fn interval_at(&self, estimate: f64, alpha: f64) -> (f64, f64) {
        let half = student_quantile_at(self.degrees, alpha) * self.error;
        (estimate - half, estimate + half)
    }

    /// The two-sided p-value of an estimate that is 0 in truth.
    pub fn p(&self, estimate: f64) -> f64 {
        student_tails(estimate / self.error, self.degrees)
    }
}
