//! Roads above each other. The simulator is planar: an actor has a level, the height of the ground under it, which it keeps as it moves along.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::chord::Chord;
use super::chord_tree::first_nearest;
use super::{LaneFilter, LaneKind, Place, RoadIndex, RoadLink, Town, Waypoint};
use crate::geometry::{Point, Pose};

/// Places whose heights differ by less than this are on one level (m).
pub const LEVEL: f64 = 3.0;
/// Lanes that are farther away than this do not say how high the ground is (m).
pub(super) const NEAR: f64 = 10.0;
/// Lanes that are farther away than this are looked for on all levels (m).
const FAR: f64 = 50.0;
/// Who is beyond the edge of a lane by this much is on it (m).
const EDGE: f64 = 0.1;
/// The step in which the ground is followed (m).
const STEP: f64 = 2.0;
/// Lanes whose directions have a greater cosine lead the same way.
const SAME_WAY: f64 = 0.7;

/// A place at which a lane of one road lies on a lane of another one, as seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    pub roads: [RoadIndex; 2],
    pub place: Point,
    /// The difference of their heights (m).
    pub apart: f64,
    /// Whether cars drive on both, in about one direction.
    pub is_same_way: bool,
}

impl Town {
    /// Whether lanes near each other differ in height by more than 3 m. It is decided once; otherwise all actors are on one level.
    pub fn has_levels(&self) -> bool {
        *self.has_levels.get_or_init(|| {
            let is_flat = self.roads.iter().all(|road| road.plan_view.elevation().cubics().is_empty());
            let chords = || self.index.chords(self.lanes(), LaneFilter::Any).iter();
            let is_above = |(point, height): (Point, f64)| {
                self.chords_near(point, NEAR, LaneFilter::Any)
                    .any(|chord| (self.height(chord, point) - height).abs() >= LEVEL)
            };
            !is_flat && chords().any(|chord| self.along_chord(chord).any(is_above))
        })
    }

    /// Places along a chord, with their heights (m).
    fn along_chord(&self, chord: &Chord) -> impl Iterator<Item = (Point, f64)> {
        let steps = (chord.length / STEP).ceil().max(1.0);
        let place = move |step: u32| chord.from + chord.along * (chord.length * (f64::from(step) + 0.5) / steps);
        (0..steps as u32).map(place).map(|point| (point, self.height(chord, point)))
    }

    pub(super) fn chords_near(&self, point: Point, reach: f64, filter: LaneFilter) -> impl Iterator<Item = &Chord> {
        let (tree, chords) = self.index.tree(self.lanes(), filter);
        tree.within(point, reach).map(|index| &chords[index as usize])
    }

    /// The height of a chord beside a place (m).
    pub(super) fn height(&self, chord: &Chord, point: Point) -> f64 {
        self.network.elevation(&self.roads, self.network.lane(chord.slot), chord.s(chord.project(point)))
    }

    /// How far a place is beyond the edge of the lane of a chord, or of a lane beside it (m).
    fn beyond(&self, chord: &Chord, point: Point) -> f64 {
        let width = self.network.width(self.network.lane(chord.slot), chord.s(chord.project(point)));
        (chord.distance_squared(point).sqrt() - width / 2.0 - EDGE).max(0.0)
    }

