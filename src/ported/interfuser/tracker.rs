use std::f64::consts::PI;

use super::object_map::{Cell, centre};
use road::geometry::{Point, Vector};

/// Updates a second.
const FREQUENCY: f64 = 10.0;
/// The number of updates over which a track is evaluated.
const LOOK_BACK: i64 = 12;
/// The number of updates that a track survives without a detection.
const LIFE: i64 = 6;
/// Maximum distance of a detection from its track (m).
const GATE: f64 = 2.0;
/// Displacements per update count from this speed (m/s) up to this one.
const SPEEDS: (f64, f64) = (0.2, 7.0);
/// Weight of the track against the frame, at full confidence.
const MERGE: f64 = 0.4 * 0.1;
/// The number of points of a track: one per update, and two more for the double updates at the start of an episode.
const KEPT: usize = LOOK_BACK as usize + 4;

/// Where and when a road user was detected; the places are north and east (m).
#[derive(Debug, Clone)]
struct Track {
    places: [Vector; KEPT],
    updates: [i64; KEPT],
    count: usize,
}

impl Track {
    fn new() -> Self {
        Self { places: [Vector::zeros(); KEPT], updates: [0; KEPT], count: 0 }
    }

    fn push(&mut self, place: Vector, update: i64) {
        if self.count == KEPT {
            self.places.copy_within(1.., 0);
            self.updates.copy_within(1.., 0);
            self.count -= 1;
        }
        self.places[self.count] = place;
        self.updates[self.count] = update;
        self.count += 1;
    }

    fn last(&self) -> (Vector, i64) {
        (self.places[self.count - 1], self.updates[self.count - 1])
    }

    /// Speed (m/s) and heading (half turns) with their confidences.
    fn motion(&self) -> Motion {
        let (_, last) = self.last();
        let (mut speeds, mut weights, mut samples) = (0.0, 0_i64, 0);
        let (mut directions, mut headings) = (Vector::zeros(), 0);
        for first in (0..self.count.saturating_sub(2)).rev() {
            if self.updates[first] < last - LOOK_BACK {
                break;
            }
            let moved = self.places[first + 2] - self.places[first];
            let updates = self.updates[first + 1] - self.updates[first];
            let distance = moved.norm();
            // Two updates of the same number make this infinite; then it has no weight but counts as a sample.
            let speed = (0.5 * FREQUENCY * distance / updates as f64 - SPEEDS.0).clamp(0.0, SPEEDS.1);
            samples += 1;
            if updates > 0 {
                speeds += speed * updates as f64;
                weights += updates;
            }
            if speed > 1.0 {
                headings += 1;
                directions += moved / distance;
            }
        }
        let confidence = |samples: i32| (f64::from(samples) / 10.0).sqrt();
        // The mean before its norm, as published: whether opposite directions cancel depends on the last bits.
        let mean = directions / f64::from(headings.max(1));
        let mean = mean / mean.norm();
        let clockwise = libm::acos(mean.x.clamp(-1.0, 1.0));
        let clockwise = if mean.y < 0.0 { 2.0 * PI - clockwise } else { clockwise };
        Motion {
            speed: (weights > 0).then(|| (speeds / weights as f64, confidence(samples))),
            // Displacements that cancel have no direction.
            heading: (headings > 0 && mean.x.is_finite())
                .then(|| ((4.0 - clockwise / PI).rem_euclid(2.0), confidence(headings))),
        }
    }
}

#[derive(Debug)]
struct Motion {
    speed: Option<(f64, f64)>,
    heading: Option<(f64, f64)>,
}

/// Follows detections over time and corrects their headings and speeds.
///
/// # Source
/// InterFuser `team_code/tracker.py`, with its three mistakes: the offsets of a cell are swapped, directions are blended in
/// another convention than the map's, and the speed is blended with the heading's channel. From the third update of a track on, every road user
/// is therefore forecast at about as many m/s as its heading has half turns.
///
/// The results are those of the published code to the last bits where numpy takes sine and cosine from the C library. On processors with
/// AVX-512 numpy computes them itself, and many differ in the last bit. A displacement of 1.2 m/s lies exactly at the published limit of
/// 1.0 m/s after the deduction of 0.2 m/s, so there the bit decides whether it counts, which changes headings and speeds by about 0.2 %.
#[derive(Debug, Clone)]
pub struct Tracker {
    tracks: Vec<Track>,
    taken: Vec<bool>,
}

impl Default for Tracker {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker {
    /// Makes one without tracks.
    pub fn new() -> Self {
        // Room for more people than a map can show, so that updates allocate nothing.
        Self { tracks: Vec::with_capacity(128), taken: Vec::with_capacity(128) }
    }

    /// Forgets all tracks.
    pub fn reset(&mut self) {
        self.tracks.clear();
    }

    /// Corrects the detections of an update.
    ///
    /// `place` is the ego's (x east, y north), `compass` its heading from north (rad), clockwise, and `update` a counter
    /// of tenths of seconds.
    pub fn update(&mut self, detections: &mut [Cell], place: Point, compass: f64, update: i64) {
        let (sin, cos) = libm::sincos(compass);
        self.taken.clear();
        self.taken.resize(self.tracks.len(), false);
        let known = self.tracks.len();
        for detection in detections {
            let (right, forward) = centre(detection.row, detection.col);
            let (right, forward) = (right + detection.dy, forward + detection.dx);
            let seen = Vector::new(cos * forward - sin * right + place.y, sin * forward + cos * right + place.x);
            let mut nearest: Option<(f64, usize)> = None;
            for (index, track) in self.tracks[..known].iter().enumerate() {
                let distance = (track.last().0 - seen).norm();
                if !self.taken[index] && nearest.is_none_or(|(least, _)| distance < least) {
                    nearest = Some((distance, index));
                }
            }
            let index = match nearest.filter(|(distance, _)| *distance <= GATE) {
                Some((_, index)) => {
                    self.taken[index] = true;
                    index
                }
                None => {
                    self.tracks.push(Track::new());
                    self.tracks.len() - 1
                }
            };
            let track = &mut self.tracks[index];
            track.push(seen, update);
            correct(detection, &track.motion(), compass);
        }
        self.tracks.retain(|track| track.last().1 > update - LIFE);
    }
}

fn correct(detection: &mut Cell, motion: &Motion, compass: f64) {
    if let Some((heading, confidence)) = motion.heading {
        let share = MERGE * confidence;
        detection.theta = (heading + compass / PI).rem_euclid(2.0) * share + detection.theta * (1.0 - share);
    }
    if let Some((speed, confidence)) = motion.speed {
        let share = MERGE * confidence;
        detection.speed = speed * share + detection.theta * (1.0 - share);
    }
    // The map goes through the network's units once more, which moves some offsets by a bit.
    for (value, scale) in [(&mut detection.dx, 3.5), (&mut detection.dy, 3.5), (&mut detection.half_length, 3.5)] {
        *value = *value / scale * scale;
    }
}
