//! Noise of recordings: its size, and velocities that are taken from noisy positions.

use std::f64::consts::SQRT_2;

use base::seed::Stream;
use base::statistics::normal_quantile;
use rand::RngExt;

use road::geometry::{Pose, Vector};
use world::sim::{PedestrianState, VehicleState};

/// The longest time over which a velocity is taken from positions (s).
pub(super) const HALF_SECOND: f64 = 0.5;
/// The noise that remains of such velocities (m/s), where half a second is long enough for it. A noise of recorded velocities below it is none.
pub(super) const VELOCITY_NOISE: f64 = 0.05;
/// Numbers below this many standard deviations of their noise are none.
pub(super) const SIGNIFICANT: f64 = 4.0;
/// The median of the absolute value of a normal number, and of the length of a pair of them, in standard deviations.
const OF_NUMBER: f64 = 0.674;
pub(super) const OF_PAIR: f64 = 1.177;

/// The middle number, the lower one of two; 0 without any.
pub(super) fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut numbers: Vec<f64> = numbers.collect();
    let Some(last) = numbers.len().checked_sub(1) else { return 0.0 };
    *numbers.select_nth_unstable_by(last / 2, f64::total_cmp).1
}

/// The standard deviation of the difference of two values by noise, from the median of their second differences: a body changes its velocity
/// little between two instants. `usual` is the median of such a difference, in standard deviations.
pub(super) fn median_noise(values: &[Vector], usual: f64) -> f64 {
    let changes = values.windows(3).map(|near| ((near[2] - near[1]) - (near[1] - near[0])).norm());
    // Each coordinate of a second difference deviates by the square root of 6.
    median(changes) / (usual * 6.0_f64.sqrt()) * SQRT_2
}

/// The instants at which values that are rounded, or held for several instants, change, and how many they are usually held for; `None` if most are not.
fn holds(values: &[Vector]) -> Option<(Vec<usize>, usize)> {
    let changed: Vec<usize> = (1..values.len()).filter(|place| values[*place] != values[*place - 1]).collect();
    let usual = median(changed.windows(2).map(|pair| (pair[1] - pair[0]) as f64)) as usize;
    (usual > 1).then_some((changed, usual))
}

/// The same of values that are rounded or held: the usual step between them is the width of an equal distribution.
pub(super) fn step_noise(values: &[Vector]) -> f64 {
    let Some((changed, _)) = holds(values) else { return 0.0 };
    median(changed.iter().map(|place| (values[*place] - values[*place - 1]).norm())) / 6.0_f64.sqrt()
}

/// How many instants in a row most positions are held for; `None` if they are not.
pub(super) fn usual_hold(positions: &[Vector]) -> Option<usize> {
    let (changed, usual) = holds(positions)?;
    let is_regular = |pair: &&[usize]| (pair[1] - pair[0]).abs_diff(usual) <= 1;
    let regular = changed.windows(2).filter(is_regular).count();
    (changed.len() > 3 && regular * 4 >= (changed.len() - 1) * 3).then_some(usual)
}

/// The standard deviation of the difference of two positions by noise (m).
pub(super) fn noise(positions: &[Vector]) -> f64 {
    median_noise(positions, OF_PAIR).max(step_noise(positions))
}

/// The change from one instant to the next of the lines that fit best around each value. A line takes `span` steps, at least one, at the ends those on one side.
fn slopes(values: &[Vector], span: usize) -> Vec<Vector> {
    let last = values.len().max(1) - 1;
    let span = span.min(last);
    let count = (span + 1) as f64;
    let spread = (count * (count * count - 1.0) / 12.0).max(f64::MIN_POSITIVE);
    let slope = |place: usize| -> Vector {
        let from = place.saturating_sub(span - span / 2).min(last - span);
        let near = values[from..=from + span].iter().enumerate();
        let moment: Vector = near.map(|(step, value)| (value - values[from]) * (step as f64 - span as f64 / 2.0)).sum();
        moment / spread
    };
    (0..values.len()).map(slope).collect()
}

/// The steps of half a second, also where a recording claims that they are shorter than any clock's.
fn half_second(dt: f64) -> f64 {
    let steps = (HALF_SECOND / dt).round();
    if steps < 1e9 { steps.max(1.0) } else { 1e9 }
}

/// The steps of a line whose change has little noise.
fn span_of_change(noise: f64, dt: f64) -> usize {
    let count = libm::cbrt(6.0 * (noise / (VELOCITY_NOISE * dt)) * (noise / (VELOCITY_NOISE * dt)));
    (count.ceil() - 1.0).clamp(1.0, half_second(dt)) as usize
}

