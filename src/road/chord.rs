//! The centres of lanes as chords: straight pieces, among which the nearest is looked for.

use super::lane_network::{LaneNetwork, LaneSlot, NetworkLane};
use super::{LaneFilter, Road};
use crate::geometry::{Point, Vector};

/// How far the heading turns before the next chord starts (rad).
const TURN: f64 = std::f64::consts::PI / 100.0;
/// The longest chord on a curved lane (m).
const MAX_LENGTH: f64 = 100.0;
/// The step in which a curved lane is searched for the end of a chord (m).
const STEP: f64 = 1.0;
/// Margin by which a chord stays before the end of its lane (m).
const MARGIN: f64 = 1e-6;
/// Greatest number of steps per lane, a guard against files with absurd lengths.
const MAX_STEPS: f64 = 8192.0;

/// A straight piece between two places on a lane's centre, seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chord {
    pub from: Point,
    pub along: Vector,
    pub length: f64,
    pub from_s: f64,
    pub to_s: f64,
    pub slot: LaneSlot,
}

impl Chord {
    /// How far along the chord the place nearest to a point is (m).
    pub fn project(&self, point: Point) -> f64 {
        (point - self.from).dot(&self.along).clamp(0.0, self.length)
    }

    pub fn distance_squared(&self, point: Point) -> f64 {
        (self.from + self.along * self.project(point) - point).norm_squared()
    }

    pub fn end(&self) -> Point {
        self.from + self.along * self.length
    }

    /// The place after a distance (m). CARLA counts metres along the chord as metres along the reference line.
    pub fn s(&self, moved: f64) -> f64 {
        if self.to_s >= self.from_s {
            (self.from_s + moved).min(self.to_s)
        } else {
            (self.from_s - moved).max(self.to_s)
        }
    }
}

/// The chords of the lanes that a filter admits.
///
/// # Source
/// CARLA `road/Map.cpp`, `CreateRtree`.
pub(super) fn chords(roads: &[Road], network: &LaneNetwork, filter: LaneFilter) -> Vec<Chord> {
    let mut chords = Vec::new();
    for (lane, slot) in network.lanes().iter().zip(0..).filter(|(lane, _)| filter.admits(lane.kind)) {
        chords_of(roads, network, lane, |begin, end| {
            let whole = end.place - begin.place;
            let (length, rise) = (whole.norm(), end.height - begin.height);
            let (from, height) = (begin.place, begin.height);
            if [from.x, from.y, height, length, rise].iter().all(|number| number.is_finite()) {
                let along = if length > 0.0 { whole / length } else { Vector::zeros() };
                chords.push(Chord { from, along, length, from_s: begin.s, to_s: end.s, slot });
            }
        });
    }
    chords.shrink_to_fit();
    chords
}

/// A place on a lane's centre where a chord may end.
#[derive(Clone, Copy)]
struct ChordEnd {
    s: f64,
    place: Point,
    height: f64,
    direction: [f32; 3],
}

impl ChordEnd {
    /// The angle between the directions of two places (rad).
    ///
    /// # Source
    /// CARLA `geom/Math.cpp`, `GetVectorAngle`, in its 32 bits: on a long bend they decide where a chord ends.
    fn turned(&self, other: &Self) -> f64 {
        let dot = |[a, b, c]: [f32; 3], [x, y, z]: [f32; 3]| a * x + b * y + c * z;
        let norm = |direction| dot(direction, direction).sqrt();
        let cos = dot(self.direction, other.direction) / (norm(self.direction) * norm(other.direction));
        f64::from(libm::acosf(cos))
    }
}

/// Returns the chords of a lane, in driving direction. Pitch counts as a turn.
fn chords_of(roads: &[Road], network: &LaneNetwork, lane: &NetworkLane, mut tell: impl FnMut(&ChordEnd, &ChordEnd)) {
    let (first, last) = lane.driving_ends();
    let length = (last - first).abs() - MARGIN;
    if length <= MARGIN || length.is_nan() {
        return;
    }
    let sign = if lane.forward() { 1.0 } else { -1.0 };
    let end_at = |along: f64| {
        let s = first + sign * along;
        let (place, direction) = network.carla_point(roads, lane, s);
        ChordEnd { s, place, height: network.elevation(roads, lane, s), direction }
    };
    if lane.straight {
        tell(&end_at(0.0), &end_at(length));
        return;
    }
    let step = STEP.max(length / MAX_STEPS);
    let (mut begun, mut begin, mut along) = (0.0, end_at(0.0), 0.0);
    while along < length {
        let next = (along + step).min(length);
        let end = end_at(next);
        if begin.turned(&end) > TURN || next - begun > MAX_LENGTH || next >= length {
            tell(&begin, &end);
            (begun, begin) = (next, end);
        }
        along = next;
    }
}
