use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::chord::Chord;
use super::lane_index::{LaneIndex, Lanes};
use super::lane_network::LaneNetwork;
use super::opendrive_error::OpenDriveWarning;
use super::{
    Crosswalk, GiveWaySign, Junction, JunctionIndex, LaneFilter, LaneId, LaneKind, LaneSection, LaneStretch, Place,
    Road, SpeedSign, TrafficLight, Waypoint,
};
use crate::geometry::{OrientedBox, Point, Pose, polygon};

/// The greatest distance between the samples of a lane for the bounds (m).
const BOUND_STEP: f64 = 10.0;

/// The parts of a town, before they are indexed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TownParts {
    pub name: String,
    pub roads: Vec<Road>,
    pub junctions: Vec<Junction>,
    /// Signs that set a speed limit.
    pub speed_signs: Vec<SpeedSign>,
    pub traffic_lights: Vec<TrafficLight>,
    /// Stop and yield signs, one for each lane that has one.
    pub give_way_signs: Vec<GiveWaySign>,
    pub crosswalks: Vec<Crosswalk>,
    /// Bus stops: where people wait.
    pub bus_stops: Vec<Point>,
    /// Buildings, walls, trees: everything that blocks pedestrians and sight.
    pub obstacles: Vec<OrientedBox>,
    /// What the reader of a file skipped or guessed.
    pub warnings: Vec<OpenDriveWarning>,
    /// The text of the map that the town was read from; `None` for a town that was designed.
    pub map: Option<Arc<str>>,
    /// The file of that map; `None` for a town that was designed, and for a text without a file.
    pub map_file: Option<MapFile>,
}

/// The file of a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapFile {
    pub path: PathBuf,
    /// BLAKE3 of its text in hexadecimal digits, as manifests have it.
    pub blake3: String,
}

/// A road network with everything that stands beside it, indexed for the look-ups of a simulation.
///
/// The parts are read-only; to change one, build a new town.
#[derive(Debug)]
pub struct Town {
    parts: TownParts,
    has_limits: bool,
    has_ends: bool,
    pub(super) has_levels: OnceLock<bool>,
    pub(super) network: LaneNetwork,
    pub(super) index: LaneIndex,
    driving_lanes: Vec<LaneStretch>,
    derived: Mutex<BTreeMap<TypeId, Arc<dyn Any + Send + Sync>>>,
}

impl Deref for Town {
    type Target = TownParts;

    fn deref(&self) -> &TownParts {
        &self.parts
    }
}

impl Town {
    /// Indexes the parts. Links that lead nowhere are ignored.
    pub fn new(parts: TownParts) -> Self {
        let network = LaneNetwork::new(&parts.roads, &parts.junctions);
        let driving = network.lanes().iter().filter(|lane| lane.kind == LaneKind::Driving && !lane.in_junction);
        let stretch = |lane: &super::lane_network::NetworkLane| LaneStretch {
            start: lane.waypoint(lane.driving_ends().0),
            length: (lane.end - lane.start).max(0.0),
        };
        let driving_lanes = driving.map(stretch).filter(|stretch| stretch.length > 0.0).collect();
        let has_ends =
            network.lanes().iter().any(|lane| lane.kind == LaneKind::Driving && network.next(lane).is_empty());
        let has_limits = parts.roads.iter().flat_map(|road| &road.sections).any(LaneSection::has_limits);
        Self {
            parts,
            has_limits,
            has_ends,
            has_levels: OnceLock::new(),
            network,
            index: LaneIndex::default(),
            driving_lanes,
            derived: Mutex::default(),
        }
    }

    /// The centre of the lane at a waypoint, heading along its driving direction.
    ///
    /// For a lane that does not exist it is the reference line, and the origin for a road that does not exist.
    pub fn pose(&self, waypoint: Waypoint) -> Pose {
        if let Some(slot) = self.network.slot(waypoint) {
            return self.network.pose(&self.roads, self.network.lane(slot), waypoint.s);
        }
        self.roads.get(waypoint.road.0 as usize).map_or_else(Pose::default, |road| road.plan_view.pose(waypoint.s))
    }

    /// The height of the road at a waypoint (m), for its whole width; 0 for a road that does not exist.
    pub fn elevation(&self, waypoint: Waypoint) -> f64 {
        self.roads.get(waypoint.road.0 as usize).map_or(0.0, |road| road.plan_view.elevation().value(waypoint.s))
    }

