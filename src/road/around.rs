//! The driving lane around a point, and how far inside it the point is.

use std::collections::BTreeMap;

use super::chord::Chord;
use super::lane_network::LaneSlot;
use super::{LaneFilter, Place, Town, Waypoint};
use crate::geometry::{OrientedBox, Point, Vector};

/// How far beyond the edge of a lane the centre of a car still counts as inside (m).
const EDGE: f64 = 0.1;
/// Maximum number of lanes in a row through a junction, a guard against lanes that lead in circles.
const MAX_LANES: usize = 64;

/// The driving lane whose centre line is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneAround {
    /// The nearest place on its centre line.
    pub place: Waypoint,
    /// Distance from the point to 0.1 m beyond the edge of the lane (m); negative where the point is outside.
    pub inside: f64,
    /// The driving direction there, of length 1.
    pub direction: Vector,
    pub is_junction: bool,
}

impl Town {
    /// The driving lane whose centre line is nearest to a point; `None` in a town without such lanes, and for a point that is not finite.
    ///
    /// A point outside this lane is outside all driving lanes, as far as lanes beside each other are equally wide.
    pub fn lane_around(&self, place: impl Into<Place>) -> Option<LaneAround> {
        let place = place.into();
        let (chord, point) = (self.chord_at(place, LaneFilter::Driving)?, place.point);
        let lane = self.network.lane(chord.slot);
        Some(LaneAround {
            place: self.beside_chord(chord, point),
            inside: self.inside_at(chord, point),
            direction: chord.along,
            is_junction: lane.in_junction,
        })
    }

    /// How far a body is inside the driving lanes, as [`LaneAround::inside`] counts for the corner that is farthest outside.
    pub fn inside_road(&self, body: &OrientedBox, ground: f64) -> f64 {
        let inside = |corner| self.lane_around(Place::on(corner, ground)).map_or(f64::INFINITY, |lane| lane.inside);
        body.corners().map(inside).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether a point is past the end of the map: outside all driving lanes, ahead of the end of one that leads nowhere.
    pub fn is_past_end(&self, place: impl Into<Place>) -> bool {
        let place = place.into();
        let Some(lane) = self.lane_around(place).filter(|lane| lane.inside < 0.0) else { return false };
        let past = place.point - self.pose(lane.place).position();
        // From a place within a lane the nearest point outside lies at its side.
        self.successors(lane.place).next().is_none() && past.dot(&lane.direction) > past.norm() / 2.0
    }

    /// Whether a car can come to the end of a lane that leads nowhere within this distance (m), along the reference lines of the roads; any turn may
    /// lead there.
    pub fn ends_within(&self, from: Waypoint, distance: f64) -> bool {
        let Some(first) = self.network.slot(from) else { return false };
        let left = (self.network.lane(first).driving_ends().1 - from.s).abs();
        let mut ways = BTreeMap::from([(first, left)]);
        let mut open = vec![(first, left)];
        while let Some((slot, way)) = open.pop() {
            if way > distance || ways[&slot] < way {
                continue;
            }
            let next = self.network.next(self.network.lane(slot));
            if next.is_empty() {
                return true;
            }
            for slot in next {
                let lane = self.network.lane(*slot);
                let way = way + (lane.end - lane.start);
                if ways.get(slot).is_none_or(|found| way < *found) {
                    ways.insert(*slot, way);
                    open.push((*slot, way));
                }
            }
        }
        false
    }

    /// How far a point is inside a lane or one of those that lead on from it through a junction, as [`LaneAround::inside`] counts; the lane that
    /// holds it best.
    pub fn inside_way_on(&self, from: Waypoint, point: Point) -> f64 {
        let Some(first) = self.network.slot(from) else { return f64::NEG_INFINITY };
        let mut best = self.inside_of(first, point);
        for branch in self.network.next(self.network.lane(first)) {
            let mut slot = *branch;
            for _ in 0..MAX_LANES {
                best = best.max(self.inside_of(slot, point));
                let lane = self.network.lane(slot);
                match *self.network.next(lane) {
                    [only] if lane.in_junction => slot = only,
                    _ => break,
                }
            }
        }
        best
    }

    /// How far a point is inside the driving lane of a place, anywhere along it, as [`LaneAround::inside`] counts.
    pub fn inside_lane(&self, place: Waypoint, point: Point) -> f64 {
        self.network.slot(place).map_or(f64::NEG_INFINITY, |slot| self.inside_of(slot, point))
    }

    fn inside_of(&self, slot: LaneSlot, point: Point) -> f64 {
        let chords = self.index.chords_of(self.lanes(), slot, LaneFilter::Driving);
        chords.iter().map(|chord| self.inside_at(chord, point)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn inside_at(&self, chord: &Chord, point: Point) -> f64 {
        let width = self.network.width(self.network.lane(chord.slot), chord.s(chord.project(point)));
        width / 2.0 + EDGE - chord.distance_squared(point).sqrt()
    }
}
