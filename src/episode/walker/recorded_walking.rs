use rand::RngExt;

use base::seed::Stream;
use base::signature::Distribution;
use base::statistics::normal_below;

/// The walking of recorded pedestrians as a model of six numbers.
///
/// Speeds and changes are Student's t distributions with few degrees of freedom: their tails are those of the recordings, which normal
/// distributions of the same standard deviation miss (a normal one with 0.143 m/s has its 99.9th percentile of the size at 0.47 m/s, DUT has
/// 0.88 m/s, Student's with 4 degrees has 0.87 m/s).
///
/// | | mean | sd | 85th | 99th | 99.9th percentile |
/// |---|---|---|---|---|---|
/// | speed, DUT (m/s) | 1.314 | 0.267 | 1.565 | 1.99 | 2.64 |
/// | change of speed in 1 s, DUT (m/s) | | 0.143 | | 0.43 | 0.88 |
/// | change of heading in 1 s, DUT (rad) | | 0.138 | | 0.40 | 0.71 |
/// | change of speed in 1 s, VRU (m/s) | | 0.29 | | | 1.3 |
/// | change of heading in 1 s, VRU (rad) | | 0.27 | | 0.77 | 1.4 |
///
/// # Source
/// The figures were computed from trajectories. DUT: 1,190 pedestrians beside cars on a campus, 8,958 s (Yang et al., arXiv 1902.00487). VRU:
/// 1,068 pedestrians at an urban junction in Aschaffenburg, 50 Hz (in OpenTraj, Amirian et al., ACCV 2020). Accepted gaps: 235 crossings of
/// DUT in which the pedestrian was first, median 6.4 s, 1st percentile 2.2 s; their distribution is taken as lognormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedWalking {
    /// Mean (m/s) and standard deviation (m/s) of the speeds of pedestrians, and degrees of freedom.
    pub speed: (f64, f64, u32),
    /// Standard deviation of the change of speed within one second (m/s), and degrees of freedom.
    pub speed_change: (f64, u32),
    /// Standard deviation of the change of heading within one second (rad), and degrees of freedom.
    pub heading_change: (f64, u32),
}

/// Median of accepted gaps (s), and standard deviation of their logarithm.
const ACCEPTED_GAP: (f64, f64) = (6.4, 0.459);
/// The departure at which three of four changes lead back, as a share of the standard deviation of a change: with 0.1 the spread of speeds within a
/// walk leaves room for that between pedestrians.
const HALF_RETURN: f64 = 0.1;
/// The standard deviation of the departure that follows, as a share of that of a change.
const DEPARTURE: f64 = 1.07;
/// Slowest and fastest preferred speed (m/s): no recorded pedestrian walks faster than 3.48 m/s.
pub(super) const PREFERRED: (f64, f64) = (0.3, 3.48);

impl RecordedWalking {
    /// Pedestrians beside cars on a campus.
    pub const DUT: Self = Self { speed: (1.314, 0.267, 5), speed_change: (0.143, 4), heading_change: (0.138, 5) };
    /// Pedestrians at an urban junction, who turn and change their speed twice as much. Their mean speed is not recorded by pedestrian;
    /// that of DUT is taken.
    pub const VRU: Self = Self { speed_change: (0.29, 8), heading_change: (0.27, 5), ..Self::DUT };

    /// Draws a preferred speed (m/s).
    pub(super) fn speed(&self, stream: &mut Stream) -> f64 {
        (self.speed.0 + self.between() * student(self.speed.2, stream)).clamp(PREFERRED.0, PREFERRED.1)
    }

    /// Standard deviation of preferred speeds (m/s): the changes while walking make a part of the spread.
    fn between(&self) -> f64 {
        let within = DEPARTURE * self.speed_change.0;
        (self.speed.1 * self.speed.1 - within * within).max(0.0).sqrt()
    }

    /// Logarithm of the density of a preferred speed (m/s) over that of the likeliest one: 0 at most.
    pub(super) fn log_speed(&self, speed: f64) -> f64 {
        log_student(speed - self.speed.0, self.between(), self.speed.2)
    }

    /// Probability that a gap before a car (s) is accepted.
    pub(super) fn accepts(&self, gap: f64) -> f64 {
        if gap > 0.0 { normal_below(libm::log(gap / ACCEPTED_GAP.0) / ACCEPTED_GAP.1) } else { 0.0 }
    }

    /// Logarithm of the density of a change of speed (m/s) and of heading (rad) within a time (s), for departures from the preferred ones, over
    /// that of no change: 0 at most.
    pub(super) fn log_change(&self, changes: (f64, f64), departures: (f64, f64), seconds: f64) -> f64 {
        let log = |(deviation, degrees): (f64, u32), change: f64, departure: f64| {
            if change == 0.0 {
                return 0.0;
            }
            let back = leads_back(departure, deviation);
            let chance = if (change < 0.0) == (departure > 0.0) { back } else { 1.0 - back };
            libm::log(chance) + log_student(change, deviation * seconds.sqrt(), degrees)
        };
        log(self.speed_change, changes.0, departures.0) + log(self.heading_change, changes.1, departures.1)
    }

    /// Draws the gap before a car that a pedestrian accepts (s).
    pub(super) fn accepted_gap(&self, stream: &mut Stream) -> f64 {
        ACCEPTED_GAP.0 * libm::exp(ACCEPTED_GAP.1 * normal(stream))
    }

    /// Draws a change of speed (m/s) and of heading (rad) within a time (s), for departures from the preferred ones.
    ///
    /// Sizes grow with the square root of the time. The sign leads back with probability 1/2 + |x| / (2 (|x| + s / 10)), where x is the
    /// departure and s the standard deviation of the change. It does not alter the distribution of the sizes.
    pub(super) fn change(&self, faster: f64, turned: f64, seconds: f64, stream: &mut Stream) -> (f64, f64) {
        let mut draw = |(deviation, degrees): (f64, u32), departure: f64| {
            let size = (deviation * student(degrees, stream)).abs() * seconds.sqrt();
            let is_back = stream.random::<f64>() < leads_back(departure, deviation);
            if is_back == (departure > 0.0) { -size } else { size }
        };
        (draw(self.speed_change, faster), draw(self.heading_change, turned))
    }
}

/// Probability that a change with this standard deviation leads back from a departure.
fn leads_back(departure: f64, deviation: f64) -> f64 {
    0.5 + 0.5 * departure.abs() / (departure.abs() + HALF_RETURN * deviation)
}

/// Logarithm of the density of Student's t distribution, scaled to a standard deviation, over that at 0.
fn log_student(value: f64, deviation: f64, degrees: u32) -> f64 {
    let degrees = f64::from(degrees);
    let scaled = value / deviation;
    -(degrees + 1.0) / 2.0 * libm::log1p(scaled * scaled / (degrees - 2.0))
}

/// A draw from the normal distribution with mean 0 and standard deviation 1.
fn normal(stream: &mut Stream) -> f64 {
    let normal = Distribution::Normal { mean: 0.0, deviation: 1.0, low: f64::NEG_INFINITY, high: f64::INFINITY };
    normal.quantile(stream.random())
}

/// A draw from Student's t distribution with more than two degrees of freedom, scaled to a standard deviation of 1.
fn student(degrees: u32, stream: &mut Stream) -> f64 {
    let z = normal(stream);
    let squares: f64 = (0..degrees).map(|_| normal(stream)).map(|each| each * each).sum();
    let degrees = f64::from(degrees);
    z * ((degrees - 2.0) / squares).sqrt()
}
