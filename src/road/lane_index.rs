//! The nearest lane, by its centre line.

use std::sync::OnceLock;

use rstar::primitives::{GeomWithData, Line};
use rstar::{PointDistance, RTree};

use super::lane_network::{LaneNetwork, LaneSlot, NetworkLane};
use super::{LaneKind, Road, Waypoint};
use crate::geometry::{Point, Vector};

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

/// A straight piece between two places on a lane's centre, seen from above.
#[derive(Debug, Clone, Copy)]
struct Chord {
    from: Point,
    along: Vector,
    length: f64,
    from_s: f64,
    to_s: f64,
    /// How high it begins, and how much it rises (m).
    height: f64,
    rise: f64,
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

    fn end(&self) -> Point {
        self.from + self.along * self.length
    }

    /// How far along the chord, rise and all, the place nearest to a point at a height is (m).
    fn project_in_space(&self, point: Point, height: f64) -> f64 {
        let whole = (self.length * self.length + self.rise * self.rise).sqrt();
        if whole == 0.0 {
            return 0.0;
        }
        let dot = (point - self.from).dot(&self.along) * self.length + (height - self.height) * self.rise;
        (dot / whole).clamp(0.0, whole)
    }

    /// The place so many metres along (CARLA counts metres along the chord as metres along the reference line).
    fn s(&self, moved: f64) -> f64 {
        if self.to_s >= self.from_s {
            (self.from_s + moved).min(self.to_s)
        } else {
            (self.from_s - moved).max(self.to_s)
        }
    }
}

type Leaf = GeomWithData<Line<[f64; 2]>, u32>;
type LeafInSpace = GeomWithData<Line<[f64; 3]>, u32>;

/// The chords of lane centres, with an index over those of each filter.
///
/// # Source
/// CARLA `road/Map.cpp`, `CreateRtree` and `GetClosestWaypointOnRoad`.
pub(super) struct LaneIndex {
    chords: Vec<Chord>,
    driving: OnceLock<ChordGrid>,
    sidewalk: OnceLock<ChordGrid>,
    any: OnceLock<ChordGrid>,
    /// Whether all chords lie at one height, so that height does not matter.
    level: bool,
    in_space: [OnceLock<RTree<LeafInSpace>>; 3],
}

impl LaneIndex {
    /// Indexes all lanes.
    pub fn new(roads: &[Road], network: &LaneNetwork) -> Self {
        let mut chords = Vec::new();
        for (lane, slot) in network.lanes().iter().zip(0..) {
            chords_of(roads, network, lane, |begin, end| {
                let whole = end.place - begin.place;
                let (length, rise) = (whole.norm(), end.height - begin.height);
                let (from, height) = (begin.place, begin.height);
                if [from.x, from.y, height, length, rise].iter().all(|number| number.is_finite()) {
                    let along = if length > 0.0 { whole / length } else { Vector::zeros() };
                    chords.push(Chord { from, along, length, from_s: begin.s, to_s: end.s, height, rise, slot });
                }
            });
        }
        chords.shrink_to_fit();
        let height = chords.first().map_or(0.0, |chord| chord.height);
        Self {
            level: chords.iter().all(|chord| chord.height == height && chord.rise == 0.0),
            chords,
            driving: OnceLock::new(),
            sidewalk: OnceLock::new(),
            any: OnceLock::new(),
            in_space: Default::default(),
        }
    }

    /// The chords of a filter, by their places in the list.
    fn admitted(&self, network: &LaneNetwork, filter: LaneFilter) -> impl Iterator<Item = (&Chord, u32)> {
        self.chords.iter().zip(0..).filter(move |(chord, _)| filter.admits(network.lane(chord.slot).kind))
    }

    /// The grid of a filter, made when it is asked for first.
    fn grid(&self, network: &LaneNetwork, filter: LaneFilter) -> &ChordGrid {
        let grid = match filter {
            LaneFilter::Driving => &self.driving,
            LaneFilter::Sidewalk => &self.sidewalk,
            LaneFilter::Any => &self.any,
        };
        grid.get_or_init(|| ChordGrid::new(&self.chords, self.admitted(network, filter).map(|(_, index)| index)))
    }

