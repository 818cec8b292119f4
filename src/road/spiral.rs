//! Euler spirals, whose curvature changes evenly, and the quadrature that they and the lengths of cubics need.

use crate::geometry::Vector;

/// Nodes and weights of Gauss-Legendre quadrature with eight points; the other half is symmetric.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// How much the heading may turn within one panel of the quadrature (rad).
const TURN_PER_PANEL: f64 = 1.0;

/// Greatest number of panels, a guard against files with absurd curvatures.
const MAX_PANELS: f64 = 256.0;

/// The displacement after a distance along a spiral that starts at the origin along `+x`, and how far its heading has turned.
///
/// `curvature` is that at the start (1/m), `rate` its change (1/m²). Both coordinates are Fresnel integrals; eight
/// nodes per radian of turn give them to 1e-12 m per metre.
pub(super) fn spiral(curvature: f64, rate: f64, distance: f64) -> (Vector, f64) {
    let heading = |s: f64| s * (curvature + 0.5 * rate * s);
    let steepest = curvature.abs().max((curvature + rate * distance).abs());
    let panels = (steepest * distance.abs() / TURN_PER_PANEL).ceil().clamp(1.0, MAX_PANELS);
    let half = 0.5 * distance / panels;
    let mut end = Vector::zeros();
    let mut panel = 0.0;
    while panel < panels {
        let middle = (2.0 * panel + 1.0) * half;
        for (node, weight) in GAUSS {
            let (sin_a, cos_a) = libm::sincos(heading(middle - node * half));
            let (sin_b, cos_b) = libm::sincos(heading(middle + node * half));
            end += Vector::new(cos_a + cos_b, sin_a + sin_b) * (weight * half);
        }
        panel += 1.0;
    }
    (end, heading(distance))
}

/// The integral of a function from 0 to `end`, by eight nodes in each of two halves.
pub(super) fn integral(end: f64, function: impl Fn(f64) -> f64) -> f64 {
    let half = 0.25 * end;
    let part = |middle: f64| {
        GAUSS
            .iter()
            .map(|(node, weight)| weight * half * (function(middle - node * half) + function(middle + node * half)))
            .sum::<f64>()
    };
    part(half) + part(3.0 * half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_many_small_steps() {
        for (curvature, rate, length) in [(0.0, 0.001, 60.0), (-0.05, 0.002, 40.0), (0.2, -0.01, 30.0)] {
            let steps = 400_000;
            let h = length / f64::from(steps);
            let mut sum = Vector::zeros();
            for i in 0..steps {
                let s = (f64::from(i) + 0.5) * h;
                let turn = s * (curvature + 0.5 * rate * s);
                sum += Vector::new(libm::cos(turn), libm::sin(turn)) * h;
            }
            let (end, turn) = spiral(curvature, rate, length);
            assert!((end - sum).norm() < 1e-8, "{end} {sum}");
            assert!((turn - length * (curvature + 0.5 * rate * length)).abs() < 1e-12);
        }
    }

    #[test]
    fn without_change_it_is_an_arc() {
        let (end, turn) = spiral(0.1, 0.0, 5.0);
        assert!((end - Vector::new(libm::sin(0.5_f64) / 0.1, (1.0 - libm::cos(0.5_f64)) / 0.1)).norm() < 1e-12);
        assert!((turn - 0.5).abs() < 1e-15);
    }

    #[test]
    fn integrals_of_polynomials_are_exact() {
        assert!((integral(3.0, |x| x.powi(7)) - 3.0_f64.powi(8) / 8.0).abs() < 1e-9);
        assert!((integral(1.0, |x| 1.0 / (1.0 + x * x)) - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    }
}
