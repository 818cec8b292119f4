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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Obstacles;
    use crate::sim::{Gait, PedestrianBody, WalkCommand};
    use proptest::prelude::*;

    fn states(velocities: &[(f64, f64)]) -> Vec<PedestrianState> {
        let state = |(x, y): &(f64, f64)| PedestrianState { velocity: Vector::new(*x, *y), ..Default::default() };
        velocities.iter().map(state).collect()
    }

    #[test]
    fn turning_counts_as_much_as_speeding_up() {
        // A quarter turn at 1.4 m/s in one tick of 50 ms.
        let motion = PedestrianMotion::of(&states(&[(1.4, 0.0), (1.4, 0.0), (0.0, 1.4)]), 0.05);
        assert_eq!(motion.peak_speed, 1.4);
        assert!((motion.peak_acceleration - 1.4 * 2.0_f64.sqrt() / 0.05).abs() < 1e-9);
        assert!((motion.velocity_change - 1.4 * 2.0_f64.sqrt()).abs() < 1e-12);
        assert!(!motion.is_foreseeable());
        let still = PedestrianMotion::of(&states(&[(0.0, 0.0)]), 0.05);
        assert!(still == PedestrianMotion::default() && still.is_foreseeable());
        assert_eq!(PedestrianMotion::of(&[], 0.05), PedestrianMotion::default());
    }

    #[test]
    fn each_bound_alone_decides() {
        let kept = PedestrianMotion::FORESEEABLE;
        assert!(kept.is_foreseeable());
        for motion in [
            PedestrianMotion { peak_speed: 2.23, ..kept },
            PedestrianMotion { peak_acceleration: 2.13, ..kept },
            PedestrianMotion { velocity_change: 1.66, ..kept },
        ] {
            assert!(!motion.is_foreseeable(), "{motion:?}");
        }
    }

    #[test]
    fn a_detour_within_a_second_is_found_where_its_ends_are_equal() {
        // 0.8 m/s forwards within half a second and back: after a second the velocity is the same.
        let there_and_back: Vec<(f64, f64)> =
            (0..=10).map(|tick| (f64::from(5 - i32::abs(tick - 5)) * 0.16, 0.0)).collect();
        let motion = PedestrianMotion::of(&states(&there_and_back), 0.1);
        assert!((motion.velocity_change - 0.8).abs() < 1e-12, "{motion:?}");
        // Ticks longer than a second: only neighbours are compared.
        let slow = PedestrianMotion::of(&states(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), 1.5);
        assert_eq!(slow.velocity_change, 1.0);
    }

    /// By comparing every pair of states.
    fn by_pairs(states: &[PedestrianState], longest: usize) -> f64 {
        let near = |(i, a): (usize, &PedestrianState)| {
            let later = states[i..].iter().take(longest + 1);
            later.map(|b| (b.velocity - a.velocity).norm()).fold(0.0, f64::max)
        };
        states.iter().enumerate().map(near).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn stretches_give_what_a_comparison_of_all_states_gives(
            steps in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, any::<bool>()), 0..80),
        ) {
            let mut velocity = (0.0, 0.0);
            let walked: Vec<(f64, f64)> = steps.iter().map(|(x, y, turns)| {
                velocity = if *turns { (*x, *y) } else { velocity };
                velocity
            }).collect();
            let states = states(&walked);
            let motion = PedestrianMotion::of(&states, 0.05);
            prop_assert!((motion.velocity_change - by_pairs(&states, 20)).abs() < 1e-12);
        }

        #[test]
        fn the_plausible_pedestrian_is_foreseeable_in_free_space_whatever_it_is_commanded(
            commands in prop::collection::vec((-3.2..3.2_f64, 0.0..=8.0 / 3.6, 1_u32..25), 1..60),
            dt in prop::sample::select(vec![0.01, 0.05, 0.1, 0.25]),
            reverses in any::<bool>(),
        ) {
            // `plausible` of std/pedestrians.scn; a test of the library compares the two.
            let gait = Gait::Inertial { acceleration: 1.65, stopping: 1.65, turn_rate: 80_f64.to_radians() };
            let body = PedestrianBody { gait, ..PedestrianBody::adult() };
            let mut walked = vec![PedestrianState::default()];
            let free = Obstacles::new(&[]);
            for (number, (heading, speed, ticks)) in commands.into_iter().enumerate() {
                let turned = if reverses && number % 2 == 1 { std::f64::consts::PI } else { 0.0 };
                let command = WalkCommand { heading: heading + turned, speed };
                for _ in 0..ticks {
                    walked.push(walked[walked.len() - 1].step(command, &body, &free, dt));
                }
            }
            let motion = PedestrianMotion::of(&walked, dt);
            prop_assert!(motion.is_foreseeable(), "{motion:?}");
            // And so in every part of the episode.
            prop_assert!(PedestrianMotion::of(&walked[..walked.len() / 2], dt).is_foreseeable());
        }
    }
}