    /// The height of the ground of somebody who comes to a place (m), from ground of this height next to it: that of the lane there, of the nearest
    /// one on its level, or the same without one.
    pub fn ground(&self, point: Point, before: f64) -> f64 {
        let near = self.chords_near(point, NEAR, LaneFilter::Any);
        let heights = near.map(|chord| (self.beyond(chord, point), self.height(chord, point)));
        let on_level = heights.filter(|(_, height)| (height - before).abs() < LEVEL);
        let order = |(beyond, height): &(f64, f64)| (*beyond, (height - before).abs());
        on_level
            .min_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal))
            .map_or(before, |(_, height)| height)
    }

    /// The height of the ground (m) at the end of a straight way.
    fn follow(&self, from: Place, to: Point) -> f64 {
        let (way, start) = (to - from.point, from.ground.unwrap_or_default());
        let steps = (way.norm() / STEP).ceil().max(1.0);
        (1..=steps as u32).fold(start, |height, step| self.ground(from.point + way * (f64::from(step) / steps), height))
    }

    /// Whether somebody at one place can meet and see somebody at another one. Always so in a town without levels.
    pub fn is_on_level(&self, from: Place, to: Place) -> bool {
        let (Some(own), Some(other), true) = (from.ground, to.ground, self.has_levels()) else { return true };
        let is_near = (to.point - from.point).norm_squared() < NEAR * NEAR;
        let seen = if is_near { own } else { self.follow(from, to.point) };
        (seen - other).abs() < LEVEL
    }

    /// The height of the ground of somebody who is put at a place (m): where lanes lie above each other, the one on the level of another place.
    pub fn ground_beside(&self, from: Place, point: Point) -> f64 {
        let followed = self.follow(from, point);
        let on = self.chords_near(point, NEAR, LaneFilter::Any).filter(|chord| self.beyond(chord, point) == 0.0);
        let heights = on.map(|chord| self.height(chord, point));
        heights.min_by(|a, b| (a - followed).abs().total_cmp(&(b - followed).abs())).unwrap_or(followed)
    }

    /// The driving lane on which a car at a pose is: the nearest one and, where roads lie above each other, one in its direction, the lowest.
    pub fn lane_under(&self, pose: &Pose) -> Option<Waypoint> {
        let point = pose.position();
        let chords = self.has_levels().then(|| self.chords_near(point, NEAR, LaneFilter::Driving));
        let same_way = chords.into_iter().flatten().filter(|chord| chord.along.dot(&pose.forward()) > SAME_WAY);
        let order =
            |chord: &Chord| (self.beyond(chord, point), self.height(chord, point), chord.distance_squared(point));
        let found = same_way.min_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal));
        found.map_or_else(
            || self.nearest_lane(point, LaneFilter::Driving),
            |chord| Some(self.beside_chord(chord, point)),
        )
    }

    pub fn place_of_car(&self, pose: &Pose) -> Place {
        let lane = self.has_levels().then(|| self.lane_under(pose)).flatten();
        Place { point: pose.position(), ground: lane.map(|lane| self.elevation(lane)) }
    }

    /// A place that lies on the level of another one.
    pub fn place_from(&self, from: Place, point: Point) -> Place {
        Place { point, ground: self.has_levels().then(|| self.follow(from, point)) }
    }

    /// The nearest chord, on the level of the place if there is one.
    pub(super) fn chord_at(&self, place: Place, filter: LaneFilter) -> Option<&Chord> {
        let (lanes, point) = (self.lanes(), place.point);
        let nearest = || self.index.nearest_chord(lanes, point, filter);
        let Some(ground) = place.ground.filter(|_| self.has_levels()) else { return nearest() };
        let (tree, chords) = self.index.tree(lanes, filter);
        let is_on_level = |index: &u32| (self.height(&chords[*index as usize], point) - ground).abs() < LEVEL;
        let found = [NEAR, FAR]
            .into_iter()
            .find_map(|reach| first_nearest(chords, tree.within(point, reach).filter(is_on_level), point));
        found.map_or_else(nearest, |index| Some(&chords[index as usize]))
    }

    /// The pairs of roads that lie on or above each other, each at the place at which they are least apart in height. Roads of one junction, and
    /// those that follow each other, may.
    pub fn crossings(&self) -> Vec<Crossing> {
        let mut found: BTreeMap<[RoadIndex; 2], Crossing> = BTreeMap::new();
        for chord in self.index.chords(self.lanes(), LaneFilter::Driving) {
            let lane = self.network.lane(chord.slot);
            for (place, height) in self.along_chord(chord) {
                let width = self.network.width(lane, chord.s(chord.project(place)));
                for other in self.chords_near(place, width, LaneFilter::Any) {
                    let under = self.network.lane(other.slot);
                    let (moved, is_car) = (other.project(place), under.kind == LaneKind::Driving);
                    let is_inside = moved > 0.0 && moved < other.length;
                    let reach = (width + self.network.width(under, other.s(moved))) / 4.0;
                    if under.road == lane.road || !is_inside || other.distance_squared(place) > reach * reach {
                        continue;
                    }
                    let apart = (self.height(other, place) - height).abs();
                    let is_joined = apart < LEVEL && self.is_joined(lane.road, under.road);
                    let is_crossing = is_car || under.kind == LaneKind::Sidewalk && apart >= LEVEL;
                    let roads = [lane.road.min(under.road), lane.road.max(under.road)];
                    if !is_joined && is_crossing && found.get(&roads).is_none_or(|known| apart < known.apart) {
                        let is_same_way = is_car && chord.along.dot(&other.along) > SAME_WAY;
                        found.insert(roads, Crossing { roads, place, apart, is_same_way });
                    }
                }
            }
        }
        found.into_values().collect()
    }

    /// Whether two roads are of one junction, or lead to each other or to the junction of the other.
    fn is_joined(&self, a: RoadIndex, b: RoadIndex) -> bool {
        let [own, other] = [a, b].map(|road| &self.roads[road.0 as usize]);
        let leads = |from: &super::Road, to: &super::Road, index: RoadIndex| {
            [from.predecessor, from.successor].into_iter().flatten().any(|link| match link {
                RoadLink::Road(road, _) => road == index,
                RoadLink::Junction(junction) => to.junction == Some(junction),
            })
        };
        own.junction.is_some() && own.junction == other.junction || leads(own, other, b) || leads(other, own, a)
    }
}
