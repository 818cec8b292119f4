/// The fewest runs whose mean has an interval. The spread of two or three says almost nothing about further ones: where counts are rare, an
/// interval over three runs misses the truth in up to 36 of 100 campaigns. Tables then have the single values.
pub const MIN_RUNS: usize = 4;

/// The mean of a few numbers with its 95 % interval, as if they were drawn from a normal distribution; fewer than [`MIN_RUNS`] have none.
///
/// # Source
/// Student, *The probable error of a mean*, Biometrika 6, 1908.
pub fn mean_interval(values: &[f64]) -> (f64, Option<(f64, f64)>) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, mean_interval_at(values, 0.05))
}

/// [`mean_interval`] where a share `alpha` of all intervals may miss the mean, instead of 0.05.
pub fn mean_interval_at(values: &[f64], alpha: f64) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < MIN_RUNS {
        return None;
    }
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
    let half = student_quantile_at(n - 1.0, alpha) * (variance / n).sqrt();
    Some((mean - half, mean + half))
}

/// The two-sided p-value of numbers whose mean is 0 in truth, such as paired differences; `None` for a single one, or if all are 0.
///
/// Numbers without any spread, such as two equal counts, say nothing about the spread of further ones. Then it is that of the sign test: the
/// probability that `n` signs are equal.
pub fn mean_p(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|each| (each - mean) * (each - mean)).sum();
    // Equal numbers may differ from their mean by its rounding.
    let greatest = values.iter().fold(0.0, |greatest: f64, each| greatest.max(each.abs()));
    let squares = if squares <= n * (ROUNDING * greatest) * (ROUNDING * greatest) { 0.0 } else { squares };
    if values.len() < 2 || (squares == 0.0 && mean == 0.0) {
        return None;
    }
    let error = (squares / (n - 1.0) / n).sqrt();
    Some(if error > 0.0 { student_tails(mean / error, n - 1.0) } else { libm::exp2(1.0 - n) })
}

/// The relative size of what rounding leaves of a difference of equal numbers.
const ROUNDING: f64 = 1e-12;

/// The share of Student's t that is farther from 0 than `t`, on both sides together: a two-sided p-value. The degrees of
/// freedom are above 0 and need not be whole.
pub fn student_tails(t: f64, degrees: f64) -> f64 {
    let x = degrees / (degrees + t * t);
    incomplete_beta(degrees / 2.0, 0.5, x).clamp(0.0, 1.0)
}

/// The value whose [`student_tails`] are `alpha`, above 0 and at most 0.4.
pub fn student_quantile_at(degrees: f64, alpha: f64) -> f64 {
    let (mut low, mut high) = (0.5, 2.0);
    while student_tails(high, degrees) > alpha {
        high *= 2.0;
    }
    // Each halving gives one bit: as many as a double has.
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if student_tails(middle, degrees) > alpha {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// The regularised incomplete beta function.
///
/// # Source
/// Its continued fraction (DLMF 8.17.22) by the method of Lentz.
pub(super) fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    // The fraction converges fast on one side of the mean, and the function is symmetric.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let whole = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let front = libm::exp(a * libm::log(x) + b * libm::log1p(-x) - whole) / a;
    let away = |value: f64| if value.abs() < 1e-300 { 1e-300 } else { value };
    let (mut c, mut d) = (1.0, 1.0 / away(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in 1..1_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = fraction;
        for step in [even, odd] {
            d = 1.0 / away(1.0 + step * d);
            c = away(1.0 + step / c);
            fraction *= c * d;
        }
        if (fraction - before).abs() <= 1e-16 * fraction.abs() {
            break;
        }
    }
    front * fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::recorded;

    #[test]
    fn the_test_of_a_mean_is_students() {
        let p = mean_p(&[1.0, 2.0, 0.5]).unwrap();
        // The mean is 7/6 and the variance 7/12. With 2 degrees of freedom Student's distribution has a closed form.
        let t = 7.0 / 6.0 / libm::sqrt(7.0 / 12.0 / 3.0);
        let closed = 1.0 - t / libm::sqrt(2.0 + t * t);
        assert!((p - closed).abs() < 1e-9, "{p} {closed}");
        assert_eq!(mean_p(&[0.0, 0.0, 0.0]), None);
        assert_eq!(mean_p(&[1.0]), None);
        assert_eq!(mean_p(&[1.0, 1.0]), Some(0.5), "two equal signs");
        assert_eq!(mean_p(&[2.0; 10]), Some(2.0 / 1_024.0));
        assert_eq!(mean_p(&[0.025; 3]), Some(0.25), "their mean is 0.025000000000000005");
    }

    #[test]
    fn the_interval_is_students() {
        // By hand: mean 2, variance 2 / 3, t = 3.182446.
        let (mean, interval) = mean_interval(&[1.0, 2.0, 2.0, 3.0]);
        let (low, high) = interval.unwrap();
        let half = 3.182_446_305_284 / 6_f64.sqrt();
        assert!((mean - 2.0).abs() < 1e-12 && (low - 2.0 + half).abs() < 1e-9 && (high - 2.0 - half).abs() < 1e-9);
        assert_eq!(mean_interval(&[4.0, 5.0, 6.0]), (5.0, None), "three are too few");
        let (wider, _) = mean_interval_at(&[1.0, 2.0, 2.0, 3.0], 0.01).unwrap();
        assert!((2.0 - wider - 5.840_909_309_733 / 6_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn tails_and_quantiles_are_those_of_scipy() {
        for case in recorded("student_tails") {
            let [t, degrees, tails] = case[..] else { panic!("{case:?}") };
            let found = student_tails(t, degrees);
            assert!((found - tails).abs() <= 1e-10 * tails, "{case:?}: {found}");
        }
        for case in recorded("student_quantile") {
            let [degrees, quantile] = case[..] else { panic!("{case:?}") };
            let found = student_quantile_at(degrees, 0.05);
            assert!((found - quantile).abs() < 1e-9 * quantile, "{case:?}: {found}");
        }
    }
}
