//! A place in the coordinates of the lane that a car is on.

use super::chord::Chord;
use super::lane_network::LaneSlot;
use super::levels::{LEVEL, NEAR};
use super::{LaneFilter, Place, Town};
use crate::geometry::{Pose, wrap_angle};

/// By how much farther a lane counts for each radian between its direction and that of the car (m).
const PER_RADIAN: f64 = 3.0;
/// Lanes that fit equally well differ by less than this (m).
const EQUAL: f64 = 1e-6;
/// How far the lane is followed ahead of the car and back (m).
const REACH: f64 = 40.0;
/// By how much more a branch turns for each metre of its length (rad/m): of two equal turns the shorter one is taken.
const PER_METRE: f64 = 1e-3;
/// Maximum number of lanes in a row, a guard against lanes that lead in circles.
const MAX_LANES: usize = 64;

/// A place in the coordinates of the lane that a car is on, by what can be seen of the car: its route is not asked.
///
/// A translated and rotated town has the same numbers, up to rounding. In a mirrored one those to the left change their signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frenet {
    /// How far the place is along the lane from the car (m); negative behind it.
    pub along: f64,
    /// How far it is to the left of the lane's centre (m).
    pub left: f64,
    /// How far it is beyond the nearer edge of the lane (m); negative within.
    pub beyond_edge: f64,
    /// How far it is inside the driving lane whose centre is nearest (m); negative outside.
    pub inside: f64,
    /// The direction of the car's lane beside the place (rad).
    pub direction: f64,
    /// How far the car is to the left of its lane's centre (m).
    pub car_left: f64,
    /// The direction of the car less that of its lane (rad), positive to the left.
    pub car_turn: f64,
}

impl Town {
    /// A place in the coordinates of the lane that a car on this ground (m) is on; `None` in a town without driving lanes.
    ///
    /// Of the lanes within 10 m that one fits the car best whose distance, and 3 m for each radian between the directions, are least. It is followed
    /// for 40 m ahead, at forks along the branch that turns least, and back to its start. Beyond, its end is extended straight.
    pub fn frenet(&self, car: &Pose, ground: f64, place: Place) -> Option<Frenet> {
        let (own, point) = (self.fitting(car, ground)?, place.point);
        let before = self.chords(own.slot).iter().take_while(|chord| chord.from_s != own.from_s);
        let moved = own.project(car.position());
        let mut start = -moved - before.map(|chord| chord.length).sum::<f64>();
        let first = start.max(-REACH);
        let mut best: Option<(f64, &Chord, f64, f64)> = None;
        let mut slot = Some(own.slot);
        for _ in 0..MAX_LANES {
            let Some(lane) = slot.filter(|_| start < REACH) else { break };
            for chord in self.chords(lane) {
                let (low, high) = ((first - start).max(0.0), (REACH - start).min(chord.length));
                if low <= high {
                    let nearest = (point - chord.from).dot(&chord.along).clamp(low, high);
                    let apart = (chord.from + chord.along * nearest - point).norm_squared();
                    if best.is_none_or(|(least, ..)| apart < least) {
                        best = Some((apart, chord, nearest, start + nearest));
                    }
                }
                start += chord.length;
            }
            slot = self.straight_on(lane);
        }
        let (_, chord, nearest, along) = best?;
        let (beside, width) = self.on_chord(chord, nearest);
        let offset = beside.to_local(point);
        let past = match along {
            _ if along <= first + EQUAL => offset.x.min(0.0),
            _ if along >= start.min(REACH) - EQUAL => offset.x.max(0.0),
            _ => 0.0,
        };
        let under = self.on_chord(own, moved).0;
        Some(Frenet {
            along: along + past,
            left: offset.y,
            beyond_edge: offset.y.abs() - width / 2.0,
            inside: self.depth(place)?,
            direction: beside.yaw,
            car_left: under.to_local(car.position()).y,
            car_turn: wrap_angle(car.yaw - under.yaw),
        })
    }

    /// The piece of a driving lane that fits a car best. Of two that lie on each other, as behind a fork, the one that turns less.
    fn fitting(&self, car: &Pose, ground: f64) -> Option<&Chord> {
        let here = car.position();
        let is_on_level = |chord: &&Chord| !self.has_levels() || (self.height(chord, here) - ground).abs() < LEVEL;
        let mut best: Option<(f64, &Chord)> = None;
        for chord in self.chords_near(here, NEAR, LaneFilter::Driving).filter(is_on_level) {
            let turn = wrap_angle(libm::atan2(chord.along.y, chord.along.x) - car.yaw).abs();
            let misfit = chord.distance_squared(here).sqrt() + PER_RADIAN * turn;
            let is_better = best.is_none_or(|(least, other)| {
                misfit < least - EQUAL || misfit < least + EQUAL && self.bend(chord.slot) < self.bend(other.slot)
            });
            if is_better {
                best = Some((misfit, chord));
            }
        }
        best.map(|(_, chord)| chord).or_else(|| self.chord_at(Place::on(here, ground), LaneFilter::Driving))
    }

    /// The driving lane after a lane that turns least.
    fn straight_on(&self, lane: LaneSlot) -> Option<LaneSlot> {
        let next = self.network.next(self.network.lane(lane)).iter().copied();
        next.filter(|slot| !self.chords(*slot).is_empty()).min_by(|a, b| self.bend(*a).total_cmp(&self.bend(*b)))
    }

    /// How much a lane turns from its start to its end (rad), and a little for its length.
    fn bend(&self, slot: LaneSlot) -> f64 {
        let lane = self.network.lane(slot);
        let (start, end) = lane.driving_ends();
        let yaw = |s| self.network.pose(&self.roads, lane, s).yaw;
        wrap_angle(yaw(end) - yaw(start)).abs() + PER_METRE * (end - start).abs()
    }

    fn chords(&self, lane: LaneSlot) -> &[Chord] {
        self.index.chords_of(self.lanes(), lane, LaneFilter::Driving)
    }

    /// The centre of a lane this far along a chord (m), in driving direction, and the lane's width there (m).
    fn on_chord(&self, chord: &Chord, moved: f64) -> (Pose, f64) {
        let share = if chord.length > 0.0 { moved / chord.length } else { 0.0 };
        let (lane, s) = (self.network.lane(chord.slot), chord.from_s + (chord.to_s - chord.from_s) * share);
        (self.network.pose(&self.roads, lane, s), self.network.width(lane, s))
    }

    /// How far a place is inside the driving lane whose centre is nearest (m).
    fn depth(&self, place: Place) -> Option<f64> {
        let chord = self.chord_at(place, LaneFilter::Driving)?;
        let (centre, width) = self.on_chord(chord, chord.project(place.point));
        Some(width / 2.0 - (place.point - centre.position()).norm())
    }
}