    pub fn add_crosswalks(&mut self, crosswalks: Vec<Crosswalk>) {
        self.parts.crosswalks.extend(crosswalks);
    }

    /// Whether a place lies on a crosswalk.
    pub fn is_on_crosswalk(&self, place: impl Into<Place>) -> bool {
        let place = place.into();
        let is_on = |walk: &Crosswalk| polygon::contains(walk, place.point) && self.is_on_level(place, walk.place());
        self.crosswalks.iter().any(is_on)
    }

    /// The edges of the lane at a waypoint: left and right of its centre along the reference line; `None` for a lane that does not exist.
    pub fn lane_edges(&self, waypoint: Waypoint) -> Option<[Point; 2]> {
        let lane = self.network.lane(self.network.slot(waypoint)?);
        Some(self.network.edges(&self.roads, lane, waypoint.s))
    }

    /// The width of the lane at a waypoint (m); 0 for a lane that does not exist.
    pub fn lane_width(&self, waypoint: Waypoint) -> f64 {
        self.network.slot(waypoint).map_or(0.0, |slot| self.network.width(self.network.lane(slot), waypoint.s))
    }

    /// Whether the map has speed limits of lanes or road types.
    pub fn has_limits(&self) -> bool {
        self.has_limits
    }

    /// The highest speed limit of its lanes and signs (m/s); `None` if it has none.
    pub fn highest_limit(&self) -> Option<f64> {
        let lanes = self.roads.iter().flat_map(|road| &road.sections).flat_map(|section| &section.lanes);
        let limits = lanes.flat_map(|lane| lane.limits.iter().filter_map(|(_, limit)| *limit));
        limits.chain(self.speed_signs.iter().map(|sign| sign.limit)).max_by(f64::total_cmp)
    }

    /// Whether a driving lane leads nowhere.
    pub fn has_ends(&self) -> bool {
        self.has_ends
    }

    /// The limit that the map gives the lane at a waypoint (m/s): its own, that of the road's type, or that of a sign on its road before it; none
    /// where the map does not say.
    pub fn limit(&self, waypoint: Waypoint) -> Option<f64> {
        if !self.has_limits {
            return None;
        }
        let section = self.roads.get(waypoint.road.0 as usize)?.sections.get(waypoint.section as usize)?;
        let begun = section.lane(waypoint.lane)?.limits.iter().rev().find(|(begin, _)| *begin <= waypoint.s);
        begun.and_then(|(_, limit)| *limit)
    }

    /// The use of the lane at a waypoint.
    pub fn lane_kind(&self, waypoint: Waypoint) -> LaneKind {
        self.network.slot(waypoint).map_or(LaneKind::None, |slot| self.network.lane(slot).kind)
    }

    /// The junction a waypoint lies in.
    pub fn junction(&self, waypoint: Waypoint) -> Option<JunctionIndex> {
        self.roads.get(waypoint.road.0 as usize)?.junction
    }

    /// Whether a waypoint lies in a junction.
    pub fn is_junction(&self, waypoint: Waypoint) -> bool {
        self.junction(waypoint).is_some()
    }

    /// The lane to the right in driving direction, at the same distance along the road.
    pub fn right_lane(&self, waypoint: Waypoint) -> Option<Waypoint> {
        if self.is_left_hand(waypoint) { self.inner(waypoint) } else { self.outer(waypoint) }
    }

    /// The lane to the left in driving direction, at the same distance along the road; beyond the middle it is the first
    /// lane of the other direction. With left-hand traffic that is so on the right.
    pub fn left_lane(&self, waypoint: Waypoint) -> Option<Waypoint> {
        if self.is_left_hand(waypoint) { self.outer(waypoint) } else { self.inner(waypoint) }
    }

    fn is_left_hand(&self, waypoint: Waypoint) -> bool {
        self.roads.get(waypoint.road.0 as usize).is_some_and(|road| road.left_hand)
    }

    /// The next lane away from the reference line.
    fn outer(&self, waypoint: Waypoint) -> Option<Waypoint> {
        self.beside(waypoint, waypoint.lane.checked_add(waypoint.lane.signum())?)
    }

    /// The next lane towards the reference line, and beyond it.
    fn inner(&self, waypoint: Waypoint) -> Option<Waypoint> {
        let lane = waypoint.lane;
        self.beside(waypoint, if lane.unsigned_abs() == 1 { -lane } else { lane - lane.signum() })
    }

