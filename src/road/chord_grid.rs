//! A grid over chords as seen from above; a look-up takes constant time.

use super::chord::Chord;
use super::chord_tree::ChordTree;
use crate::geometry::{Point, Vector};

/// The width of a grid's cell (m).
const CELL: f64 = 4.0;
/// Maximum number of cells of a grid; larger towns get wider cells.
const MAX_CELLS: f64 = 65_536.0;
/// Maximum number of candidate chords in all cells of a grid together.
const MAX_CANDIDATES: usize = 4_000_000;
/// How far beyond the lanes a grid reaches (m).
const BEYOND: f64 = 12.0;

/// The number of cells along each side of a block. The candidates of a block are found together.
const BLOCK: usize = 8;
/// The number of cells along each side of a part of a block; a block is a whole number of parts.
const PART: usize = 2;

/// How far a chord may be from the middle of a square and still be the nearest to some point in it.
/// `nearest` is the distance of the chord nearest to the middle; from any point of the square that chord is at most half a diagonal farther.
fn reach(nearest: f64, side: f64) -> f64 {
    nearest + side * std::f64::consts::SQRT_2 + 1e-6
}

/// For each square cell the chords that are nearest to some point in it, found with a tree beforehand.
///
/// A look-up then computes only a few distances. Points outside the grid are left to the tree.
pub(super) struct ChordGrid {
    origin: Point,
    cell: f64,
    columns: usize,
    rows: usize,
    /// For each cell the index of its first candidate, and one more entry at the end.
    starts: Vec<u32>,
    candidates: Vec<u32>,
}

impl ChordGrid {
    /// Indexes the chords of a tree.
    pub fn new(chords: &[Chord], tree: &ChordTree) -> Self {
        let mut grid =
            Self { origin: Point::origin(), cell: CELL, columns: 0, rows: 0, starts: vec![0], candidates: Vec::new() };
        if let Some((low, high)) = tree.around() {
            grid.fill(chords, tree, low, high - low + Vector::new(2.0 * BEYOND, 2.0 * BEYOND));
        }
        grid
    }

    fn fill(&mut self, chords: &[Chord], tree: &ChordTree, low: Point, size: Vector) {
        self.origin = low - Vector::new(BEYOND, BEYOND);
        self.cell = CELL.max((size.x * size.y / MAX_CELLS).sqrt()).max(size.max() / MAX_CELLS);
        self.columns = (size.x / self.cell).ceil() as usize;
        self.rows = (size.y / self.cell).ceil() as usize;
        let mut blocks = vec![Vec::new(); self.columns.div_ceil(BLOCK)];
        let mut parts = vec![Vec::new(); self.columns.div_ceil(PART)];
        let mut distances = Vec::new();
        for row in 0..self.rows {
            if row % BLOCK == 0 && !self.fill_blocks(tree, row, &mut blocks) {
                return self.give_up();
            }
            // A part of a block keeps few of the block's candidates, so most cells check only a few.
            if row % PART == 0 {
                for (part, column) in parts.iter_mut().zip((0..).step_by(PART)) {
                    part.clear();
                    self.sift(chords, &blocks[column / BLOCK], (column, row), PART, &mut distances, part);
                }
            }
            for column in 0..self.columns {
                let mut candidates = std::mem::take(&mut self.candidates);
                self.sift(chords, &parts[column / PART], (column, row), 1, &mut distances, &mut candidates);
                self.candidates = candidates;
                self.starts.push(self.candidates.len() as u32);
            }
            if self.candidates.len() > MAX_CANDIDATES {
                return self.give_up();
            }
        }
        self.candidates.shrink_to_fit();
    }

    /// Copies those candidates that may be nearest to a point in a square of cells, in order.
    fn sift(
        &self,
        chords: &[Chord],
        from: &[u32],
        (column, row): (usize, usize),
        cells: usize,
        distances: &mut Vec<f64>,
        into: &mut Vec<u32>,
    ) {
        let half = cells as f64 / 2.0;
        let middle = self.origin + Vector::new(column as f64 + half, row as f64 + half) * self.cell;
        distances.clear();
        distances.extend(from.iter().map(|index| chords[*index as usize].distance_squared(middle)));
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min).sqrt();
        let reach = reach(nearest, cells as f64 * self.cell);
        let near = from.iter().zip(&*distances).filter(|(_, distance)| **distance <= reach * reach);
        into.extend(near.map(|(index, _)| *index));
    }

    /// Finds the candidates of each block of cells, starting at a row. Candidates stay in order, so that of two chords equally near
    /// the first one wins. Returns whether there are few enough.
    fn fill_blocks(&self, tree: &ChordTree, row: usize, blocks: &mut [Vec<u32>]) -> bool {
        let (half, side) = (BLOCK as f64 / 2.0, BLOCK as f64 * self.cell);
        let mut count = 0;
        for (block, column) in blocks.iter_mut().zip((0..).step_by(BLOCK)) {
            let middle = self.origin + Vector::new(f64::from(column) + half, row as f64 + half) * self.cell;
            let reach = reach(tree.distance(middle).unwrap_or(0.0), side);
            block.clear();
            block.extend(tree.within(middle, reach));
            block.sort_unstable();
            count += block.len();
            if count > MAX_CANDIDATES {
                return false;
            }
        }
        true
    }

    /// Gives the grid up when a lane lies far away from the others; the tree then answers alone.
    fn give_up(&mut self) {
        (self.columns, self.rows, self.starts, self.candidates) = (0, 0, vec![0], Vec::new());
    }

    /// The nearest of the chords, by its place in the list; `None` beyond the grid.
    pub fn nearest(&self, chords: &[Chord], point: Point) -> Option<u32> {
        let place = (point - self.origin) / self.cell;
        if !(place.x >= 0.0 && place.y >= 0.0 && place.x < self.columns as f64 && place.y < self.rows as f64) {
            return None;
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
