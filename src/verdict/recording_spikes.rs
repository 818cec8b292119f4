//! Numbers of a recording that those before and after contradict: they last for an instant or a few.

use super::recording_noise::{OF_PAIR, VELOCITY_NOISE, median_noise, step_noise, ways};
use road::geometry::{Pose, Vector, wrap_angle};
use world::sim::{PedestrianState, VehicleState};

/// How far the speed (m/s) and the heading (rad) of a car may be from those before and after: at once, and in each second.
pub(super) const SPEED_SPIKE: (f64, f64) = (1.0, 15.0);
const HEADING_SPIKE: (f64, f64) = (0.2, 2.0);
/// The same of the velocity of a pedestrian (m/s).
const VELOCITY_SPIKE: (f64, f64) = (0.5, 2.0);
/// How long velocities of a pedestrian and positions may be wrong (s).
const LASTS: f64 = 0.3;
/// How far wrong positions are at least from the line between those before and after: a length (m), what an acceleration (m/s²) there and back explains,
/// and a multiple of the noise.
const ASIDE: f64 = 0.03;
const ACCELERATION: f64 = 8.0;
const OF_NOISE: f64 = 4.0;
/// The time (s) before and after wrong positions whose velocity is that of this line, but for a part of it (m/s) and a share.
const AROUND: f64 = 0.25;
const DEVIATION: (f64, f64) = (0.3, 0.1);

/// The instants at which a car has a speed or a heading that no car has between those before and after. They get the mean of both. The first and the last
/// instant are compared with the two beside them.
pub(super) fn remove_spikes(states: &mut [VehicleState], dt: f64) -> Vec<usize> {
    let Some(last) = states.len().checked_sub(1).filter(|last| *last > 1) else { return Vec::new() };
    let mut found = spikes(states, (1..last).map(|place| (place, place - 1, place + 1)), dt);
    found.extend(spikes(states, [(0, 1, 2), (last, last - 1, last - 2)].into_iter(), dt));
    found.sort_unstable();
    found
}

/// Removes the spikes among some instants, each with two others.
fn spikes(states: &mut [VehicleState], places: impl Iterator<Item = (usize, usize, usize)>, dt: f64) -> Vec<usize> {
    let speeds: Vec<f64> = states.iter().map(|state| state.speed).collect();
    let headings: Vec<f64> = states.iter().map(|state| state.pose.yaw).collect();
    let is_spike = |(once, rate): (f64, f64), from: f64, to: f64| {
        let limit = once + rate * dt;
        from.abs() > limit && to.abs() > limit && from * to > 0.0 && (from - to).abs() <= limit
    };
    let mut found = Vec::new();
    for (place, one, other) in places {
        let (from, to) = (speeds[place] - speeds[one], speeds[place] - speeds[other]);
        let is_hasty = is_spike(SPEED_SPIKE, from, to);
        if is_hasty {
            states[place].speed -= (from + to) / 2.0;
        }
        let (from, to) = (wrap_angle(headings[place] - headings[one]), wrap_angle(headings[place] - headings[other]));
        let is_turned = is_spike(HEADING_SPIKE, from, to);
        if is_turned {
            states[place].pose.yaw -= (from + to) / 2.0;
        }
        if is_hasty || is_turned {
            found.push(place);
        }
    }
    found
}

