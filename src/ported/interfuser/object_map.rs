use std::f64::consts::{FRAC_PI_2, PI};

use super::EgoVector;
use super::image::{Image, Rectangle};
use road::geometry::Pose;
use world::av::Actor;

/// Rows and columns of the map.
pub(super) const CELLS: usize = 20;
/// The units of the network's channels: existence (1), offset to the right and ahead (m), heading (π rad), half
/// length and half width (m), speed (m/s).
const SCALE: [f64; 7] = [1.0, 3.5, 3.5, 2.0, 3.5, 2.0, 8.0];
/// Actors with a smaller half length (m) are drawn larger, by this factor.
const ENLARGED: (f64, f64) = (1.5, 1.5);
/// White pixels that a cell of 25 needs: five in a hundred of its brightness.
const MIN_PIXELS: u32 = 2;
/// Actors nearer to the ego (m) count as the ego itself.
const ITSELF: f64 = 1.0;
/// Actors farther away (m) are ignored.
const FAR: f64 = 21.0 * std::f64::consts::SQRT_2;

/// Another road user on the ideal map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Metres to the right of the ego's middle.
    pub right: f64,
    /// Metres ahead of the ego's middle.
    pub forward: f64,
    /// Heading in half turns, in [0, 2): 0 to the right, 0.5 towards the ego, 1 to the left, 1.5 ahead.
    pub theta: f64,
    /// Half extents along and across the heading (m).
    pub half: [f64; 2],
    /// Speed (m/s).
    pub speed: f64,
}

impl Sighting {
    /// An actor in the frame of the ego.
    pub fn new(ego: &Pose, actor: &Actor) -> Self {
        let local = ego.to_local(actor.pose.position());
        let theta = ((-FRAC_PI_2 - (actor.pose.yaw - ego.yaw)) / PI).rem_euclid(2.0);
        Self {
            right: -local.y,
            forward: local.x,
            // The remainder of a tiny negative number rounds up to the whole turn.
            theta: if theta < 2.0 { theta } else { 0.0 },
            half: [actor.half.x, actor.half.y],
            speed: actor.speed(),
        }
    }

    fn distance_squared(&self, right: f64, forward: f64) -> f64 {
        let (aside, ahead) = (self.right - right, self.forward - forward);
        aside * aside + ahead * ahead
    }
}

/// A cell of the map, in physical units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    /// Its row, 0 to 19; row 0 is 17.5 m ahead.
    pub row: usize,
    /// Its column, 0 to 19; column 0 is 9.5 m to the left.
    pub col: usize,
    /// Probability that a road user is there, 0 to 1.
    pub existence: f64,
    /// Offset to the right of the cell's centre (m).
    pub dx: f64,
    /// Offset ahead of the cell's centre (m).
    pub dy: f64,
    /// Heading in half turns, as in [`Sighting::theta`].
    pub theta: f64,
    /// Half length (m).
    pub half_length: f64,
    /// Half width (m).
    pub half_width: f64,
    /// Speed (m/s).
    pub speed: f64,
}

/// Metres to the right and ahead of the ego of a cell's centre.
pub(super) fn centre(row: usize, col: usize) -> (f64, f64) {
    (col as f64 - 9.5, 17.5 - row as f64)
}

/// The network's output about others: 20 × 20 cells of a metre, 18 m ahead, 2 m behind, 10 m to each side.
///
/// Values are stored as the network's channels, since later pixels depend on their last bits.
#[derive(Debug, Clone)]
pub struct ObjectMap {
    channels: Box<[[f64; 7]; CELLS * CELLS]>,
    /// The cells that are not all zero, in row-major order.
    filled: Vec<usize>,
    others: Vec<Sighting>,
    image: Image,
}

impl Default for ObjectMap {
    fn default() -> Self {
        Self {
            channels: Box::new([[0.0; 7]; CELLS * CELLS]),
            filled: Vec::with_capacity(CELLS * CELLS),
            others: Vec::with_capacity(64),
            image: Image::default(),
        }
    }
}

impl ObjectMap {
    /// Empties it.
    pub fn clear(&mut self) {
        for index in self.filled.drain(..) {
            self.channels[index] = [0.0; 7];
        }
    }

