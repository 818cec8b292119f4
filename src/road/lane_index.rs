//! The nearest lane, by its centre line.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use super::chord::{Chord, chords};
use super::chord_grid::ChordGrid;
use super::chord_tree::{ChordTree, first_nearest};
use super::lane_network::{LaneNetwork, LaneSlot};
use super::{LaneFilter, Road, Waypoint};
use crate::geometry::Point;

/// The number of look-ups after which a tree is built; earlier ones check all chords.
const WORTH_A_TREE: u32 = 50;
/// The number of look-ups after which a grid is built; a grid costs as much as some thousand look-ups in the tree.
const WORTH_A_GRID: u32 = 4000;

/// The chords of the lane centres of each filter, indexed.
///
/// Each index is built on demand: checking a scenario needs few look-ups, a driver needs some in every tick.
///
/// # Source
/// CARLA `road/Map.cpp`, `GetClosestWaypointOnRoad`.
#[derive(Default)]
pub(super) struct LaneIndex {
    filters: [Filtered; 3],
}

/// The indexes over the chords of one filter. All of them give the same answers.
#[derive(Default)]
struct Filtered {
    chords: OnceLock<Vec<Chord>>,
    tree: OnceLock<ChordTree>,
    grid: OnceLock<ChordGrid>,
    questions: AtomicU32,
}

#[derive(Clone, Copy)]
pub(super) struct Lanes<'a> {
    pub roads: &'a [Road],
    pub network: &'a LaneNetwork,
}

impl LaneIndex {
    pub fn chords(&self, lanes: Lanes, filter: LaneFilter) -> &[Chord] {
        self.filters[filter as usize].chords.get_or_init(|| chords(lanes.roads, lanes.network, filter))
    }

    pub fn tree(&self, lanes: Lanes, filter: LaneFilter) -> (&ChordTree, &[Chord]) {
        let chords = self.chords(lanes, filter);
        (self.filters[filter as usize].tree.get_or_init(|| ChordTree::new(chords)), chords)
    }

    /// Builds the grid of a filter, which answers fastest and allocates nothing.
    pub fn prepare(&self, lanes: Lanes, filter: LaneFilter) {
        let (tree, chords) = self.tree(lanes, filter);
        self.filters[filter as usize].grid.get_or_init(|| ChordGrid::new(chords, tree));
    }

    /// The place on the nearest chord; `None` without lanes of that kind, or for a point that is not finite.
    pub fn nearest(&self, lanes: Lanes, point: Point, filter: LaneFilter) -> Option<Waypoint> {
        self.nearest_chord(lanes, point, filter).map(|chord| place(chord, lanes, point))
    }

    /// The nearest chord, as [`LaneIndex::nearest`] finds it.
    pub fn nearest_chord(&self, lanes: Lanes, point: Point, filter: LaneFilter) -> Option<&Chord> {
        if !point.x.is_finite() || !point.y.is_finite() {
            return None;
        }
        let found = &self.filters[filter as usize];
        let chords = self.chords(lanes, filter);
        let index = match found.grid.get() {
            Some(grid) => grid.nearest(chords, point).or_else(|| self.tree(lanes, filter).0.nearest(chords, point))?,
            None => match found.questions.fetch_add(1, Ordering::Relaxed) {
                ..WORTH_A_TREE => first_nearest(chords, 0..chords.len() as u32, point)?,
                WORTH_A_TREE..WORTH_A_GRID => self.tree(lanes, filter).0.nearest(chords, point)?,
                WORTH_A_GRID.. => {
                    self.prepare(lanes, filter);
                    return self.nearest_chord(lanes, point, filter);
                }
            },
        };
        Some(&chords[index as usize])
    }

    /// The chords of one lane; empty where the filter does not admit it.
    pub fn chords_of(&self, lanes: Lanes, slot: LaneSlot, filter: LaneFilter) -> &[Chord] {
        let chords = self.chords(lanes, filter);
        // They are in the order of the lanes.
        let first = chords.partition_point(|chord| chord.slot < slot);
        let count = chords[first..].partition_point(|chord| chord.slot == slot);
        &chords[first..first + count]
    }
}

/// The place on the chord that was found to be nearest.
fn place(chord: &Chord, lanes: Lanes, point: Point) -> Waypoint {
    lanes.network.lane(chord.slot).waypoint(chord.s(chord.project(point)))
}

impl std::fmt::Debug for LaneIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let made = self.filters.iter().filter_map(|filtered| filtered.chords.get());
        write!(f, "LaneIndex({} chords)", made.map(Vec::len).sum::<usize>())
    }
}
