//! Parts of a recording in which the positions contradict the speeds or the headings.

use super::recording_noise::{noise, ways};
use super::recording_spikes::SPEED_SPIKE;
use super::recording_units::{MAX_UNSIGNED_REVERSING, MOVING, TrackOf};
use road::geometry::{Pose, Vector};

/// Durations of the parts that are compared (s).
const WINDOWS: [f64; 5] = [0.1, 0.2, 0.5, 1.0, 2.0];
/// What the positions of a part may lack or exceed: a share of the way that the fastest speed explains, a length (m), a drift (m/s) and a multiple of the
/// noise of positions.
const OF_WAY: f64 = 0.3;
const BESIDES: f64 = 0.5;
const DRIFT: f64 = 0.3;
const OF_NOISE: f64 = 6.0;
/// The same length (m) beside a change of speed that no car has, and how far (s) that reaches.
const BESIDE_LEAP: f64 = 0.1;
const BESIDE: f64 = 0.05;
/// The directions in which ways are compared: eight, of which the second half is the first, backwards.
const DIRECTIONS: [(f64, f64); 4] = [
    (1.0, 0.0),
    (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
    (0.0, 1.0),
    (-std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
];

/// A part of a track whose positions are not those of its speeds and headings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contradiction {
    /// The instant at which it begins.
    pub first: usize,
    /// How long it takes (s).
    pub lasts: f64,
    /// The mean velocity by speeds and headings, and by positions (m/s).
    pub told: Vector,
    pub moved: Vector,
}

/// Finds the first of the shortest parts that contradict themselves, in the poses and speeds (m/s) of an actor at instants that are `dt` (s) apart. The mean
/// velocity of a part lies between its velocities, whatever it brakes or turns; a speed that is late or early by a third of a second is within the tolerances.
pub(super) fn contradiction(track: &[(Pose, f64)], dt: f64, of: TrackOf) -> Option<Contradiction> {
    let positions: Vec<Vector> = track.iter().map(|(pose, _)| pose.position().coords).collect();
    let velocities: Vec<Vector> = track.iter().map(|(pose, speed)| pose.forward() * *speed).collect();
    let explained = ways(velocities.iter().copied(), dt);
    let noise_of_all = noise(&positions);
    let is_signed = of == TrackOf::Pedestrian || track.iter().any(|(_, speed)| *speed < -MOVING);
    let last = track.len() - 1;
    let within = |first: usize, steps: usize, at_least: f64| {
        let (lasts, parts) = (steps as f64 * dt, first..first + steps + 1);
        let moved = positions[first + steps] - positions[first];
        let told = explained[first + steps] - explained[first];
        if steps == 0 || (moved - told).norm() <= at_least {
            return None;
        }
        let fastest = parts.clone().map(|instant| velocities[instant].norm()).fold(0.0, f64::max);
        // A car whose speed is never negative may reverse.
        let may_reverse = !is_signed && fastest <= MAX_UNSIGNED_REVERSING;
        let besides = |noise: f64| at_least + (DRIFT + OF_WAY * fastest) * lasts + OF_NOISE * noise;
        let exceeds = |noise: f64| {
            DIRECTIONS.iter().any(|(x, y)| {
                let direction = Vector::new(*x, *y);
                let along = parts.clone().map(|instant| velocities[instant].dot(&direction) * lasts);
                let (least, most) = along
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), way| (least.min(way), most.max(way)));
                let (least, most) = if may_reverse { (least.min(-most), most.max(-least)) } else { (least, most) };
                let way = moved.dot(&direction);
                way > most + besides(noise) || way < least - besides(noise)
            })
        };
        // Positions may be noisier here than elsewhere.
        let here = || noise(&positions[first.saturating_sub(steps)..(first + 2 * steps + 1).min(last + 1)]);
        (exceeds(noise_of_all) && exceeds(here())).then(|| Contradiction {
            first,
            lasts,
            told: told / lasts,
            moved: moved / lasts,
        })
    };
    let leaps = (1..=last).filter(|instant| {
        let change = track[*instant].1 - track[*instant - 1].1;
        of == TrackOf::Car && change.abs() > SPEED_SPIKE.0 + SPEED_SPIKE.1 * dt
    });
    let steps = ((BESIDE / dt).round() as usize).max(1);
    let mut beside = leaps
        .flat_map(|instant| [(instant.saturating_sub(steps + 1), instant - 1), (instant, (instant + steps).min(last))]);
    if let Some(part) = beside.find_map(|(first, end)| within(first, end - first, BESIDE_LEAP)) {
        return Some(part);
    }
    let windows = WINDOWS.iter().map(|seconds| ((seconds / dt).round() as usize).max(1)).filter(|steps| *steps <= last);
    windows
        .flat_map(|steps| {
            (0..last - steps).step_by((steps / 4).max(1)).chain([last - steps]).map(move |first| (first, steps))
        })
        .find_map(|(first, steps)| within(first, steps, BESIDES))
}
