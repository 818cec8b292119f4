use super::recording_noise::VELOCITY_NOISE;
use episode::Pair;
use road::geometry::Vector;
use world::sim::PedestrianState;

/// Time (s) over which a velocity is averaged, and over which [`PedestrianMotion::peak_acceleration`] is taken.
const HALF_SECOND: f64 = 0.5;
/// Time (s) over which [`PedestrianMotion::velocity_change`] is taken.
const SECOND: f64 = 1.0;
/// The last part of an episode (s) that is looked at: what a driver can know of a pedestrian before it must brake.
const LOOKED_AT: f64 = 3.0;
/// The greatest acceleration of a foreseeable runner or cyclist, over half a second (m/s²).
const FAST_ACCELERATION: f64 = 1.0;
/// Greatest excess of a bound by rounding (m/s and m/s²).
const ROUNDING: f64 = 1e-6;
/// Greatest excess of a velocity by noise, in standard deviations, and by what noise is left in a recording (m/s).
const OF_NOISE: f64 = 4.0;
const MAX_EXCESS: f64 = 2.0 * VELOCITY_NOISE;
/// Velocities of recordings may be rounded to three decimals (m/s).
const DECIMALS: f64 = 5e-4;

/// What a pedestrian did with its body in the last three seconds of an episode, over the whole velocity vector: a turn counts as much as a change
/// of speed.
///
/// All velocities are means over half a second, so that the noise of a recording is not motion. Before the first state the pedestrian had the
/// velocity of that state. A wall that takes a part of the velocity counts too.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PedestrianMotion {
    /// Greatest speed (m/s).
    pub peak_speed: f64,
    /// Greatest difference of two velocities that are half a second apart, divided by that time (m/s²).
    pub peak_acceleration: f64,
    /// Greatest difference of two velocities that are at most a second apart (m/s).
    pub velocity_change: f64,
    /// Greatest difference of a velocity and the mean of all (m/s).
    pub unsteadiness: f64,
    /// What velocities may exceed a bound by (m/s): in a recording from elsewhere the noise that is left, so that none turns a pedestrian at a bound into one
    /// beyond it.
    pub excess: f64,
}

impl PedestrianMotion {
    /// The bounds of a foreseeable pedestrian. Each is inclusive.
    ///
    /// | field | bound | source |
    /// |---|---|---|
    /// | `peak_speed` | 8 km/h; above it, another acceleration | The running adult of Euro NCAP's test CPFA-50. Recorded walkers are slower than 2.28 to 2.7 m/s in 99.9 % of the time. |
    /// | `peak_acceleration` | 2.12 m/s² | 99.9th percentile of 1,068 pedestrians at a junction (VRU, 50 Hz), over 0.5 s as here. |
    /// | `peak_acceleration` above 8 km/h | 1 m/s² | Our choice: a jogger who slows down, or a cyclist in a bend, can be foreseen; one who swerves cannot. |
    /// | `velocity_change` | 1.65 m/s | CPFA-50: 8 km/h within 1.5 m is 1.65 m/s². Recorded walkers change their speed within a second by at most 0.88 to 1.3 m/s in 99.9 % of the time, and by 1.68 m/s at most. |
    /// | `unsteadiness` | 0.3 m/s makes a pedestrian steady | Our choice: below the changes of pace above, above the noise of recorded positions (3 cm at 20 Hz). |
    ///
    /// # Source
    /// Euro NCAP, *AEB/LSS VRU test protocol* 4.5.1, 2024. VRU (Aschaffenburg), DUT and ETH/UCY: trajectories in OpenTraj and arXiv
    /// 1902.00487; the percentiles were computed from them.
    pub const FORESEEABLE: Self =
        Self { peak_speed: 8.0 / 3.6, peak_acceleration: 2.12, velocity_change: 1.65, unsteadiness: 0.3, excess: 0.0 };

    /// Measures the pedestrian of a pair at the end of the episode.
    pub fn new(pair: &Pair<'_>) -> Self {
        let excess = match pair.is_on_map() {
            true => 0.0,
            false => (OF_NOISE * pair.velocity_noise()).clamp(DECIMALS, MAX_EXCESS),
        };
        Self { excess, ..Self::of(pair.walking, pair.dt()) }
    }

    /// Measures states that are `dt` (s) apart, at their end. A part of an episode is a part of the slice.
    pub fn of(states: &[PedestrianState], dt: f64) -> Self {
        let ticks = |time: f64| (((time + ROUNDING) / dt) as usize).max(1);
        let (half, second) = (ticks(HALF_SECOND), ticks(SECOND));
        let Some(before) = states.len().checked_sub(1).map(|last| last.saturating_sub(ticks(LOOKED_AT))) else {
            return Self::default();
        };
        // The velocity at a place is the mean of the last half second. In front of the states is what the pedestrian did before.
        let earlier = std::iter::repeat_n(&states[before], if before == 0 { half } else { 0 });
        let velocities: Vec<Vector> = earlier.chain(&states[before..]).map(|state| state.velocity).collect();
        let means: Vec<Vector> = match velocities.len() > half {
            true => velocities.windows(half).map(|near| near.iter().sum::<Vector>() / half as f64).collect(),
            false => vec![velocities.iter().sum::<Vector>() / velocities.len() as f64],
        };
        let mean = means.iter().sum::<Vector>() / means.len() as f64;
        let greatest = |squares: &mut dyn Iterator<Item = f64>| squares.fold(0.0, f64::max).sqrt();
        let apart = |ticks: usize| means.iter().zip(means.iter().skip(ticks)).map(|(a, b)| (b - a).norm_squared());
        Self {
            peak_speed: greatest(&mut means.iter().map(Vector::norm_squared)),
            peak_acceleration: greatest(&mut apart(half)) / (half as f64 * dt),
            velocity_change: greatest(&mut (1..=second).flat_map(apart)),
            unsteadiness: greatest(&mut means.iter().map(|velocity| (velocity - mean).norm_squared())),
            excess: 0.0,
        }
    }

    /// Whether the pedestrian kept all [bounds](Self::FORESEEABLE) of a foreseeable one.
    pub fn is_foreseeable(&self) -> bool {
        let bounds = Self::FORESEEABLE;
        let acceleration = if self.is_fast() { FAST_ACCELERATION } else { bounds.peak_acceleration };
        self.peak_acceleration <= acceleration + ROUNDING + self.excess / HALF_SECOND
            && self.velocity_change <= bounds.velocity_change + ROUNDING + self.excess
    }

    /// Whether it was faster than a pedestrian of 8 km/h, as runners and cyclists are.
    pub fn is_fast(&self) -> bool {
        self.peak_speed > Self::FORESEEABLE.peak_speed + ROUNDING + self.excess
    }

    /// Whether it kept its velocity.
    pub fn is_steady(&self) -> bool {
        self.unsteadiness <= Self::FORESEEABLE.unsteadiness
    }
}
