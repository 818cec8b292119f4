use super::{student_quantile_at, student_tails};

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

    /// The p-value of the hypothesis that the truth is at least `margin` (above 0) away from 0, on either side. If it is below 0.05, the
    /// 90 % interval of the estimate lies between −`margin` and `margin`.
    ///
    /// # Source
    /// Schuirmann, *A comparison of the two one-sided tests procedure and the power approach for assessing the equivalence of average
    /// bioavailability*, Journal of Pharmacokinetics and Biopharmaceutics 15, 1987.
    pub fn equivalence_p(&self, estimate: f64, margin: f64) -> f64 {
        let below = self.upper_tail((margin - estimate) / self.error);
        let above = self.upper_tail((margin + estimate) / self.error);
        below.max(above)
    }

    /// The probability that the two one-sided tests at 5 % show equivalence within `margin` when the truth is 0. Student's t stands for the
    /// noncentral one, so it is an approximation.
    ///
    /// # Source
    /// Phillips, *Power of the two one-sided tests procedure in bioequivalence*, Journal of Pharmacokinetics and Biopharmaceutics 18, 1990, with
    /// the shifted central distribution.
    pub fn equivalence_power(&self, margin: f64) -> f64 {
        let room = margin / self.error - student_quantile_at(self.degrees, 0.1);
        (1.0 - 2.0 * self.upper_tail(room)).max(0.0)
    }

    /// The share of Student's t above `t`.
    fn upper_tail(&self, t: f64) -> f64 {
        let half = student_tails(t, self.degrees) / 2.0;
        if t >= 0.0 { half } else { 1.0 - half }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_difference_is_scipys() {
        // scipy 1.17.1: stats.t.ppf(0.975, 2.391412) times the standard error, for 0.02 of 5 and 0.05 of 3.
        let of_mean = |sd, n| Uncertainty::of_mean(sd, n).unwrap();
        let (low, high) = of_mean(0.02, 5).of_difference(of_mean(0.05, 3)).interval(1.0);
        let half = 0.111_622_865_793;
        assert!((low - 1.0 + half).abs() < 1e-9 && (high - 1.0 - half).abs() < 1e-9, "{low}..{high}");
        assert_eq!(Uncertainty::of_mean(0.02, 1), None);
    }

    #[test]
    fn equivalence_is_two_one_sided_tests() {
        // The tails of Student's t with 7 degrees of freedom above 1.5 and 3.5 are 0.0886492 and 0.0049965 (Simpson's rule).
        let uncertainty = Uncertainty { error: 0.02, degrees: 7.0 };
        for estimate in [0.02, -0.02] {
            let p = uncertainty.equivalence_p(estimate, 0.05);
            assert!((p - 0.088_649_243).abs() < 1e-8, "{p}");
        }
        // Outside of the margin nothing is equivalent, and a larger margin shows more.
        assert!(uncertainty.equivalence_p(0.06, 0.05) > 0.5);
        assert!(uncertainty.equivalence_p(0.02, 0.1) < 0.01);
    }

    #[test]
    fn equivalence_has_power_where_the_error_is_far_below_the_margin() {
        let power = |error, degrees| Uncertainty { error, degrees }.equivalence_power(0.05);
        // With many degrees of freedom: 1 - 2 Φ(1.644854 - 0.05 / 0.01708) = 0.8, and nothing where the margin is below 1.645 errors.
        assert!((power(0.017_08, 1e6) - 0.8).abs() < 1e-3, "{}", power(0.017_08, 1e6));
        assert_eq!(power(0.0305, 1e6), 0.0);
        // With 4 degrees t is 2.131847 at 5 % and 1.533206 at 10 %.
        assert!((power(0.05 / (2.131_847 + 1.533_206), 4.0) - 0.8).abs() < 1e-6);
    }

    #[test]
    fn equivalence_at_5_percent_is_a_90_percent_interval_within_the_margin() {
        // 1.894579: the 95 % quantile of Student's t with 7 degrees of freedom.
        let uncertainty = Uncertainty { error: 0.02, degrees: 7.0 };
        let margin = 0.01 + 1.894_579 * 0.02;
        assert!((uncertainty.equivalence_p(0.01, margin) - 0.05).abs() < 1e-6);
    }
}
