use rand::RngExt;

use base::seed::Stream;

/// A failure that is correlated in time.
///
/// A number `u`, uniform in [0, 1), stays the same from one update to the next with probability `exp(−Δt/τ)` and is drawn anew
/// otherwise. A failure of rate `p` happens while `u < p`. At a constant rate this is a two-state Markov chain: its
/// stationary rate is exactly `p`, its autocorrelation after a time `t` is `exp(−t/τ)`, and a failure lasts
/// `Δt / ((1 − exp(−Δt/τ)) (1 − p))` on average, near `τ / (1 − p)`. The draws do not depend on `p`, so a sensor with a higher
/// rate fails whenever one with a lower rate does.
#[derive(Debug, Clone)]
pub struct Luck {
    u: f64,
    stream: Stream,
}

impl Luck {
    /// Starts in the stationary state.
    pub fn new(mut stream: Stream) -> Self {
        Self { u: stream.random(), stream }
    }

    /// Draws from another stream from now on.
    pub fn reseed(&mut self, stream: Stream) {
        self.stream = stream;
    }

    /// Advances to the next update; `keep` is the probability that nothing is drawn anew.
    pub fn advance(&mut self, keep: f64) {
        let (change, fresh): (f64, f64) = (self.stream.random(), self.stream.random());
        if change >= keep {
            self.u = fresh;
        }
    }

    /// Whether a failure of this rate happens now.
    pub fn fails(&self, rate: f64) -> bool {
        self.u < rate
    }
}

/// Standard normal errors that drift: stationary AR(1) processes with autocorrelation `exp(−t/τ)`.
#[derive(Debug, Clone)]
pub struct Drift {
    errors: [f64; Self::COUNT],
    stream: Stream,
}

impl Drift {
    /// The number of errors, independent of each other.
    pub const COUNT: usize = 6;

    /// Starts in the stationary state.
    pub fn new(stream: Stream) -> Self {
        let mut drift = Self { errors: [0.0; Self::COUNT], stream };
        drift.advance(0.0);
        drift
    }

    /// Draws from another stream from now on.
    pub fn reseed(&mut self, stream: Stream) {
        self.stream = stream;
    }

    /// Advances to the next update; `keep` is the correlation with the last one.
    pub fn advance(&mut self, keep: f64) {
        let fresh = (1.0 - keep * keep).sqrt();
        for pair in self.errors.chunks_exact_mut(2) {
            // Box and Muller's pair: a fixed number of draws, so that no setting shifts the stream.
            let (u, v): (f64, f64) = (self.stream.random(), self.stream.random());
            let radius = (-2.0 * libm::log(1.0 - u)).sqrt();
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * v);
            pair[0] = keep * pair[0] + fresh * radius * cos;
            pair[1] = keep * pair[1] + fresh * radius * sin;
        }
    }

    /// The present errors, each of mean 0 and variance 1.
    pub fn errors(&self) -> &[f64; Self::COUNT] {
        &self.errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::seed::Seed;

    /// Mean, and autocorrelation after `lag` steps, of a series about a known mean.
    fn moments(series: &[f64], mean: f64, lag: usize) -> (f64, f64) {
        let average = series.iter().sum::<f64>() / series.len() as f64;
        let product = |lag: usize| {
            let pairs = series.iter().zip(&series[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (series.len() - lag) as f64
        };
        (average, product(lag) / product(0))
    }

    #[test]
    fn misses_have_the_documented_rate_and_correlation() {
        let (count, dt, time) = (400_000, 0.05, 0.3);
        let keep = libm::exp(-dt / time);
        for rate in [0.02, 0.15, 0.5] {
            let mut luck = Luck::new(Seed::root(1).child("rate").stream());
            let series: Vec<f64> = (0..count)
                .map(|_| {
                    luck.advance(keep);
                    if luck.fails(rate) { 1.0 } else { 0.0 }
                })
                .collect();
            // A correlated series is worth n (1 − ρ) / (1 + ρ) independent draws.
            let worth = f64::from(count) * (1.0 - keep) / (1.0 + keep);
            let deviation = (rate * (1.0 - rate) / worth).sqrt();
            let (mean, _) = moments(&series, rate, 1);
            assert!((mean - rate).abs() < 3.0 * deviation, "{mean}, not {rate} ± {deviation}");
            for lag in [1, 6, 18] {
                let wanted = libm::pow(keep, lag as f64);
                let (_, got) = moments(&series, rate, lag);
                assert!((got - wanted).abs() < 0.03, "after {lag} steps of rate {rate}: {got}, not {wanted}");
            }
            let ends = series.windows(2).filter(|pair| pair[0] > pair[1]).count();
            let length = dt * series.iter().sum::<f64>() / ends as f64;
            let wanted = dt / ((1.0 - keep) * (1.0 - rate));
            assert!((length / wanted - 1.0).abs() < 0.05, "a miss lasts {length} s, not {wanted}");
        }
    }

    #[test]
    fn a_worse_sensor_misses_whatever_a_better_one_misses() {
        let mut luck = Luck::new(Seed::root(2).stream());
        for _ in 0..1000 {
            luck.advance(0.8);
            assert!(!luck.fails(0.1) || luck.fails(0.3));
            assert!(luck.fails(1.0) && !luck.fails(0.0));
        }
    }

    #[test]
    fn errors_are_standard_normal_and_drift() {
        let count = 200_000;
        for keep in [0.0, 0.85] {
            let mut drift = Drift::new(Seed::root(3).stream());
            let series: Vec<[f64; Drift::COUNT]> = (0..count)
                .map(|_| {
                    drift.advance(keep);
                    *drift.errors()
                })
                .collect();
            let worth = f64::from(count) * (1.0 - keep) / (1.0 + keep);
            for which in 0..Drift::COUNT {
                let one: Vec<f64> = series.iter().map(|errors| errors[which]).collect();
                let (mean, correlation) = moments(&one, 0.0, 1);
                let square = one.iter().map(|error| error * error).sum::<f64>() / f64::from(count);
                assert!(mean.abs() < 4.0 / worth.sqrt(), "mean {mean}");
                assert!((square - 1.0).abs() < 6.0 / worth.sqrt(), "variance {square}");
                assert!((correlation - keep).abs() < 0.02, "correlation {correlation}");
                let tails = one.iter().filter(|error| error.abs() > 1.96).count() as f64 / f64::from(count);
                assert!((tails - 0.05).abs() < 0.005, "tails {tails}");
            }
            let product = series.iter().map(|errors| errors[0] * errors[1]).sum::<f64>() / f64::from(count);
            assert!(product.abs() < 6.0 / worth.sqrt(), "the pair is independent: {product}");
        }
    }
}
