//! The nearest lane, by its centre line.

use std::sync::OnceLock;

use rstar::primitives::{GeomWithData, Line};
use rstar::{PointDistance, RTree};

use super::lane_network::{LaneNetwork, LaneSlot, NetworkLane};
use super::{LaneKind, Road, Waypoint};
use crate::geometry::{Point, Pose, Vector};

/// How far the heading turns before the next chord begins (rad).
const TURN: f64 = std::f64::consts::PI / 100.0;
/// The longest chord on a curved lane (m).
const LONGEST: f64 = 100.0;
/// The step in which a curved lane is searched for the end of a chord (m).
const STEP: f64 = 1.0;
/// What is left of a lane at its end, to stay on it (m).
const MARGIN: f64 = 1e-6;
/// An upper limit of steps a lane, for a file with absurd lengths.
const MAX_STEPS: f64 = 8192.0;

/// Which lanes are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LaneFilter {
    /// Those cars drive on.
    Driving,
    /// Those people walk on.
    Sidewalk,
    /// All but those of kind [`LaneKind::None`].
    Any,
}

impl LaneFilter {
    /// Whether lanes of a kind are looked at.
    pub fn admits(self, kind: LaneKind) -> bool {
        match self {
            Self::Driving => kind == LaneKind::Driving,
            Self::Sidewalk => kind == LaneKind::Sidewalk,
            Self::Any => kind != LaneKind::None,
        }
    }
}

/// A straight piece between two places on a lane's centre.
#[derive(Debug, Clone, Copy)]
struct Chord {
    from: Point,
    along: Vector,
    length: f64,
    from_s: f64,
    to_s: f64,
    slot: LaneSlot,
}

impl Chord {
    /// How far along the chord the place nearest to a point is (m).
    fn project(&self, point: Point) -> f64 {
        (point - self.from).dot(&self.along).clamp(0.0, self.length)
    }

    fn distance_squared(&self, point: Point) -> f64 {
        (self.from + self.along * self.project(point) - point).norm_squared()
    }
}

type Leaf = GeomWithData<Line<[f64; 2]>, u32>;

/// The chords of lane centres, with an index over those of each filter.
///
/// # Source
/// CARLA `road/Map.cpp`, `CreateRtree` and `GetClosestWaypointOnRoad`.
pub(super) struct LaneIndex {
    chords: Vec<Chord>,
    driving: OnceLock<ChordGrid>,
    sidewalk: OnceLock<ChordGrid>,
    any: OnceLock<ChordGrid>,
}

impl LaneIndex {
    /// Indexes all lanes.
    pub fn new(roads: &[Road], network: &LaneNetwork) -> Self {
        let mut chords = Vec::new();
        for (lane, slot) in network.lanes().iter().zip(0..) {
            chords_of(roads, network, lane, |from_s, to_s, from, to| {
                let (from, whole) = (from.position(), to.position() - from.position());
                let length = whole.norm();
                if from.x.is_finite() && from.y.is_finite() && length.is_finite() {
                    let along = if length > 0.0 { whole / length } else { Vector::zeros() };
                    chords.push(Chord { from, along, length, from_s, to_s, slot });
                }
            });
        }
        Self { chords, driving: OnceLock::new(), sidewalk: OnceLock::new(), any: OnceLock::new() }
    }

    /// The grid of a filter, made when it is asked for first.
    fn grid(&self, network: &LaneNetwork, filter: LaneFilter) -> &ChordGrid {
        let grid = match filter {
            LaneFilter::Driving => &self.driving,
            LaneFilter::Sidewalk => &self.sidewalk,
            LaneFilter::Any => &self.any,
        };
        grid.get_or_init(|| {
            let admitted =
                self.chords.iter().zip(0..).filter(|(chord, _)| filter.admits(network.lane(chord.slot).kind));
            ChordGrid::new(&self.chords, admitted.map(|(_, index)| index))
        })
    }

    /// The place on the nearest chord; none without lanes of that sort, or for a point that is not finite.
    pub fn nearest(&self, network: &LaneNetwork, point: Point, filter: LaneFilter) -> Option<Waypoint> {
        if !point.x.is_finite() || !point.y.is_finite() {
            return None;
        }
        let grid = self.grid(network, filter);
        let chord = &self.chords[grid.nearest(&self.chords, point)? as usize];
        // Metres along the chord count as metres along the reference line, as CARLA does it.
        let moved = chord.project(point);
        let s = if chord.to_s >= chord.from_s {
            (chord.from_s + moved).min(chord.to_s)
        } else {
            (chord.from_s - moved).max(chord.to_s)
        };
        Some(network.lane(chord.slot).waypoint(s))
    }
}

/// The width of a grid's cell (m).
const CELL: f64 = 4.0;
/// How many cells a grid has at most; larger towns get wider cells.
const MOST_CELLS: f64 = 65_536.0;
/// How many chords all cells of a grid have together at most.
const MOST_CANDIDATES: usize = 4_000_000;
/// How far beyond the lanes a grid reaches (m).
const BEYOND: f64 = 12.0;

