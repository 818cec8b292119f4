/// Half the width of the normal distribution's 95 % interval, in standard deviations.
const Z: f64 = 1.959_963_984_540_054;

/// The number of seen classes of failure, and an estimate of the number of all classes.
///
/// | symbol | field | meaning |
/// |---|---|---|
/// | S | `seen` | kinds seen |
/// | f₁, f₂ | `once`, `twice` | kinds seen once, twice |
/// | n | `failures` | failures |
///
/// The estimate is Chao's, bias-corrected: S + f₁ (f₁ − 1) / (2 (f₂ + 1)). It is a lower bound, since very rare kinds have no influence on
/// it. It applies to the same pedestrians, town and driver; another adversary may have other kinds.
///
/// # Source
/// Chao, *Estimating the population size for capture-recapture data with unequal catchability*, Biometrics 43, 1987; variance and
/// interval as in Colwell's EstimateS 9 and scikit-bio. Coverage: Good, Biometrika 40, 1953.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Richness {
    pub failures: u64,
    /// The number of kinds seen.
    pub seen: u64,
    /// The number of kinds seen once.
    pub once: u64,
    /// The number of kinds seen twice.
    pub twice: u64,
    /// The estimated number of kinds, seen or not.
    pub estimate: f64,
    /// Standard error of the estimate.
    pub standard_error: f64,
    /// 95 % interval of the estimate, from a log-normal distribution of the unseen.
    pub interval: (f64, f64),
    /// Good and Turing's estimate of the probability that the next failure is of a kind already seen: 1 − f₁ / n; 0 without
    /// failures.
    pub coverage: f64,
    /// Shannon's entropy of the kinds' shares (nat).
    pub entropy: f64,
}

impl Richness {
    /// Computes it from the number of failures of each kind.
    pub fn new(counts: &[u64]) -> Self {
        let counts: Vec<u64> = counts.iter().copied().filter(|count| *count > 0).collect();
        let times = |wanted| counts.iter().filter(|count| **count == wanted).count() as u64;
        let (failures, seen) = (counts.iter().sum::<u64>(), counts.len() as u64);
        let (once, twice) = (times(1), times(2));
        let (n, s, f1, f2) = (failures as f64, seen as f64, once as f64, twice as f64);
        let estimate = s + f1 * (f1 - 1.0) / (2.0 * (f2 + 1.0));
        let variance = variance(n, s, f1, f2, estimate);
        let share = |count: &u64| *count as f64 / n;
        Self {
            failures,
            seen,
            once,
            twice,
            estimate,
            standard_error: variance.sqrt(),
            interval: interval(n, s, estimate, variance),
            coverage: if failures > 0 { 1.0 - f1 / n } else { 0.0 },
            // A single kind's −1 ln 1 is −0.
            // Less than 0, not its negative: the sign of a zero that `max` returns depends on the optimiser.
            entropy: counts.iter().map(share).map(|p| 0.0 - p * libm::log(p)).sum::<f64>().max(0.0),
        }
    }

    /// The number of equally common kinds with the same diversity: e to the entropy.
    pub fn effective(&self) -> f64 {
        if self.seen > 0 { libm::exp(self.entropy) } else { 0.0 }
    }
}

fn variance(n: f64, s: f64, f1: f64, f2: f64, estimate: f64) -> f64 {
    let variance = if f1 > 0.0 && f2 > 0.0 {
        let pairs = f1 * (f1 - 1.0);
        let odd = 2.0 * f1 - 1.0;
        pairs / (2.0 * (f2 + 1.0))
            + f1 * odd * odd / (4.0 * (f2 + 1.0).powi(2))
            + f1 * f1 * f2 * (f1 - 1.0).powi(2) / (4.0 * (f2 + 1.0).powi(4))
    } else if f1 > 0.0 {
        f1 * (f1 - 1.0) / 2.0 + f1 * (2.0 * f1 - 1.0).powi(2) / 4.0 - f1.powi(4) / (4.0 * estimate)
    } else if s > 0.0 {
        let missed = libm::exp(-n / s);
        s * missed * (1.0 - missed)
    } else {
        0.0
    };
    variance.max(0.0)
}

fn interval(n: f64, s: f64, estimate: f64, variance: f64) -> (f64, f64) {
    let unseen = estimate - s;
    if s == 0.0 {
        return (0.0, 0.0);
    }
    if unseen > 0.0 {
        let factor = libm::exp(Z * libm::log1p(variance / (unseen * unseen)).sqrt());
        return (s + unseen / factor, s + unseen * factor);
    }
    let missed = libm::exp(-n / s);
    let (middle, half) = (s / (1.0 - missed), Z * (s * missed / (1.0 - missed)).sqrt());
    ((middle - half).max(s), middle + half)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{number, numbers, recorded};
    use super::*;

    #[test]
    fn estimates_are_those_of_scikit_bio() {
        let record = recorded();
        let cases = record["richness"].as_array().unwrap();
        assert_eq!(cases.len(), 6);
        for case in cases {
            let counts: Vec<u64> = numbers(&case["counts"]).iter().map(|count| *count as u64).collect();
            let found = Richness::new(&counts);
            for (name, value) in [
                ("chao1", found.estimate),
                ("low", found.interval.0),
                ("high", found.interval.1),
                ("coverage", found.coverage),
                ("entropy", found.entropy),
            ] {
                let wanted = number(&case[name]);
                // scikit-bio rounds the 97.5 % quantile to 1.96.
                assert!((value - wanted).abs() < 2e-4 * wanted.max(1.0), "{counts:?}: {name} {value}, not {wanted}");
            }
            assert!(found.effective() <= found.seen as f64 + 1e-9);
        }
    }

    #[test]
    fn nothing_is_known_of_nothing() {
        let none = Richness::new(&[0, 0]);
        assert_eq!((none.seen, none.estimate, none.interval, none.effective()), (0, 0.0, (0.0, 0.0), 0.0));
    }
}
