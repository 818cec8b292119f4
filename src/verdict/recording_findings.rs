//! What is wrong in a recording. It is told with its place, and nothing is put right.

use std::fmt;

use super::recording_noise::{OF_PAIR, VELOCITY_NOISE, median_noise, noise, ways};
use super::recording_units::{MAX_UNSIGNED_REVERSING, MOVING, TrackOf};
use road::geometry::{Pose, Vector};
use world::sim::{PedestrianState, VehicleState};

/// Something in a recording that a reader must know.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The car or the pedestrian.
    pub who: &'static str,
    /// The first and the last instant.
    pub first: usize,
    pub last: usize,
    pub what: Damage,
    /// The lines of both in their file; `None` without a file.
    pub(super) lines: Option<(usize, usize)>,
}

/// What it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Damage {
    /// A speed (m/s), heading or velocity that nobody has between those before and after.
    Spike(&'static str),
    /// A step (m) that the speed (m/s) does not explain.
    Jump { moved: f64, speed: f64 },
    /// The mean velocity by positions and by speeds and headings (m/s) for a time (s).
    Contradiction { lasts: f64, moved: Vector, told: Vector },
    /// Positions that are repeated for as long (s).
    Held(f64),
    /// Noise of positions (m), speeds or velocities (m/s), or headings (rad): its standard deviation.
    Noise(&'static str, f64),
}

impl Finding {
    pub(super) fn new(who: &'static str, (first, last): (usize, usize), what: Damage) -> Self {
        Self { who, first, last, what, lines: None }
    }

    /// Whether an answer that rests on these instants is none.
    pub fn decides(&self) -> bool {
        !matches!(self.what, Damage::Noise(..))
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |word: &str, (first, last): (usize, usize)| match first == last {
            true => format!("{word} {first}"),
            false => format!("{word} {first} to {last}"),
        };
        let place = self.lines.map_or_else(|| place("instant", (self.first, self.last)), |lines| place("line", lines));
        let who = self.who;
        let speed = |velocity: &Vector| match velocity.norm() {
            speed if speed < 0.05 => "0 m/s".to_owned(),
            speed => format!("{speed:.1} m/s towards {:.0} deg", libm::atan2(velocity.y, velocity.x).to_degrees()),
        };
        let remedy = match who {
            "car" => "correct what is wrong",
            _ => "correct what is wrong, or leave out speed and heading: they then come from the positions",
        };
        match &self.what {
            Damage::Spike(quantity) => {
                write!(f, "{place}: the {quantity} of the {who} leaps there and back; correct it")
            }
            Damage::Jump { moved, speed } => write!(
                f,
                "{place}: the {who} has moved {moved:.1} m since the instant before, at {speed:.1} m/s; correct the position or the speed"
            ),
            Damage::Contradiction { lasts, moved, told } => write!(
                f,
                "{place}: in {lasts:.2} s from here on the {who} moves at {} by its positions, and at {} by its speed and heading; {remedy}",
                speed(moved),
                speed(told)
            ),
            Damage::Held(time) => write!(
                f,
                "{place}: positions of the {who} are repeated for {time:.2} s; give only rows with a new position, at their own step"
            ),
            Damage::Noise(quantity @ "positions", noise) => {
                write!(f, "{quantity} of the {who} have a noise of {noise:.3} m")
            }
            Damage::Noise(quantity @ "headings", noise) => {
                write!(f, "{quantity} of the {who} have a noise of {:.1} deg", noise.to_degrees())
            }
            Damage::Noise(quantity, noise) => write!(f, "{quantity} of the {who} have a noise of {noise:.2} m/s"),
        }
    }
}

/// How far the speed (m/s) and the heading (rad) of a car, and the velocity of a pedestrian (m/s), may be from those before and after: at once, and in each second.
const SPEED: (f64, f64) = (1.0, 15.0);
const HEADING: (f64, f64) = (0.2, 2.0);
const VELOCITY: (f64, f64) = (0.5, 2.0);
/// How long numbers may be wrong and come back (s).
const LASTS: f64 = 0.3;
/// Positions that are held for longer (s) are told.
const HELD: f64 = 0.2;

/// The places from one to before another whose values are far from those on both sides, which are near each other.
fn spikes(values: &[Vector], limit: f64, most: usize) -> Vec<(usize, usize)> {
    let (mut found, mut place) = (Vec::new(), 1);
    let is_off = |one: usize, other: usize| (values[one] - values[other]).norm() > limit;
    while place + 1 < values.len() {
        let before = place - 1;
        let ends = (place + 1..=place + most).take_while(|end| *end < values.len() && is_off(*end - 1, before));
        let back = |end: &usize| !is_off(*end, before) && (place..*end).all(|each| is_off(each, *end));
        match ends.into_iter().find(back) {
            Some(end) => {
                found.push((place, end - 1));
                place = end;
            }
            None => place += 1,
        }
    }
    // The first and the last are compared with the two beside them.
    if let Some(last) = values.len().checked_sub(1).filter(|last| *last > 1) {
        for (end, one, other) in [(0, 1, 2), (last, last - 1, last - 2)] {
            if is_off(end, one) && is_off(end, other) && !is_off(one, other) {
                found.push((end, end));
            }
        }
    }
    found
}

fn most(dt: f64) -> usize {
    ((LASTS / dt).round() as usize).max(1)
}

/// The spikes of a car's speeds and headings.
pub(super) fn spikes_of_car(states: &[VehicleState], dt: f64) -> Vec<Finding> {
    let limit = |(once, rate): (f64, f64)| once + rate * dt;
    let speeds: Vec<Vector> = states.iter().map(|state| Vector::new(state.speed, 0.0)).collect();
    let headings: Vec<Vector> = states.iter().map(|state| state.pose.forward()).collect();
    let told = |quantity| move |places| Finding::new("car", places, Damage::Spike(quantity));
    let speeds = spikes(&speeds, limit(SPEED), 1).into_iter().map(told("speed"));
    speeds.chain(spikes(&headings, limit(HEADING), 1).into_iter().map(told("heading"))).collect()
}

/// The spikes of a pedestrian's velocities that its positions do not have.
pub(super) fn spikes_of_pedestrian(states: &[PedestrianState], dt: f64) -> Vec<Finding> {
    let velocities: Vec<Vector> = states.iter().map(|state| state.velocity).collect();
    let limit = VELOCITY.0 + VELOCITY.1 * dt + OF_NOISE * median_noise(&velocities, OF_PAIR);
    let told = ways(velocities.iter().copied(), dt);
    // People turn at once, so at an end nothing shows that a velocity is wrong.
    let is_within = |(first, last): &(usize, usize)| *first > 0 && last + 1 < states.len();
    let is_wrong = |&(first, last): &(usize, usize)| {
        let (before, after) = (first - 1, last + 1);
        let moved = states[after].pose.position() - states[before].pose.position();
        let usual = (velocities[before] + velocities[after]) * ((after - before) as f64 * dt / 2.0);
        (moved - usual).norm() < (moved - told[after] + told[before]).norm()
    };
    let found = spikes(&velocities, limit, most(dt)).into_iter().filter(is_within).filter(is_wrong);
    found.map(|places| Finding::new("pedestrian", places, Damage::Spike("velocity"))).collect()
}

/// How far wrong positions are at least from the line between those before and after: a length (m), what an acceleration (m/s²) there and back explains,
/// and a multiple of the noise.
const ASIDE: f64 = 0.12;
const ACCELERATION: f64 = 8.0;
const OF_NOISE: f64 = 4.0;
/// The time (s) before and after wrong positions whose velocity is that of this line, but for a part of it (m/s) and a share.
const AROUND: f64 = 0.25;
const DEVIATION: (f64, f64) = (0.3, 0.1);

/// Positions that leave a steady way for an instant or a few, and come back to it with a step that nobody makes.
pub(super) fn spikes_of_positions(who: &'static str, positions: &[Vector], dt: f64) -> Vec<Finding> {
    let noise = noise(positions);
    let around = ((AROUND / dt).round() as usize).max(2);
    let last = positions.len() - 1;
    let mut found: Vec<Finding> = Vec::new();
    for end in 3..last {
        let off = |place: usize| {
            let (before, steps) = (place - 1, (end + 1 - place) as f64);
            let slope = (positions[end] - positions[before]) / steps;
            let far = ASIDE + ACCELERATION * (steps * dt).powi(2) / 8.0 + OF_NOISE * noise;
            let (first, beyond) = (before.saturating_sub(around), (end + around).min(last));
            let earlier = (positions[before] - positions[first]) / (before - first) as f64 - slope;
            let later = (positions[beyond] - positions[end]) / (beyond - end) as f64 - slope;
            let near =
                DEVIATION.0 * dt + DEVIATION.1 * slope.norm() + 2.0 * noise * (1.0 / steps + 1.0 / around as f64);
            let is_spike =
                (positions[end] - positions[end - 1] - slope).norm() > far && earlier.norm().max(later.norm()) <= near;
            is_spike.then(|| (earlier.norm() + later.norm() + VELOCITY_NOISE * dt * steps, place))
        };
        let begins = found.last().map_or(2, |spike| spike.last + 1).max(end.saturating_sub(most(dt)).max(2));
        let first = (begins..end).rev().filter_map(off).min_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((_, first)) = first {
            found.push(Finding::new(who, (first, end - 1), Damage::Spike("position")));
        }
    }
    found
}

/// Positions that are usually held for more than a fifth of a second while the actor moves.
pub(super) fn held(who: &'static str, positions: &[Vector], dt: f64) -> Option<Finding> {
    let usual = super::recording_noise::usual_hold(positions)? as f64 * dt;
    (usual > HELD).then(|| Finding::new(who, (0, positions.len() - 1), Damage::Held(usual)))
}

/// Durations of the parts that are compared (s).
const WINDOWS: [f64; 5] = [0.1, 0.2, 0.5, 1.0, 2.0];
/// What the positions of a part may lack or exceed: a share of the way that the fastest speed explains, a length (m), a drift (m/s) and a multiple of the
/// noise of positions.
const OF_WAY: f64 = 0.3;
const BESIDES: f64 = 0.5;
const DRIFT: f64 = 0.3;
const OF_POSITIONS: f64 = 6.0;
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

/// Finds the first of the shortest parts that contradict themselves, in the poses and speeds (m/s) of an actor at instants that are `dt` (s) apart; what follows is in doubt.
/// The mean velocity of a part lies between its velocities, whatever it brakes or turns; a speed that is late or early by a third of a second is within the tolerances.
pub(super) fn contradiction(who: &'static str, track: &[(Pose, f64)], dt: f64, of: TrackOf) -> Option<Finding> {
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
        let besides = |noise: f64| at_least + (DRIFT + OF_WAY * fastest) * lasts + OF_POSITIONS * noise;
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
        (exceeds(noise_of_all) && exceeds(here())).then(|| {
            let what = Damage::Contradiction { lasts, told: told / lasts, moved: moved / lasts };
            Finding::new(who, (first, last), what)
        })
    };
    let leaps = (1..=last).filter(|instant| {
        let change = track[*instant].1 - track[*instant - 1].1;
        of == TrackOf::Car && change.abs() > SPEED.0 + SPEED.1 * dt
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