/// The states of a pedestrian at these positions, `dt` (s) apart. Its velocity is that of the step to each position; the first one has the velocity of
/// the second. The noisier the positions, the longer the way that a velocity is taken from: up to half a second around it. A velocity below four
/// standard deviations of its noise is none.
pub(super) fn walked(positions: &[Vector], dt: f64) -> Vec<PedestrianState> {
    let noise = noise(positions);
    let span = span_of_change(noise, dt);
    let count = (span + 1) as f64;
    let none = SIGNIFICANT * noise * (6.0 / (count * (count * count - 1.0))).sqrt() / dt;
    let state = |(place, slope): (&Vector, Vector)| {
        let velocity = slope / dt;
        let velocity = if velocity.norm() < none { Vector::zeros() } else { velocity };
        let yaw = libm::atan2(velocity.y, velocity.x);
        PedestrianState { velocity, ..PedestrianState::standing(Pose::new(place.x, place.y, yaw)) }
    };
    positions.iter().zip(slopes(positions, span)).map(state).collect()
}

/// The usual speeds around each of some positions (m/s): the medians of half a second, of five steps at least. A jump does not change them.
pub(super) fn usual_speeds(positions: &[Vector], dt: f64) -> Vec<f64> {
    let around = (half_second(dt) as usize / 2).max(2);
    let steps: Vec<f64> = positions.windows(2).map(|pair| (pair[1] - pair[0]).norm() / dt).collect();
    let near = |place: usize| &steps[place.saturating_sub(around + 1)..steps.len().min(place + around)];
    (0..positions.len()).map(|place| median(near(place).iter().copied())).collect()
}

/// The ways that velocities explain, from the first instant.
pub(super) fn ways(velocities: impl Iterator<Item = Vector>, dt: f64) -> Vec<Vector> {
    let mut last: Option<Vector> = None;
    let mut way = Vector::zeros();
    velocities
        .map(|velocity| {
            way += last.map_or_else(Vector::zeros, |last| (last + velocity) * (dt / 2.0));
            last = Some(velocity);
            way
        })
        .collect()
}

/// The standard deviations of the noise of a recording, 0 where it is small: of the car's positions (m), speeds (m/s) and headings (rad), and of the pedestrian's
/// positions (m) and velocities (m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    pub car: [f64; 3],
    pub pedestrian: [f64; 2],
}

impl Noise {
    /// The noise of positions that is none (m), and that of headings (rad).
    const POSITION: f64 = 0.005;
    const HEADING: f64 = 0.005;

    /// That of some states `dt` (s) apart. Velocities that come from positions have none of their own.
    pub fn of(cars: &[VehicleState], walkers: &[PedestrianState], is_walked: bool, dt: f64) -> Self {
        let told = |noise: f64, least: f64| if noise > least { noise / SQRT_2 } else { 0.0 };
        let of_positions = |positions: &[Vector], velocities: &mut dyn Iterator<Item = Vector>| {
            let rest: Vec<Vector> =
                positions.iter().zip(ways(velocities, dt)).map(|(place, way)| place - way).collect();
            told(median_noise(&rest, OF_PAIR).max(step_noise(positions)), Self::POSITION)
        };
        let of_numbers = |numbers: &[Vector], least| told(median_noise(numbers, OF_NUMBER), least);
        let places: Vec<Vector> = cars.iter().map(|state| state.pose.position().coords).collect();
        let headings: Vec<Vector> = cars.iter().map(|state| state.pose.forward()).collect();
        let speeds: Vec<Vector> = cars.iter().map(|state| Vector::new(state.speed, 0.0)).collect();
        let driven = &mut headings.iter().zip(cars).map(|(heading, state)| heading * state.speed);
        let car =
            [of_positions(&places, driven), of_numbers(&speeds, VELOCITY_NOISE), of_numbers(&headings, Self::HEADING)];
        let places: Vec<Vector> = walkers.iter().map(|state| state.pose.position().coords).collect();
        let velocities: Vec<Vector> = walkers.iter().map(|state| state.velocity).collect();
        let walked = &mut velocities.iter().map(|velocity| if is_walked { Vector::zeros() } else { *velocity });
        let of_velocities = if is_walked { 0.0 } else { told(median_noise(&velocities, OF_PAIR), VELOCITY_NOISE) };
        Self { car, pedestrian: [of_positions(&places, walked), of_velocities] }
    }

    /// Adds as much noise again.
    pub fn add(&self, cars: &mut [VehicleState], walkers: &mut [PedestrianState], stream: &mut Stream) {
        let mut draw = |deviation: f64| match deviation {
            0.0 => 0.0,
            _ => deviation * normal_quantile(stream.random_range(1e-9..1.0 - 1e-9)),
        };
        let ([place, speed, heading], [position, velocity]) = (self.car, self.pedestrian);
        for state in cars {
            let pose = &mut state.pose;
            *pose = Pose::new(pose.x + draw(place), pose.y + draw(place), pose.yaw + draw(heading));
            state.speed += draw(speed);
        }
        for state in walkers {
            (state.pose.x, state.pose.y) = (state.pose.x + draw(position), state.pose.y + draw(position));
            state.velocity += Vector::new(draw(velocity), draw(velocity));
        }
    }
}
