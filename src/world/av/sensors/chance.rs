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
