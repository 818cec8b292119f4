//! Standard normal numbers.

use rand::Rng;

use base::seed::Stream;

/// Draws a number from the standard normal distribution.
///
/// Takes exactly two 64-bit words from the stream, so the position in the stream gives the number of draws.
///
/// # Source
/// Box and Muller (1958), the cosine half.
pub fn standard_normal(stream: &mut Stream) -> f64 {
    const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
    // From (0, 1], so that the logarithm is finite.
    let radius = ((stream.next_u64() >> 11) + 1) as f64 * UNIT;
    let turn = (stream.next_u64() >> 11) as f64 * UNIT;
    (-2.0 * libm::log(radius)).sqrt() * libm::cos(std::f64::consts::TAU * turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    #[test]
    fn the_moments_are_those_of_the_standard_normal() {
        let mut stream = Seed::root(1).stream();
        let draws: Vec<f64> = (0..200_000).map(|_| standard_normal(&mut stream)).collect();
        let moment = |power: i32| draws.iter().map(|x| x.powi(power)).sum::<f64>() / draws.len() as f64;
        assert!(moment(1).abs() < 0.01);
        assert!((moment(2) - 1.0).abs() < 0.02);
        assert!(moment(3).abs() < 0.05);
        assert!((moment(4) - 3.0).abs() < 0.1);
    }
}
