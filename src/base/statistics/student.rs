/// The fewest runs whose mean has an interval. The spread of two or three says almost nothing about further ones: where counts are rare, an
/// interval over three runs misses the truth in up to 36 of 100 campaigns. Tables then have the single values.
pub const MIN_RUNS: usize = 4;

/// The fewest runs whose mean has a p-value: with two, whose spread may be small by chance, p is below 0.001 several times too often.
pub const MIN_TESTED: usize = 3;

/// The mean of a few numbers with its 95 % interval, as if they were drawn from a normal distribution. Fewer than [`MIN_RUNS`] have none; nor have equal
/// numbers, which say nothing about the spread of further ones.
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
    let squares = squares(values, mean);
    if values.len() < MIN_RUNS || squares == 0.0 {
        return None;
    }
    let half = student_quantile_at(n - 1.0, alpha) * (squares / (n - 1.0) / n).sqrt();
    Some((mean - half, mean + half))
}

/// The two-sided p-value of numbers whose mean is 0 in truth, such as paired differences; `None` for fewer than [`MIN_TESTED`], or if all are 0.
///
/// Numbers without any spread, such as two equal counts, say nothing about the spread of further ones. Then it is that of the sign test: the
/// probability that `n` signs are equal.
pub fn mean_p(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = squares(values, mean);
    if values.len() < MIN_TESTED || (squares == 0.0 && mean == 0.0) {
        return None;
    }
    let error = (squares / (n - 1.0) / n).sqrt();
    Some(if error > 0.0 { student_tails(mean / error, n - 1.0) } else { libm::exp2(1.0 - n) })
}

/// The same of differences of rates over seeds, from [`MIN_RUNS`] on, with a standard error that is at least what their counts allow: `variances` are those of the
/// differences by their counts. A few differences may agree by chance.
pub fn mean_p_of_rates(values: &[f64], variances: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let counted = variances.iter().sum::<f64>() / (n * n);
    let seen = squares(values, mean) / (n - 1.0) / n;
    let error = seen.max(counted).sqrt();
    (values.len() >= MIN_RUNS && error > 0.0).then(|| student_tails(mean / error, n - 1.0))
}

/// The sum of the squared distances from the mean. Equal numbers may differ from it by its rounding, and have 0.
fn squares(values: &[f64], mean: f64) -> f64 {
    let squares: f64 = values.iter().map(|each| (each - mean) * (each - mean)).sum();
    let greatest = values.iter().fold(0.0, |greatest: f64, each| greatest.max(each.abs()));
    let rounded = values.len() as f64 * (ROUNDING * greatest) * (ROUNDING * greatest);
    if squares <= rounded { 0.0 } else { squares }
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