    /// The place on the nearest chord; none without lanes of that sort, or for a point that is not finite.
    pub fn nearest(&self, network: &LaneNetwork, point: Point, filter: LaneFilter) -> Option<Waypoint> {
        if !point.x.is_finite() || !point.y.is_finite() {
            return None;
        }
        let grid = self.grid(network, filter);
        let chord = &self.chords[grid.nearest(&self.chords, point)? as usize];
        Some(network.lane(chord.slot).waypoint(chord.s(chord.project(point))))
    }

    /// The place on the chord nearest in space; none without lanes of that sort, or for a place that is not finite.
    pub fn nearest_in_space(
        &self,
        network: &LaneNetwork,
        point: Point,
        height: f64,
        filter: LaneFilter,
    ) -> Option<Waypoint> {
        if self.level || !height.is_finite() {
            return self.nearest(network, point, filter).filter(|_| height.is_finite());
        }
        let tree = self.in_space[filter as usize].get_or_init(|| {
            let leaf = |(chord, index): (&Chord, u32)| {
                let end = chord.end();
                let ends = [[chord.from.x, chord.from.y, chord.height], [end.x, end.y, chord.height + chord.rise]];
                LeafInSpace::new(Line::new(ends[0], ends[1]), index)
            };
            RTree::bulk_load(self.admitted(network, filter).map(leaf).collect())
        });
        if !point.x.is_finite() || !point.y.is_finite() {
            return None;
        }
        let chord = &self.chords[tree.nearest_neighbor([point.x, point.y, height])?.data as usize];
        Some(network.lane(chord.slot).waypoint(chord.s(chord.project_in_space(point, height))))
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
            let to = chord.end();
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

/// A place on a lane's centre where a chord may end.
#[derive(Clone, Copy)]
struct ChordEnd {
    s: f64,
    place: Point,
    height: f64,
    forward: Vector,
    /// Sine and cosine of the pitch.
    steep: (f64, f64),
}

impl ChordEnd {
    /// The angle between the headings of two places (rad).
    fn turned(&self, other: &Self) -> f64 {
        let ((up, flat), (other_up, other_flat)) = (self.steep, other.steep);
        let (perp, dot) = (self.forward.perp(&other.forward), self.forward.dot(&other.forward));
        if up == 0.0 && other_up == 0.0 {
            return libm::atan2(perp.abs(), dot);
        }
        let aside = other.forward * (up * other_flat) - self.forward * (flat * other_up);
        let across = flat * other_flat * perp;
        libm::atan2((aside.norm_squared() + across * across).sqrt(), flat * other_flat * dot + up * other_up)
    }
}

/// Tells the chords of a lane, in driving direction. Pitch counts as a turn.
fn chords_of(roads: &[Road], network: &LaneNetwork, lane: &NetworkLane, mut tell: impl FnMut(&ChordEnd, &ChordEnd)) {
    let (first, last) = lane.driving_ends();
    let length = (last - first).abs() - MARGIN;
    if length <= MARGIN || length.is_nan() {
        return;
    }
    let sign = if lane.forward() { 1.0 } else { -1.0 };
    let level = roads[lane.road.0 as usize].plan_view.elevation().cubics().is_empty();
    let end_at = |along: f64| {
        let s = first + sign * along;
        let pose = network.pose(roads, lane, s);
        let (height, steep) = if level {
            (0.0, (0.0, 1.0))
        } else {
            (network.elevation(roads, lane, s), libm::sincos(network.pitch(roads, lane, s)))
        };
        ChordEnd { s, place: pose.position(), height, forward: pose.forward(), steep }
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
        if begin.turned(&end) > TURN || next - begun > LONGEST || next >= length {
            tell(&begin, &end);
            (begun, begin) = (next, end);
        }
        along = next;
    }
}