    fn beside(&self, waypoint: Waypoint, lane: LaneId) -> Option<Waypoint> {
        self.network.slot_of(waypoint.road, waypoint.section, lane).map(|_| Waypoint { lane, ..waypoint })
    }

    /// The place on the lane whose centre line is nearest as seen from above, whatever the lanes' widths.
    ///
    /// # Source
    /// CARLA `road/Map.cpp`, `GetClosestWaypointOnRoad`, in the plane: the same answers where all roads are level.
    pub fn nearest_lane(&self, place: impl Into<Place>, filter: LaneFilter) -> Option<Waypoint> {
        let place = place.into();
        self.chord_at(place, filter).map(|chord| self.beside_chord(chord, place.point))
    }

    /// The place on the lane of a chord beside a point.
    pub(super) fn beside_chord(&self, chord: &Chord, point: Point) -> Waypoint {
        self.network.lane(chord.slot).waypoint(chord.s(chord.project(point)))
    }

    pub(super) fn lanes(&self) -> Lanes<'_> {
        Lanes { roads: &self.roads, network: &self.network }
    }

    /// Builds the fastest index for look-ups of nearest lanes. Without this call it is built during a look-up, after some thousand
    /// of them. The answers are the same.
    pub fn prepare(&self) {
        for filter in [LaneFilter::Driving, LaneFilter::Sidewalk, LaneFilter::Any] {
            self.index.prepare(self.lanes(), filter);
        }
    }

    /// An upper bound of the widths of all driving lanes (m).
    pub fn widest_driving_lane(&self) -> f64 {
        let driving = self.network.lanes().iter().filter(|lane| lane.kind == LaneKind::Driving);
        driving.map(|lane| lane.width.bound(lane.end)).fold(0.0, f64::max)
    }

    /// Where the lanes of all sections start in the direction of their reference lines, with their uses, road by road; without lane 0.
    pub fn lane_starts(&self) -> impl Iterator<Item = (Waypoint, LaneKind)> {
        self.network.lanes().iter().map(|lane| (lane.waypoint(lane.start), lane.kind))
    }

    /// All driving lanes of all sections outside junctions.
    pub fn driving_lanes(&self) -> &[LaneStretch] {
        &self.driving_lanes
    }

    /// The waypoint `distance` (m) along a stretch in driving direction, clamped to it.
    pub fn along(&self, stretch: &LaneStretch, distance: f64) -> Waypoint {
        self.moved(stretch.start, distance.clamp(0.0, stretch.length.max(0.0)))
    }

    /// The place this far (m) along the driving direction, on the same lane or beyond its end; negative distances are back.
    pub fn moved(&self, waypoint: Waypoint, distance: f64) -> Waypoint {
        let forward = self.roads.get(waypoint.road.0 as usize).is_none_or(|road| road.is_forward(waypoint.lane));
        Waypoint { s: waypoint.s + if forward { distance } else { -distance }, ..waypoint }
    }

    /// What is made of the town, on the first call for each type.
    pub fn derived<T: Any + Send + Sync>(&self, make: impl FnOnce(&Self) -> T) -> Arc<T> {
        let mut derived = self.derived.lock().unwrap_or_else(PoisonError::into_inner);
        let known = derived.entry(TypeId::of::<T>()).or_insert_with(|| Arc::new(make(self)));
        known.clone().downcast().expect("it is stored under its type")
    }

    /// Opposite corners of the smallest upright rectangle around all lanes and obstacles: the south-west one and the
    /// north-east one. Both are the origin in an empty town.
    pub fn bounds(&self) -> (Point, Point) {
        let edges = self.network.lanes().iter().flat_map(|lane| {
            let count = ((lane.end - lane.start) / BOUND_STEP).ceil().clamp(1.0, 4096.0);
            (0..=count as u32).flat_map(move |i| {
                let s = lane.start + (lane.end - lane.start) * f64::from(i) / count;
                self.network.edges(&self.roads, lane, s)
            })
        });
        let corners = self.obstacles.iter().flat_map(OrientedBox::corners);
        let places = edges.chain(corners).filter(|place| place.x.is_finite() && place.y.is_finite());
        let around = places.fold(None, |box_so_far: Option<(Point, Point)>, place| {
            Some(box_so_far.map_or((place, place), |(low, high)| (low.inf(&place), high.sup(&place))))
        });
        around.unwrap_or((Point::origin(), Point::origin()))
    }
}
