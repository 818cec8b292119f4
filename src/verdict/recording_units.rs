//! Units of a recording: whether positions, speeds, headings and time fit each other.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::recording_error::RecordingError;
use super::recording_noise::{SIGNIFICANT, median, noise, ways};
use road::geometry::{Pose, Vector, wrap_angle};

/// Length of a stretch of a car and of a pedestrian (m), longer than the noise of positions, and the least mean speed on it (m/s).
const STRETCH: f64 = 2.0;
const SHORT_STRETCH: f64 = 0.5;
pub(super) const MOVING: f64 = 0.5;
/// The minimum number of such stretches that say something.
const MIN_STRETCHES: usize = 4;
const MIN_SHORT_STRETCHES: usize = 2;
/// A stretch of a pedestrian is at least this multiple of the noise of positions.
const MIN_OF_NOISE: f64 = 10.0;
/// A car whose speed is never negative may still move backwards, up to this speed (m/s).
pub(super) const MAX_UNSIGNED_REVERSING: f64 = 5.0;
/// What the length of a stretch may be, as a multiple of what the speed explains: of the longest at least the first number, since an actor that turns round
/// comes back, and of the median at most the second. Miles per hour give 0.45.
const EXPLAINED: (f64, f64) = (0.6, 1.7);
/// Other units: what they look like, and what the stretches then are.
const UNITS: [(&str, f64); 5] = [
    ("the speeds look like km/h; give m/s", 1.0 / 3.6),
    ("the speeds look like mph; give m/s", 0.44704),
    ("the positions look like feet; give m", 1.0 / 0.3048),
    ("the positions look like centimetres; give m", 100.0),
    ("the positions look like millimetres; give m", 1000.0),
];
/// A ratio at which there is hardly any speed.
const FAR: f64 = 20.0;
/// A ratio that differs by less from 1 is that of an instrument, not of a unit.
const WRONG: f64 = 0.3;
/// How near a ratio is to that of a unit, as a share of it.
const NEAR: f64 = 0.07;
/// Headings that deviate by less (rad) are right, whatever would fit better.
const SMALL: f64 = 0.05;

/// By which share ways may differ from what speeds explain in every of some parts of a recording, beside the noise of positions, and by how much headings may
/// deviate to one side in all of them: by as much as is small (rad). In a bend both may by what a point does that is as far from the rear axle (m). A slip is
/// shorter, or changes its side.
const PARTS: usize = 4;
const LASTING: f64 = 0.05;
const LASTING_OF_PEDESTRIAN: f64 = 0.25;
const SMALL_OF_PEDESTRIAN: f64 = 0.2;
const LEVER: f64 = 3.0;
/// Headings that fit much better otherwise deviate by more (rad).
const MISREAD: f64 = 0.02;

/// The likely cause of headings that are far beyond a whole turn, or fit as degrees.
const DEGREES: &str = "the numbers look like degrees where radians are needed";

/// A stretch of a track in which the actor moves.
struct Stretch {
    /// The way, in a straight line.
    moved: Vector,
    /// The way that speeds and headings explain.
    told: Vector,
    /// The length that the speeds explain (m), and their mean (m/s).
    explained: f64,
    speed: f64,
    /// The unit vector of the mean direction: as the numbers are, if they were degrees, if they were degrees that were taken for radians, if they
    /// counted from y to x, and if they were compass bearings.
    headings: [Vector; 5],
}

impl Stretch {
    fn ratio(&self) -> f64 {
        self.moved.norm() / self.explained
    }

    /// The angle from a heading to the motion (rad), −π to π.
    fn angle(&self, reading: usize) -> f64 {
        angle(self.headings[reading], self.moved)
    }
}

/// The angle from one direction to another (rad), −π to π.
fn angle(from: Vector, to: Vector) -> f64 {
    libm::atan2(from.perp(&to), from.dot(&to))
}

/// Whose track it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TrackOf {
    /// A car, which reverses with a negative speed, or slowly without.
    Car,
    /// A pedestrian, whose heading is that of its motion.
    Pedestrian,
}