/// The instants at which a pedestrian has a velocity that neither those before and after nor its positions have. They get the velocities between both.
pub(super) fn remove_velocity_spikes(states: &mut [PedestrianState], dt: f64) -> Vec<usize> {
    let mut velocities: Vec<Vector> = states.iter().map(|state| state.velocity).collect();
    let limit = VELOCITY_SPIKE.0 + VELOCITY_SPIKE.1 * dt + OF_NOISE * median_noise(&velocities, OF_PAIR);
    let told = ways(velocities.iter().copied(), dt);
    let mut found = Vec::new();
    let mut place = 1;
    while place + 1 < states.len() {
        let from = velocities[place - 1];
        let is_off = |instant: usize, from: Vector| (velocities[instant] - from).norm() > limit;
        let ends = (place..place + most(dt)).take_while(|instant| is_off(*instant, from)).map(|instant| instant + 1);
        let end = ends.take_while(|end| *end < states.len()).find(|end| {
            let to = velocities[*end];
            let moved = states[*end].pose.position() - states[place - 1].pose.position();
            let usual = (from + to) * ((end + 1 - place) as f64 * dt / 2.0);
            (to - from).norm() <= limit
                && (place..*end).all(|instant| is_off(instant, to))
                && (moved - usual).norm() < (moved - told[*end] + told[place - 1]).norm()
        });
        let end = end.unwrap_or(place);
        interpolate(&mut velocities, place, end);
        for instant in place..end {
            states[instant].velocity = velocities[instant];
            states[instant].pose.yaw = libm::atan2(velocities[instant].y, velocities[instant].x);
        }
        found.extend(place..end);
        place = end.max(place + 1);
    }
    found
}

/// The most instants that may be wrong.
fn most(dt: f64) -> usize {
    ((LASTS / dt).round() as usize).max(1)
}

/// Puts the values from one place to before another on the line between those before and after.
fn interpolate(values: &mut [Vector], first: usize, end: usize) {
    if first < end {
        let (from, to) = (values[first - 1], values[end]);
        let share = |place: usize| (place + 1 - first) as f64 / (end + 1 - first) as f64;
        (first..end).for_each(|place| values[place] = from + (to - from) * share(place));
    }
}

/// Takes positions that leave a steady way for an instant or a few, and come back to it with a step that nobody makes, to that way; their instants. Velocities, if they are known,
/// say which way is steady.
pub(super) fn remove_position_spikes<'a>(
    poses: impl Iterator<Item = &'a mut Pose>,
    known: Option<&[Vector]>,
    dt: f64,
) -> Vec<usize> {
    let mut poses: Vec<&mut Pose> = poses.collect();
    let positions: Vec<Vector> = poses.iter().map(|pose| pose.position().coords).collect();
    let explained =
        known.map_or_else(|| vec![Vector::zeros(); positions.len()], |known| ways(known.iter().copied(), dt));
    let mut rest: Vec<Vector> = positions.iter().zip(&explained).map(|(position, way)| position - way).collect();
    let noise = median_noise(&rest, OF_PAIR).max(step_noise(&positions));
    let around = ((AROUND / dt).round() as usize).max(2);
    let last = rest.len() - 1;
    let mut found = Vec::new();
    for end in 3..last {
        // How far the way between before a place and here is from those around it; `None` if the places between are not wrong.
        let off = |place: usize| {
            let (before, steps) = (place - 1, (end + 1 - place) as f64);
            let slope = (rest[end] - rest[before]) / steps;
            let far = ASIDE + ACCELERATION * (steps * dt).powi(2) / 8.0 + OF_NOISE * noise;
            if (rest[end] - rest[end - 1] - slope).norm() <= far {
                return None;
            }
            let (first, beyond) = (before.saturating_sub(around), (end + around).min(last));
            let earlier = (rest[before] - rest[first]) / (before - first) as f64 - slope;
            let later = (rest[beyond] - rest[end]) / (beyond - end) as f64 - slope;
            let near =
                DEVIATION.0 * dt + DEVIATION.1 * slope.norm() + 2.0 * noise * (1.0 / steps + 1.0 / around as f64);
            let is_steady = earlier.norm().max(later.norm()) <= near;
            is_steady.then(|| earlier.norm() + later.norm() + VELOCITY_NOISE * dt * steps)
        };
        let places = (end.saturating_sub(most(dt)).max(2)..end).rev();
        let first =
            places.filter_map(|place| Some((off(place)?, place))).min_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((_, first)) = first {
            interpolate(&mut rest, first, end);
            for instant in first..end {
                let position = rest[instant] + explained[instant];
                (poses[instant].x, poses[instant].y) = (position.x, position.y);
            }
            found.extend(first..end);
        }
    }
    found
}
