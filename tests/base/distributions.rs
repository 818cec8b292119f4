//! The distributions of a scenario: quantiles, masses and densities agree, and conditioning is that of probabilities.

use base::signature::Distribution;
use proptest::prelude::*;

fn any_distribution() -> impl Strategy<Value = Distribution> {
    let plain = prop_oneof![
        (-9.0..9.0).prop_map(Distribution::Constant),
        (-9.0..9.0, 0.0..5.0).prop_map(|(low, width)| Distribution::Uniform(low, low + width)),
        (-9.0..9.0, 0.1..3.0, -9.0..0.0, 0.1..9.0).prop_map(|(mean, deviation, low, high)| {
            Distribution::Normal { mean, deviation, low: mean + low, high: mean + high }
        }),
    ];
    plain
        .prop_recursive(2, 8, 3, |inner| prop::collection::vec((0.1..3.0, inner), 1..4).prop_map(Distribution::mixture))
}

/// Removes the value at a quantile from a distribution and compares the masses.
fn take_out(d: &Distribution, at: f64) -> Result<(), TestCaseError> {
    let value = d.quantile(at);
    let left = 1.0 - d.mass(value, value);
    prop_assume!(!(1e-9..1e-3).contains(&left));
    match d.without(value) {
        None => prop_assert!(left < 1e-9),
        Some(kept) => {
            prop_assert!(kept.mass(value, value) < 1e-9);
            let below = d.mass(-100.0, value) - d.mass(value, value);
            prop_assert!((kept.mass(-100.0, value) - below / left).abs() < 1e-9);
        }
    }
    Ok(())
}

/// A mixture for which `single_values_can_be_taken_out` once failed.
#[test]
fn a_value_can_be_taken_out_of_a_nested_mixture() {
    let inner = Distribution::mixture(vec![
        (0.5, Distribution::Constant(8.427_877_529_368_645)),
        (0.5, Distribution::Constant(0.0)),
    ]);
    let outer = Distribution::mixture(vec![
        (0.450_444_432_642_284_84, inner),
        (0.549_555_567_357_715_2, Distribution::Constant(-0.385_707_721_736_751_3)),
    ]);
    take_out(&outer, 0.288_139_346_871_761_4).unwrap();
}

proptest! {
    #[test]
    fn quantiles_lie_in_the_support_and_masses_agree_with_them(
        d in any_distribution(), low in -12.0..12.0, width in 0.0..9.0
    ) {
        let (a, b) = d.support();
        let high = low + width;
        let steps = 4000;
        let values: Vec<f64> = (0..steps).map(|i| d.quantile((f64::from(i) + 0.5) / f64::from(steps))).collect();
        prop_assert!(values.iter().all(|value| a - 1e-9 <= *value && *value <= b + 1e-9));
        let inside = values.iter().filter(|value| low <= **value && **value <= high).count() as f64 / f64::from(steps);
        prop_assert!((inside - d.mass(low, high)).abs() < 0.01, "{inside} {}", d.mass(low, high));
    }

    #[test]
    fn the_density_is_the_mass_of_a_small_interval_over_its_length(d in any_distribution(), at in -12.0..12.0, u in 0.0..1.0) {
        let half = 1e-4;
        for value in [at, d.quantile(u)] {
            let edges = d.pieces().into_iter().flat_map(|(low, high)| [low, high]);
            if edges.into_iter().any(|edge| (edge - value).abs() <= half) {
                continue;
            }
            let (mass, density) = (d.mass(value - half, value + half), d.density(value));
            prop_assert!((mass - 2.0 * half * density).abs() < 1e-9 + 1e-5 * mass, "{mass} {density} at {value}");
            let (low, high) = d.support();
            prop_assert!(density == 0.0 || (low..=high).contains(&value));
        }
    }

    #[test]
    fn along_the_quantiles_the_density_is_their_slope(mean in -9.0..9.0, deviation in 0.1..3.0, low in -3.0..1.0, width in 0.1..3.0, u in 0.01..0.99) {
        let (low, step) = (mean + low * deviation, 1e-5);
        let normal = Distribution::Normal { mean, deviation, low, high: low + width * deviation };
        for d in [Distribution::Uniform(mean, mean + width), normal] {
            let slope = (d.quantile(u + step) - d.quantile(u - step)) / (2.0 * step);
            prop_assert!((slope * d.density(d.quantile(u)) - 1.0).abs() < 1e-3, "{d:?} at {u}");
        }
    }

    #[test]
    fn truncation_is_conditioning(d in any_distribution(), low in -9.0..6.0, width in 0.5..9.0, cut in 0.0..1.0) {
        let high = low + width;
        prop_assume!(d.mass(low, high) > 1e-6);
        let kept = d.truncated(low, high).unwrap();
        let middle = low + cut * width;
        prop_assert!((kept.mass(low, middle) - d.mass(low, middle) / d.mass(low, high)).abs() < 1e-9);
        prop_assert!((kept.mass(low, high) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn single_values_can_be_taken_out(d in any_distribution(), at in 0.0..1.0) {
        take_out(&d, at)?;
    }

    #[test]
    fn what_has_no_mass_cannot_be_kept(d in any_distribution()) {
        let (a, b) = d.support();
        prop_assert_eq!(d.truncated(b + 1.0, b + 2.0), None);
        prop_assert_eq!(d.truncated(a - 2.0, a - 1.0), None);
    }
}
