use crate::env::Pair;
use crate::geometry::Vector;
use crate::sim::PedestrianState;

/// Time (s) over which [`PedestrianMotion::velocity_change`] is taken.
const SECOND: f64 = 1.0;
/// Greatest excess of a bound by rounding (m/s and m/s²).
const ROUNDING: f64 = 1e-9;

/// What a pedestrian did with its body, over the whole velocity vector: a turn counts as much as a change of speed.
///
/// A wall that takes a part of the velocity counts too.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PedestrianMotion {
    /// Greatest speed (m/s).
    pub peak_speed: f64,
    /// Greatest change of velocity within a tick, divided by its length (m/s²).
    pub peak_acceleration: f64,
    /// Greatest difference of two velocities that are at most a second apart (m/s).
    pub velocity_change: f64,
}

impl PedestrianMotion {
    /// The bounds of a foreseeable pedestrian. Each is inclusive.
    ///
    /// | field | bound | source |
    /// |---|---|---|
    /// | `peak_speed` | 8 km/h | The running adult of Euro NCAP's test CPFA-50. Recorded walkers are slower than 2.28 to 2.7 m/s in 99.9 % of the time. |
    /// | `peak_acceleration` | 2.12 m/s² | 99.9th percentile of 1,068 pedestrians at a junction (VRU, 50 Hz), there over 0.5 s. Over a tick it is stricter. |
    /// | `velocity_change` | 1.65 m/s | CPFA-50: 8 km/h within 1.5 m is 1.65 m/s². Recorded walkers change their speed within a second by at most 0.88 to 1.3 m/s in 99.9 % of the time, and by 1.68 m/s at most. |
    ///
    /// # Source
    /// Euro NCAP, *AEB/LSS VRU test protocol* 4.5.1, 2024. VRU (Aschaffenburg), DUT and ETH/UCY: trajectories in OpenTraj and arXiv
    /// 1902.00487; the percentiles were computed from them.
    pub const FORESEEABLE: Self = Self { peak_speed: 8.0 / 3.6, peak_acceleration: 2.12, velocity_change: 1.65 };

    /// Measures the pedestrian of a pair, over the whole episode.
    pub fn new(pair: &Pair<'_>) -> Self {
        Self::of(pair.pedestrian_states(), pair.dt())
    }

    /// Measures states that are `dt` (s) apart. A part of an episode is a part of the slice.
    pub fn of(states: &[PedestrianState], dt: f64) -> Self {
        let stretches: Vec<Stretch> = stretches(states);
        let peak_speed = stretches.iter().map(|stretch| stretch.velocity.norm_squared()).fold(0.0, f64::max).sqrt();
        let tick = stretches.windows(2).map(|pair| pair[0].squared_change(&pair[1])).fold(0.0, f64::max).sqrt();
        let longest = (((SECOND + ROUNDING) / dt) as usize).max(1);
        Self { peak_speed, peak_acceleration: tick / dt, velocity_change: greatest_change(&stretches, longest).sqrt() }
    }

    /// Whether the pedestrian kept all [bounds](Self::FORESEEABLE) of a foreseeable one.
    pub fn is_foreseeable(&self) -> bool {
        let bounds = Self::FORESEEABLE;
        self.peak_speed <= bounds.peak_speed + ROUNDING
            && self.peak_acceleration <= bounds.peak_acceleration + ROUNDING
            && self.velocity_change <= bounds.velocity_change + ROUNDING
    }
}

/// Consecutive states with the same velocity.
struct Stretch {
    first: usize,
    last: usize,
    velocity: Vector,
}

impl Stretch {
    /// The square of the difference of two velocities.
    fn squared_change(&self, later: &Self) -> f64 {
        (later.velocity - self.velocity).norm_squared()
    }
}

fn stretches(states: &[PedestrianState]) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = Vec::new();
    for (tick, state) in states.iter().enumerate() {
        match all.last_mut() {
            Some(stretch) if stretch.velocity == state.velocity => stretch.last = tick,
            _ => all.push(Stretch { first: tick, last: tick, velocity: state.velocity }),
        }
    }
    all
}

/// The square of the greatest difference of two velocities that are at most this number of ticks apart.
fn greatest_change(stretches: &[Stretch], ticks: usize) -> f64 {
    let mut greatest = 0.0_f64;
    for (number, stretch) in stretches.iter().enumerate() {
        let near = stretches[number + 1..].iter().take_while(|later| later.first - stretch.last <= ticks);
        greatest = near.map(|later| stretch.squared_change(later)).fold(greatest, f64::max);
    }
    greatest
}
