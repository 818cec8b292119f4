//! Noise of recordings: its size, and tracks without it.
//!
//! A track that fits its own speeds and headings, as an episode of a simulator does, is left as it is, to the last bit.

use super::encounter::STANDING;
use road::geometry::{Pose, Vector, wrap_angle};
use world::sim::{PedestrianState, VehicleState};

/// The longest time over which noise is averaged (s).
pub(super) const HALF_SECOND: f64 = 0.5;
/// The noise that remains of velocities (m/s), where half a second is long enough for it. A noise below it is none.
pub(super) const VELOCITY_NOISE: f64 = 0.05;
/// A noise of headings below this is none (rad).
const HEADING_NOISE: f64 = 0.005;
/// A position of the car that is less far from the one before, as a multiple of the noise, says nothing of its direction.
const MIN_STEP: f64 = 5.0;
/// Numbers below this many standard deviations of their noise are none.
pub(super) const SIGNIFICANT: f64 = 4.0;
/// The median of the absolute value of a normal number, and of the length of a pair of them, in standard deviations.
const OF_NUMBER: f64 = 0.674;
pub(super) const OF_PAIR: f64 = 1.177;

/// The standard deviation of the difference of two values by noise, from the median of their second differences: a body changes its velocity
/// little between two instants. `usual` is the median of such a difference, in standard deviations.
pub(super) fn median_noise(values: &[Vector], usual: f64) -> f64 {
    let mut changes: Vec<f64> =
        values.windows(3).map(|near| ((near[2] - near[1]) - (near[1] - near[0])).norm()).collect();
    let Some(last) = changes.len().checked_sub(1) else { return 0.0 };
    let (_, median, _) = changes.select_nth_unstable_by(last / 2, f64::total_cmp);
    // Each coordinate of a second difference deviates by the square root of 6.
    *median / (usual * 6.0_f64.sqrt()) * 2.0_f64.sqrt()
}

/// The instants at which values that are rounded, or held for several instants, change, and how many they are usually held for; `None` if most are not.
fn holds(values: &[Vector]) -> Option<(Vec<usize>, usize)> {
    let changed: Vec<usize> = (1..values.len()).filter(|place| values[*place] != values[*place - 1]).collect();
    let mut held: Vec<usize> = changed.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = held.len() / 2;
    let usual = if held.is_empty() { 1 } else { *held.select_nth_unstable(middle).1 };
    (usual > 1).then_some((changed, usual))
}

