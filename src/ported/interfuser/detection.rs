use super::object_map::{Cell, ObjectMap};

/// The class of a detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectClass {
    /// More than 4 m long.
    Car,
    /// More than half longer than wide.
    Bike,
    /// All others.
    Pedestrian,
}

impl ObjectClass {
    /// The class of a box.
    pub fn of(cell: &Cell) -> Self {
        if cell.half_length > 2.0 {
            Self::Car
        } else if cell.half_length / cell.half_width > 1.5 {
            Self::Bike
        } else {
            Self::Pedestrian
        }
    }
}

/// Existence above which a cell is a detection whatever its neighbours say.
const CERTAIN: f64 = 0.9;
/// Existence above which a cell is a detection if it exceeds its neighbours.
const LIKELY: f64 = 0.4;
/// The compared neighbours (row, column); the one above to the left is missing, as published.
const NEIGHBOURS: [(isize, isize); 7] = [(0, -1), (0, 1), (1, 1), (-1, 1), (1, -1), (-1, 0), (1, 0)];

/// Finds the cells that count as a road user, in row-major order.
///
/// Two certain cells are two detections of one person, and of two equal neighbours neither is a detection.
///
/// # Source
/// InterFuser `team_code/render.py`, `find_peak_box`.
pub fn find_detections(map: &ObjectMap, found: &mut Vec<Cell>) {
    found.clear();
    found.extend(map.cells().filter(|cell| {
        let (row, col) = (cell.row as isize, cell.col as isize);
        let here = map.existence(row, col);
        here > CERTAIN
            || (here > LIKELY && NEIGHBOURS.iter().all(|(down, right)| here > map.existence(row + down, col + right)))
    }));
}