/// Refuses units that do not fit, in the poses and speeds (m/s) of an actor at instants that are `dt` (s) apart. Medians decide, so noise and a standing
/// actor are not a misfit.
pub(super) fn misfit(who: &'static str, track: &[(Pose, f64)], dt: f64, of: TrackOf) -> Result<(), RecordingError> {
    let units =
        |ratio: f64| RecordingError::Units { who, ratio, dt: (dt * 1e6).round() / 1e6, likely: cause_of(ratio, dt) };
    let is_signed = track.iter().any(|(_, speed)| *speed < -MOVING);
    let noise = noise(&track.iter().map(|(pose, _)| pose.position().coords).collect::<Vec<Vector>>());
    let (length, minimum, reverses) = match of {
        TrackOf::Car => (STRETCH, MIN_STRETCHES, if is_signed { 0.0 } else { MAX_UNSIGNED_REVERSING }),
        TrackOf::Pedestrian => (SHORT_STRETCH.max(MIN_OF_NOISE * noise), MIN_SHORT_STRETCHES, 0.0),
    };
    let stretches = stretches(track, dt, length);
    if stretches.len() < minimum {
        return Ok(());
    }
    let ratio = median(stretches.iter().map(Stretch::ratio));
    let longest = stretches.iter().map(Stretch::ratio).fold(0.0, f64::max);
    if longest < EXPLAINED.0 || ratio > EXPLAINED.1 {
        return Err(units(ratio));
    }
    let deviation = |stretch: &Stretch, reading: usize| {
        let angle = stretch.angle(reading).abs();
        if stretch.speed <= reverses { FRAC_PI_2 - (angle - FRAC_PI_2).abs() } else { angle }
    };
    let of_reading = |reading| median(stretches.iter().map(|stretch| deviation(stretch, reading)));
    let found = of_reading(0);
    let mean =
        |reading| stretches.iter().map(|stretch| deviation(stretch, reading)).sum::<f64>() / stretches.len() as f64;
    // Noise of positions turns the line of a stretch by this much (rad): what deviates less is right.
    let doubt = noise / length * (1.0 + 2.0 / (stretches.len() as f64).sqrt());
    let (small, misread) = (SMALL.max(doubt), MISREAD.max(doubt));
    // Numbers beyond 1 that fit much better as degrees are degrees.
    let usual = median(track.iter().map(|(pose, _)| pose.yaw.abs()));
    let is_better = |reading| of_reading(reading) < (found / 4.0).min(PI - found);
    let fits_better = |reading| mean(reading) < mean(0) / 4.0;
    let likely = match () {
        () if found > small && is_better(4) && (1..4).all(|other| mean(4) < mean(other)) => {
            "they look like compass bearings, clockwise from north; give 90 degrees less the bearing"
        }
        () if found > small && (usual > 1.0 && is_better(1) || usual > TAU && found > FRAC_PI_4) => DEGREES,
        () if found > small && is_better(3) || mean(0) > misread && fits_better(3) => {
            "they look left-handed; of a left-handed frame change the signs of y and of the heading"
        }
        () if found > misread && is_better(2) || mean(0) > misread && fits_better(2) => {
            "the numbers look like radians where degrees are needed"
        }
        () if found <= FRAC_PI_4 => match lasting(&stretches, noise, reverses, of) {
            (ratio, _) if ratio != 1.0 => return Err(units(ratio)),
            (_, true) => {
                "it does so from the first instant to the last; correct the heading, or the frame of the positions"
            }
            _ => return Ok(()),
        },
        () if found < PI - FRAC_PI_4 => {
            "angles count from x to y; of a left-handed frame change the signs of y and of the heading"
        }
        () if is_signed => "its speed is negative, which is that of a car that reverses, and it moves forwards",
        () if of == TrackOf::Car => "a car that reverses has a negative speed",
        () => "the heading is that of the motion",
    };
    Err(RecordingError::Heading { who, degrees: found.max(mean(0)).to_degrees(), likely })
}

