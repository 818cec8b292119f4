/// The mean of a few numbers with its 95 % interval, as if they were drawn from a normal distribution; a single number has none.
///
/// # Source
/// Student, *The probable error of a mean*, Biometrika 6, 1908; beyond 30 degrees of freedom the Cornish-Fisher expansion.
pub fn mean_interval(values: &[f64]) -> (f64, Option<(f64, f64)>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < 2 {
        return (mean, None);
    }
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
    let half = quantile(values.len() - 1) * (variance / n).sqrt();
    (mean, Some((mean - half, mean + half)))
}

/// The two-sided 95 % quantile of Student's t.
pub fn quantile(degrees: usize) -> f64 {
    const Z: f64 = 1.959_963_984_540_054;
    const SMALL: [f64; 30] = [
        12.706_205, 4.302_653, 3.182_446, 2.776_445, 2.570_582, 2.446_912, 2.364_624, 2.306_004, 2.262_157, 2.228_139,
        2.200_985, 2.178_813, 2.160_369, 2.144_787, 2.131_450, 2.119_905, 2.109_816, 2.100_922, 2.093_024, 2.085_963,
        2.079_614, 2.073_873, 2.068_658, 2.063_899, 2.059_539, 2.055_529, 2.051_831, 2.048_407, 2.045_230, 2.042_272,
    ];
    let nu = degrees as f64;
    let expansion = |z: f64| {
        let (cube, fifth) = (z * z * z, z * z * z * z * z);
        z + (cube + z) / (4.0 * nu) + (5.0 * fifth + 16.0 * cube + 3.0 * z) / (96.0 * nu * nu)
    };
    SMALL.get(degrees - 1).copied().unwrap_or_else(|| expansion(Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_students() {
        // By hand: mean 2, standard deviation 1, t = 4.302653.
        let (mean, interval) = mean_interval(&[1.0, 2.0, 3.0]);
        let (low, high) = interval.unwrap();
        let half = 4.302_653 / 3_f64.sqrt();
        assert!((mean - 2.0).abs() < 1e-12 && (low - 2.0 + half).abs() < 1e-9 && (high - 2.0 - half).abs() < 1e-9);
        assert_eq!(mean_interval(&[4.0]), (4.0, None));
        // scipy.stats.t.ppf(0.975, 31) and (…, 100).
        assert!((quantile(31) - 2.039_513).abs() < 1e-4 && (quantile(100) - 1.983_972).abs() < 1e-5);
    }
}