/// The same of values that are rounded or held: the usual step between them is the width of an equal distribution.
pub(super) fn step_noise(values: &[Vector]) -> f64 {
    let Some((changed, _)) = holds(values) else { return 0.0 };
    let mut steps: Vec<f64> = changed.iter().map(|place| (values[*place] - values[*place - 1]).norm()).collect();
    let middle = (steps.len() - 1) / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1 / 6.0_f64.sqrt()
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

/// The lines that fit best around each value: their value there and their change from one instant to the next. A line takes `span` steps, at the ends
/// those on one side.
fn lines(values: &[Vector], span: usize) -> Vec<(Vector, Vector)> {
    let last = values.len().max(1) - 1;
    let span = span.min(last);
    let count = (span + 1) as f64;
    let middle = span as f64 / 2.0;
    let spread = count * (count * count - 1.0) / 12.0;
    let line = |place: usize| {
        let from = place.saturating_sub(span - span / 2).min(last - span);
        let near = &values[from..=from + span];
        let mean = near.iter().sum::<Vector>() / count;
        if span == 0 {
            return (mean, Vector::zeros());
        }
        let moment: Vector = near.iter().enumerate().map(|(step, value)| (value - mean) * (step as f64 - middle)).sum();
        let slope = moment / spread;
        (mean + slope * ((place - from) as f64 - middle), slope)
    };
    (0..values.len()).map(line).collect()
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
    let state = |(position, line): (&Vector, (Vector, Vector))| {
        let velocity = line.1 / dt;
        let velocity = if velocity.norm() < none { Vector::zeros() } else { velocity };
        let place = if span > 1 { line.0 } else { *position };
        let yaw = libm::atan2(velocity.y, velocity.x);
        PedestrianState { velocity, ..PedestrianState::standing(Pose::new(place.x, place.y, yaw)) }
    };
    positions.iter().zip(lines(positions, span)).map(state).collect()
}

/// The usual speeds around each of some positions (m/s): the medians of half a second, of five steps at least. A jump does not change them.
pub(super) fn usual_speeds(positions: &[Vector], dt: f64) -> Vec<f64> {
    let around = (half_second(dt) as usize / 2).max(2);
    let steps: Vec<f64> = positions.windows(2).map(|pair| (pair[1] - pair[0]).norm() / dt).collect();
    let usual = |place: usize| {
        let mut near = steps[place.saturating_sub(around + 1)..steps.len().min(place + around)].to_vec();
        let middle = near.len() / 2;
        *near.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    (0..positions.len()).map(usual).collect()
}

/// Takes the noise out of a pedestrian whose velocity is recorded.
pub(super) fn clean_pedestrian(states: &mut [PedestrianState], dt: f64) {
    let velocities: Vec<Vector> = states.iter().map(|state| state.velocity).collect();
    let noise = median_noise(&velocities, OF_NUMBER);
    if noise > VELOCITY_NOISE {
        let span = (noise / VELOCITY_NOISE).powi(2).ceil().min(half_second(dt));
        let none = SIGNIFICANT * noise / (span + 1.0).sqrt();
        for (state, (velocity, _)) in states.iter_mut().zip(lines(&velocities, span as usize)) {
            state.velocity = if velocity.norm() < none { Vector::zeros() } else { velocity };
        }
    }
    let explained = ways(states.iter().map(|state| state.velocity), dt);
    let mut positions: Vec<Vector> = states.iter().map(|state| state.pose.position().coords).collect();
    clean_positions(&mut positions, &explained, dt);
    for (state, place) in states.iter_mut().zip(positions) {
        (state.pose.x, state.pose.y) = (place.x, place.y);
    }
}

/// Takes the noise out of a car.
pub(super) fn clean_car(states: &mut [VehicleState], dt: f64) {
    let speeds: Vec<Vector> = states.iter().map(|state| Vector::new(state.speed, 0.0)).collect();
    let half = half_second(dt);
    let noise = median_noise(&speeds, OF_NUMBER);
    if noise > VELOCITY_NOISE {
        let span = (noise / VELOCITY_NOISE).powi(2).ceil().min(half);
        let none = SIGNIFICANT * noise / (span + 1.0).sqrt();
        for (state, (speed, _)) in states.iter_mut().zip(lines(&speeds, span as usize)) {
            state.speed = if speed.x.abs() < none { 0.0 } else { speed.x };
        }
    }
    let headings: Vec<Vector> = unwrapped(states).into_iter().map(|yaw| Vector::new(yaw, 0.0)).collect();
    if median_noise(&headings, OF_NUMBER) > HEADING_NOISE {
        for (state, (yaw, _)) in states.iter_mut().zip(lines(&headings, half as usize)) {
            state.pose.yaw = wrap_angle(yaw.x);
        }
    }
    let explained = ways(states.iter().map(|state| state.pose.forward() * state.speed), dt);
    let mut positions: Vec<Vector> = states.iter().map(|state| state.pose.position().coords).collect();
    let noise = clean_positions(&mut positions, &explained, dt);
    if noise > 0.0 {
        let speeds = states.iter().map(|state| if state.speed.abs() > STANDING { state.speed.abs() } else { 0.0 });
        let speeds: Vec<f64> = speeds.collect();
        hold(&mut positions, &speeds, MIN_STEP * noise);
    }
    for (state, place) in states.iter_mut().zip(positions) {
        (state.pose.x, state.pose.y) = (place.x, place.y);
    }
}

/// The headings without jumps of a whole turn (rad).
fn unwrapped(states: &[VehicleState]) -> Vec<f64> {
    let mut turned = states.first().map_or(0.0, |state| state.pose.yaw);
    states
        .iter()
        .map(|state| {
            turned += wrap_angle(state.pose.yaw - turned);
            turned
        })
        .collect()
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

/// Takes the noise out of positions whose velocities explain these ways; the noise (m), 0 if there is none. What the velocities do not explain changes
/// slowly.
fn clean_positions(positions: &mut [Vector], explained: &[Vector], dt: f64) -> f64 {
    let rest: Vec<Vector> = positions.iter().zip(explained).map(|(position, way)| position - way).collect();
    let noise = median_noise(&rest, OF_PAIR).max(step_noise(positions));
    if noise <= VELOCITY_NOISE * dt {
        return 0.0;
    }
    let lines = lines(&rest, half_second(dt) as usize);
    for ((position, way), (rest, _)) in positions.iter_mut().zip(explained).zip(lines) {
        *position = way + rest;
    }
    noise
}

/// Keeps the positions that are at least `step` (m) apart, and the last. Between them the car is on a straight line, where its speeds bring it.
fn hold(positions: &mut [Vector], speeds: &[f64], step: f64) {
    let last = positions.len() - 1;
    let mut kept = vec![0];
    for place in 1..positions.len() {
        if (positions[place] - positions[kept[kept.len() - 1]]).norm() >= step {
            kept.push(place);
        }
    }
    if kept.len() == 1 {
        let middle = positions[last / 2];
        positions.fill(middle);
        return;
    }
    kept.pop();
    kept.push(last);
    for ends in kept.windows(2) {
        let (first, second) = (ends[0], ends[1]);
        let (from, to) = (positions[first], positions[second]);
        let covered = |end: usize| (first..end).map(|place| speeds[place] + speeds[place + 1]).sum::<f64>();
        let whole = covered(second);
        let mut way = 0.0;
        for place in first + 1..second {
            way += speeds[place - 1] + speeds[place];
            let share = if whole > 0.0 { way / whole } else { (place - first) as f64 / (second - first) as f64 };
            positions[place] = from + (to - from) * share;
        }
    }
}
