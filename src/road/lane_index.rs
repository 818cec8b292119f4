//! The nearest lane, by its centre line.

use std::sync::OnceLock;

use rstar::RTree;
use rstar::primitives::{GeomWithData, Line};

use super::chord::{Chord, chords};
use super::chord_grid::ChordGrid;
use super::lane_network::LaneNetwork;
use super::{LaneKind, Road, Waypoint};
use crate::geometry::Point;

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

type LeafInSpace = GeomWithData<Line<[f64; 3]>, u32>;

/// The chords of lane centres, with an index over those of each filter.
///
/// # Source
/// CARLA `road/Map.cpp`, `GetClosestWaypointOnRoad`.
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
        let chords = chords(roads, network);
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
        Some(self.place(network, grid.nearest(&self.chords, point)? as usize, point))
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
        Some(self.place(network, tree.nearest_neighbor([point.x, point.y, height])?.data as usize, point))
    }

    /// The place on a chord that was found to be the nearest: as in CARLA the nearest one as seen from above, even where the
    /// chord was chosen in space.
    fn place(&self, network: &LaneNetwork, index: usize, point: Point) -> Waypoint {
        let chord = &self.chords[index];
        network.lane(chord.slot).waypoint(chord.s(chord.project(point)))
    }
}

impl std::fmt::Debug for LaneIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LaneIndex({} chords)", self.chords.len())
    }
}
