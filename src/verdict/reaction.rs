//! The reaction times of drivers, as a distribution.

use base::statistics::normal_below;

/// The longest reaction time that is considered (s). Of all drivers 0.1 % are slower.
pub const MAX_REACTION: f64 = 5.0;

/// Mean and standard deviation of the reaction time (s).
const MEAN: f64 = 1.21;
const SD: f64 = 0.63;

/// The share of drivers who brake within this time (s) after they could notice a danger that they did not expect.
///
/// The reaction time ends when the brake is applied. It is lognormal with a mean of 1.21 s and a standard deviation of 0.63 s: the median is
/// 1.07 s, and 5 % need more than 2.4 s. The careful human (1.15 s) is faster than 44 % of these drivers, its attentive reading
/// (0.75 s) faster than 77 %.
///
/// # Source
/// Taoka, *Brake reaction times of unalerted drivers*, ITE Journal 59(3), 1989, who fits the observations in traffic of Sivak, Post, Olson and
/// Donohue (1982) so. Green, *How long does it take to stop?*, Transportation Human Factors 2 (2000) 195–216, finds 0.7 to 0.75 s for drivers who
/// expect the signal, 1.25 s for unexpected but common ones, and 1.5 s for an object that moves into the path by surprise.
pub fn share_of_drivers(reaction: f64) -> f64 {
    if reaction <= 0.0 {
        return 0.0;
    }
    let variance = libm::log1p((SD / MEAN) * (SD / MEAN));
    normal_below((libm::log(reaction) - (libm::log(MEAN) - variance / 2.0)) / variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_has_its_published_mean_and_deviation() {
        // Moments from a fine sum over its quantiles.
        let step = 1e-3;
        let (mut mean, mut square) = (0.0, 0.0);
        for i in 0..60_000 {
            let (from, to) = (f64::from(i) * step, f64::from(i + 1) * step);
            let (share, time) = (share_of_drivers(to) - share_of_drivers(from), (from + to) / 2.0);
            mean += share * time;
            square += share * time * time;
        }
        assert!((mean - MEAN).abs() < 1e-3 && ((square - mean * mean).sqrt() - SD).abs() < 2e-3, "{mean} {square}");
    }

    #[test]
    fn the_text_states_its_quantiles() {
        for (time, share) in [(1.07, 0.50), (2.40, 0.95), (1.15, 0.56), (0.75, 0.23), (MAX_REACTION, 0.999)] {
            assert!((share_of_drivers(time) - share).abs() < 5e-3, "{time} s: {}", share_of_drivers(time));
        }
        assert_eq!(share_of_drivers(0.0), 0.0);
    }
}