/// For each square cell the chords that are nearest to some point in it, found with an R-tree beforehand.
///
/// A question then costs a handful of distances. Points beyond the grid are left to the tree.
struct ChordGrid {
    origin: Point,
    cell: f64,
    columns: usize,
    rows: usize,
    /// For each cell the place of its first candidate, and one more entry at the end.
    starts: Vec<u32>,
    candidates: Vec<u32>,
    tree: RTree<Leaf>,
}

impl ChordGrid {
    fn new(chords: &[Chord], admitted: impl Iterator<Item = u32>) -> Self {
        let leaf = |index: u32| {
            let chord = &chords[index as usize];
            let to = chord.from + chord.along * chord.length;
            Leaf::new(Line::new([chord.from.x, chord.from.y], [to.x, to.y]), index)
        };
        let leaves: Vec<Leaf> = admitted.map(leaf).collect();
        let ends = leaves.iter().flat_map(|leaf| [leaf.geom().from, leaf.geom().to]).map(Point::from);
        let around = ends.fold(None, |so_far: Option<(Point, Point)>, end| {
            Some(so_far.map_or((end, end), |(low, high)| (low.inf(&end), high.sup(&end))))
        });
        let tree = RTree::bulk_load(leaves);
        let mut grid = Self {
            origin: Point::origin(),
            cell: CELL,
            columns: 0,
            rows: 0,
            starts: vec![0],
            candidates: Vec::new(),
            tree,
        };
        if let Some((low, high)) = around {
            grid.fill(low, high - low + Vector::new(2.0 * BEYOND, 2.0 * BEYOND));
        }
        grid
    }

    fn fill(&mut self, low: Point, size: Vector) {
        self.origin = low - Vector::new(BEYOND, BEYOND);
        self.cell = CELL.max((size.x * size.y / MOST_CELLS).sqrt()).max(size.max() / MOST_CELLS);
        self.columns = (size.x / self.cell).ceil() as usize;
        self.rows = (size.y / self.cell).ceil() as usize;
        let half_diagonal = self.cell * std::f64::consts::FRAC_1_SQRT_2;
        for index in 0..self.columns * self.rows {
            let (row, column) = (index / self.columns, index % self.columns);
            let middle =
                [(column, self.origin.x), (row, self.origin.y)].map(|(n, start)| start + (n as f64 + 0.5) * self.cell);
            // From anywhere in the cell the nearest chord is at most half a diagonal farther than from its middle.
            let nearest = self.tree.nearest_neighbor(middle).map_or(0.0, |leaf| leaf.distance_2(&middle).sqrt());
            let reach = nearest + 2.0 * half_diagonal + 1e-6;
            let begin = self.candidates.len();
            self.candidates.extend(self.tree.locate_within_distance(middle, reach * reach).map(|leaf| leaf.data));
            // In order, so that of two chords equally near the first one wins.
            self.candidates[begin..].sort_unstable();
            self.starts.push(self.candidates.len() as u32);
            if self.candidates.len() > MOST_CANDIDATES {
                // Some lane is lost far away from the others; the tree alone answers then.
                (self.columns, self.rows, self.starts, self.candidates) = (0, 0, vec![0], Vec::new());
                return;
            }
        }
    }

    fn nearest(&self, chords: &[Chord], point: Point) -> Option<u32> {
        let place = (point - self.origin) / self.cell;
        if !(place.x >= 0.0 && place.y >= 0.0 && place.x < self.columns as f64 && place.y < self.rows as f64) {
            return self.tree.nearest_neighbor([point.x, point.y]).map(|leaf| leaf.data);
        }
        let index = place.y as usize * self.columns + place.x as usize;
        let (mut best, mut nearest) = (None, f64::INFINITY);
        for candidate in &self.candidates[self.starts[index] as usize..self.starts[index + 1] as usize] {
            let distance = chords[*candidate as usize].distance_squared(point);
            if distance < nearest {
                (best, nearest) = (Some(*candidate), distance);
            }
        }
        best
    }
}

impl std::fmt::Debug for LaneIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LaneIndex({} chords)", self.chords.len())
    }
}

/// Tells the chords of a lane, in driving direction.
fn chords_of(roads: &[Road], network: &LaneNetwork, lane: &NetworkLane, mut tell: impl FnMut(f64, f64, Pose, Pose)) {
    let (first, last) = lane.driving_ends();
    let length = (last - first).abs() - MARGIN;
    if length <= MARGIN || length.is_nan() {
        return;
    }
    let sign = if lane.forward() { 1.0 } else { -1.0 };
    let pose = |along: f64| network.pose(roads, lane, first + sign * along);
    if lane.straight {
        tell(first, first + sign * length, pose(0.0), pose(length));
        return;
    }
    let step = STEP.max(length / MAX_STEPS);
    let (mut from, mut from_pose, mut along) = (0.0, pose(0.0), 0.0);
    let mut from_direction = from_pose.forward();
    while along < length {
        let next = (along + step).min(length);
        let next_pose = pose(next);
        let next_direction = next_pose.forward();
        let turned = libm::atan2(from_direction.perp(&next_direction), from_direction.dot(&next_direction)).abs();
        if turned > TURN || next - from > LONGEST || next >= length {
            tell(first + sign * from, first + sign * next, from_pose, next_pose);
            (from, from_pose, from_direction) = (next, next_pose, next_direction);
        }
        along = next;
    }
}