/// What holds in each part of a recording: the least ratio of the ways to what the speeds explain, 1 if it is small or noise in one of them, and whether headings deviate to one
/// side by more than another point of a car does in a bend.
fn lasting(stretches: &[Stretch], noise: f64, reverses: f64, of: TrackOf) -> (f64, bool) {
    if stretches.len() < PARTS {
        return (1.0, false);
    }
    let forward = |stretch: &Stretch| {
        let is_reversed = stretch.speed <= reverses && stretch.moved.dot(&stretch.told) < 0.0;
        if is_reversed { -stretch.moved } else { stretch.moved }
    };
    let bound = |part: usize| stretches.len() * part / PARTS;
    let parts = (0..PARTS).map(|part| {
        let (first, end) = (bound(part), bound(part + 1));
        let moved: Vector = stretches[first..end].iter().map(forward).sum();
        let told: Vector = stretches[first..end].iter().map(|stretch| stretch.told).sum();
        let near = &stretches[first.saturating_sub(1)..(end + 1).min(stretches.len())];
        let turned: f64 = near.windows(2).map(|pair| angle(forward(&pair[0]), forward(&pair[1]))).sum();
        let bend = turned.abs() / near[1..].iter().map(|stretch| stretch.moved.norm()).sum::<f64>();
        let deviates = angle(told, moved);
        let (small, share) =
            if of == TrackOf::Car { (SMALL, LASTING) } else { (SMALL_OF_PEDESTRIAN, LASTING_OF_PEDESTRIAN) };
        let side = if deviates.abs() > small + LEVER * bend { deviates.signum() } else { 0.0 };
        let ratio = moved.norm() / told.norm();
        let allowed = share + SIGNIFICANT * noise / told.norm() + (1.0 + (LEVER * bend).powi(2)).sqrt() - 1.0;
        (if (ratio - 1.0).abs() > allowed { ratio } else { 1.0 }, side)
    });
    let nearer = |one: f64, other: f64| if one > 1.0 { one.min(other).max(1.0) } else { one.max(other).min(1.0) };
    let (ratio, sides) = parts.reduce(|all, part| (nearer(all.0, part.0), all.1 + part.1)).unwrap_or((1.0, 0.0));
    (ratio, sides.abs() == PARTS as f64)
}

/// Whether enough of a track shows that its units fit.
pub(super) fn fits(track: &[(Pose, f64)], dt: f64, of: TrackOf) -> bool {
    let length = if of == TrackOf::Car { STRETCH } else { SHORT_STRETCH };
    stretches(track, dt, length).len() >= MIN_SHORT_STRETCHES && misfit("", track, dt, of).is_ok()
}

/// What explains stretches of another length.
fn cause_of(ratio: f64, dt: f64) -> String {
    let unit = UNITS.iter().find(|(_, factor)| (ratio / factor - 1.0).abs() < NEAR);
    match unit {
        Some((unit, _)) => (*unit).to_owned(),
        None if ratio > FAR => "its positions move and its speeds are near 0".to_owned(),
        None if (ratio - 1.0).abs() < WRONG => {
            format!("multiply the speeds by {ratio:.2}, or correct the time or the positions")
        }
        None => format!("with these speeds an instant would be {} s after the one before", significant(ratio * dt)),
    }
}

/// A number with two significant digits.
fn significant(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

/// Splits a track into stretches of this length (m), by the way or by what the speeds explain, and leaves out those in which it hardly moves.
fn stretches(track: &[(Pose, f64)], dt: f64, length: f64) -> Vec<Stretch> {
    let told = ways(track.iter().map(|(pose, speed)| pose.forward() * *speed), dt);
    let (mut found, mut first, mut explained) = (Vec::new(), 0, 0.0);
    for instant in 1..track.len() {
        explained += (track[instant - 1].1.abs() + track[instant].1.abs()) / 2.0 * dt;
        let moved = track[instant].0.position() - track[first].0.position();
        if moved.norm().max(explained) < length {
            continue;
        }
        let speed = explained / ((instant - first) as f64 * dt);
        if explained.max(moved.norm()) >= MOVING * (instant - first) as f64 * dt {
            let mean = |(offset, factor): (f64, f64)| -> Vector {
                let units = track[first..=instant].iter().map(|(pose, speed)| {
                    let yaw = wrap_angle(offset + pose.yaw * factor);
                    Vector::new(libm::cos(yaw), libm::sin(yaw)) * if *speed < 0.0 { -1.0 } else { 1.0 }
                });
                units.sum()
            };
            let told = told[instant] - told[first];
            let readings = [(0.0, 1.0), (0.0, PI / 180.0), (0.0, 180.0 / PI), (0.0, -1.0), (FRAC_PI_2, -1.0)];
            found.push(Stretch { moved, told, explained, speed, headings: readings.map(mean) });
        }
        (first, explained) = (instant, 0.0);
    }
    found
}