    /// Sets a cell; its row and column are below 20.
    pub fn set(&mut self, cell: &Cell) {
        let values = [cell.existence, cell.dx, cell.dy, cell.theta, cell.half_length, cell.half_width, cell.speed];
        let index = cell.row * CELLS + cell.col;
        self.channels[index] = std::array::from_fn(|channel| values[channel] / SCALE[channel]);
        if let Err(place) = self.filled.binary_search(&index) {
            self.filled.insert(place, index);
        }
    }

    /// The cells that have been filled, in row-major order.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = Cell> {
        self.filled.iter().map(|&index| self.cell(index))
    }

    fn cell(&self, index: usize) -> Cell {
        let channels = &self.channels[index];
        let [existence, dx, dy, theta, half_length, half_width, speed] =
            std::array::from_fn(|channel| channels[channel] * SCALE[channel]);
        Cell { row: index / CELLS, col: index % CELLS, existence, dx, dy, theta, half_length, half_width, speed }
    }

    /// The existence of a cell in the search for peaks: lower in the two rows behind the ego, none outside.
    pub(super) fn existence(&self, row: isize, col: isize) -> f64 {
        let inside = 0..CELLS as isize;
        if !inside.contains(&row) || !inside.contains(&col) {
            return 0.0;
        }
        let existence = self.channels[row as usize * CELLS + col as usize][0];
        if row >= 18 { existence - 0.1 } else { existence }
    }

    /// Draws the map that the network is trained to give; returns the number of pixels that other road users fill in the drawing.
    ///
    /// # Source
    /// InterFuser `timm/data/{heatmap_utils,det_utils}.py`.
    pub fn perceive(&mut self, others: impl Iterator<Item = Sighting>) -> u32 {
        self.clear();
        self.image.clear();
        self.others.clear();
        let looked_at = ITSELF * ITSELF..FAR * FAR;
        self.others.extend(others.filter(|other| {
            let distance = other.distance_squared(0.0, 0.0);
            distance > looked_at.start && distance < looked_at.end
        }));
        for other in &self.others {
            let enlarged = if other.half[0] < ENLARGED.0 { ENLARGED.1 } else { 1.0 };
            let (sin, cos) = libm::sincos(other.theta * PI);
            let rectangle = Rectangle {
                centre: EgoVector::new(other.right, -other.forward),
                direction: EgoVector::new(cos, sin),
                half: EgoVector::new(other.half[0] * enlarged, other.half[1] * enlarged),
            };
            self.image.fill(&rectangle.corners());
        }
        let rows = self.image.crop_rows();
        for row in rows.start / 5..rows.end.div_ceil(5) {
            let lines: [u128; 5] = std::array::from_fn(|line| self.image.crop(row * 5 + line));
            let any = lines.iter().fold(0, |any, line| any | line);
            if any == 0 {
                continue;
            }
            for col in 0..CELLS {
                let block = 0b11111 << (5 * col);
                if any & block == 0 {
                    continue;
                }
                let pixels: u32 = lines.iter().map(|line| (line & block).count_ones()).sum();
                if pixels >= MIN_PIXELS {
                    self.fill_cell(row, col);
                }
            }
        }
        self.image.pixels()
    }

    /// Describes the road user nearest to the cell's centre.
    fn fill_cell(&mut self, row: usize, col: usize) {
        let (right, forward) = centre(row, col);
        let mut nearest: Option<(f64, &Sighting)> = None;
        for other in &self.others {
            let distance = other.distance_squared(right, forward);
            if nearest.is_none_or(|(least, _)| distance < least) {
                nearest = Some((distance, other));
            }
        }
        let Some((distance, other)) = nearest else { return };
        let cell = Cell {
            row,
            col,
            existence: (0.5 / distance.sqrt().max(0.5)).sqrt(),
            dx: other.right - right,
            dy: other.forward - forward,
            theta: other.theta,
            half_length: other.half[0],
            half_width: other.half[1],
            speed: other.speed,
        };
        self.set(&cell);
    }

    /// Clamps all channels to [0, 1], the range of the network.
    ///
    /// Negative offsets become 0: a road user in the left or rear half of a cell is reported on its middle line.
    pub fn clamp(&mut self) {
        for &index in &self.filled {
            for channel in &mut self.channels[index] {
                *channel = channel.clamp(0.0, 1.0);
            }
        }
    }
}
