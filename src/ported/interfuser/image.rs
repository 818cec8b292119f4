use super::EgoVector;

/// Width and height of an image (px): 18 m to each side of the ego.
const SIZE: i64 = 180;
/// Metres from the image's edge to the ego.
const REACH: f64 = 18.0;
/// Resolution (px/m).
const PIXELS_PER_METRE: f64 = 5.0;
/// The part that the planner uses: this number of rows from the top …
pub(super) const CROP_ROWS: usize = 100;
/// … and this number of columns …
const CROP_COLUMNS: u32 = 100;
/// … from this one on.
const CROP_LEFT: u32 = 40;
/// One in 16.16 fixed point.
const ONE: i64 = 1 << 16;

/// A rectangle in the renderer's form: the two directions need not have length 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub centre: EgoVector,
    /// Half extents are multiples of this vector and of its perpendicular.
    pub direction: EgoVector,
    /// Half extents along and across the direction.
    pub half: EgoVector,
}

/// Corners of a rectangle in pixels (x right, y down), in drawing order.
pub(super) type Corners = [(i64, i64); 4];

impl Rectangle {
    /// The corners, rounded half to even; the sums are in the renderer's order, since pixels depend on it.
    pub fn corners(&self) -> Corners {
        let along = self.half.x * self.direction;
        let across = self.half.y * EgoVector::new(-self.direction.y, self.direction.x);
        let pixel = |corner: EgoVector| {
            let scale = |value: f64| ((value + REACH) * PIXELS_PER_METRE).round_ties_even() as i64;
            (scale(corner.x), scale(corner.y))
        };
        let (front, back) = (self.centre + along, self.centre - along);
        [pixel(front + across), pixel(front - across), pixel(back - across), pixel(back + across)]
    }
}

/// Minimum and maximum pixel of a shape, inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Bounds {
    pub left: i64,
    pub right: i64,
    pub top: i64,
    pub bottom: i64,
}

impl Bounds {
    const NOTHING: Self = Self { left: i64::MAX, right: i64::MIN, top: i64::MAX, bottom: i64::MIN };

    /// The smallest bounds around corners.
    pub fn around(corners: &Corners) -> Self {
        corners.iter().fold(Self::NOTHING, |bounds, &(x, y)| Self {
            left: bounds.left.min(x),
            right: bounds.right.max(x),
            top: bounds.top.min(y),
            bottom: bounds.bottom.max(y),
        })
    }

    /// Whether two bounds have a pixel in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.left <= other.right && other.left <= self.right && self.top <= other.bottom && other.top <= self.bottom
    }

    fn join(&self, other: &Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }

    /// The rows of an image that it covers.
    fn rows(&self) -> std::ops::Range<usize> {
        self.top.clamp(0, SIZE) as usize..(self.bottom + 1).clamp(0, SIZE) as usize
    }
}

/// Whether a pixel lies in the part that the planner looks at.
pub(super) fn in_crop((x, y): (i64, i64)) -> bool {
    let columns = i64::from(CROP_LEFT)..i64::from(CROP_LEFT + CROP_COLUMNS);
    columns.contains(&x) && (0..CROP_ROWS as i64).contains(&y)
}

/// A black and white bird's-eye image around the ego, with the direction ahead at the top.
///
/// Filled rectangles are identical to those of OpenCV's `fillConvexPoly`, to the pixel: the union of four Bresenham edges and a
/// scan fill in fixed point, which differ by a pixel in some places.
///
/// # Source
/// OpenCV 4.8 `modules/imgproc/src/drawing.cpp`, as InterFuser's `render.py` uses it.
#[derive(Debug, Clone)]
pub(super) struct Image {
    rows: Box<[[u64; 3]; SIZE as usize]>,
    bounds: Bounds,
}

impl Default for Image {
    fn default() -> Self {
        Self { rows: Box::new([[0; 3]; SIZE as usize]), bounds: Bounds::NOTHING }
    }
}

impl Image {
    /// Makes it black.
    pub fn clear(&mut self) {
        for row in self.bounds.rows() {
            self.rows[row] = [0; 3];
        }
        self.bounds = Bounds::NOTHING;
    }

    /// Bounds of the white pixels.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The planner's part of a row below [`CROP_ROWS`], with the leftmost pixel in the lowest bit.
    pub fn crop(&self, row: usize) -> u128 {
        let [low, middle, high] = self.rows[row].map(u128::from);
        let shifted = (low >> CROP_LEFT) | (middle << (64 - CROP_LEFT)) | (high << (128 - CROP_LEFT));
        shifted & ((1 << CROP_COLUMNS) - 1)
    }

    /// The rows of the planner's part in which there may be white pixels.
    pub fn crop_rows(&self) -> std::ops::Range<usize> {
        let rows = self.bounds.rows();
        rows.start.min(CROP_ROWS)..rows.end.min(CROP_ROWS)
    }

    /// White pixels in the planner's part.
    pub fn crop_pixels(&self) -> u32 {
        self.crop_rows().map(|row| self.crop(row).count_ones()).sum()
    }

    /// The number of white pixels.
    pub fn pixels(&self) -> u32 {
        self.bounds.rows().flat_map(|row| self.rows[row]).map(u64::count_ones).sum()
    }

    /// Pixels of the planner's part that are white in both.
    pub fn common_crop_pixels(&self, other: &Self) -> u32 {
        let (ours, theirs) = (self.crop_rows(), other.crop_rows());
        let rows = ours.start.max(theirs.start)..ours.end.min(theirs.end);
        rows.map(|row| (self.crop(row) & other.crop(row)).count_ones()).sum()
    }

    /// Fills a quadrangle.
    pub fn fill(&mut self, corners: &Corners) {
        let bounds = Bounds::around(corners);
        if !bounds.meets(&Bounds { left: 0, right: SIZE - 1, top: 0, bottom: SIZE - 1 }) {
            return;
        }
        self.bounds = self.bounds.join(&bounds);
        for (index, &corner) in corners.iter().enumerate() {
            self.edge(corners[(index + 3) % 4], corner);
        }
        self.scan(corners, &bounds);
    }

    fn plot(&mut self, x: i64, y: i64) {
        self.rows[y as usize][(x >> 6) as usize] |= 1 << (x & 63);
    }

    /// Columns from left to right, both inclusive and clipped.
    fn span(&mut self, y: i64, left: i64, right: i64) {
        let (left, right) = (left.max(0), right.min(SIZE - 1));
        if left > right {
            return;
        }
        let row = &mut self.rows[y as usize];
        for (index, word) in row.iter_mut().enumerate() {
            let first = index as i64 * 64;
            let (from, to) = ((left - first).max(0), (right - first).min(63));
            if from <= to {
                *word |= (u64::MAX >> (63 - (to - from))) << from;
            }
        }
    }

    /// An edge, both ends included.
    fn edge(&mut self, from: (i64, i64), to: (i64, i64)) {
        let Some((from, to)) = clip(from, to) else { return };
        let (start, end) = if to.0 < from.0 { (to, from) } else { (from, to) };
        let (dx, dy) = (end.0 - start.0, (end.1 - start.1).abs());
        let down = if end.1 < start.1 { -1 } else { 1 };
        let steep = dy > dx;
        let (major, minor) = if steep { (dy, dx) } else { (dx, dy) };
        let (mut x, mut y) = start;
        let mut error = major - 2 * minor;
        for _ in 0..=major {
            self.plot(x, y);
            let aside = error < 0;
            error += if aside { 2 * major - 2 * minor } else { -2 * minor };
            if steep {
                y += down;
                x += i64::from(aside);
            } else {
                x += 1;
                y += if aside { down } else { 0 };
            }
        }
    }

    /// The inside, by two chains of edges from the topmost corner down.
    fn scan(&mut self, corners: &Corners, bounds: &Bounds) {
        let top = (1..4).fold(0, |top, index| if corners[index].1 < corners[top].1 { index } else { top });
        let mut left = Chain::new(top, 1, bounds.top);
        let mut right = Chain::new(top, 3, bounds.top);
        let mut edges = 4;
        for y in bounds.top..=bounds.bottom.min(SIZE - 1) {
            left.reach(y, corners, &mut edges);
            right.reach(y, corners, &mut edges);
            if y >= 0 {
                let (low, high) = if left.x > right.x { (right.x, left.x) } else { (left.x, right.x) };
                self.span(y, (low + ONE / 2) >> 16, (high + ONE / 2) >> 16);
            }
            left.x += left.slope;
            right.x += right.slope;
        }
    }
}

/// One side of a quadrangle on the scan downwards.
#[derive(Debug)]
struct Chain {
    corner: usize,
    step: usize,
    /// Row in which its edge ends.
    end: i64,
    x: i64,
    slope: i64,
}

impl Chain {
    fn new(corner: usize, step: usize, top: i64) -> Self {
        Self { corner, step, end: top, x: -ONE, slope: 0 }
    }

    /// Moves to the next edge that leads down when its edge has ended; `edges` is the number of edges that both chains have left.
    fn reach(&mut self, y: i64, corners: &Corners, edges: &mut u32) {
        if y < self.end {
            return;
        }
        let mut from = self.corner;
        while *edges > 0 {
            *edges -= 1;
            let to = (from + self.step) % 4;
            let (xs, xe, height) = (corners[from].0 * ONE, corners[to].0 * ONE, corners[to].1 - y);
            if height > 0 {
                self.end = corners[to].1;
                self.slope = ((xe - xs) * 2 + height) / (2 * height);
                self.x = xs;
                self.corner = to;
                return;
            }
            from = to;
        }
    }
}

/// Clips a segment to the image: the vertical limits for each end first, then the horizontal ones.
fn clip(from: (i64, i64), to: (i64, i64)) -> Option<((i64, i64), (i64, i64))> {
    const LAST: i64 = SIZE - 1;
    let side = |x: i64| i64::from(x < 0) + 2 * i64::from(x > LAST);
    let level = |y: i64| 4 * i64::from(y < 0) + 8 * i64::from(y > LAST);
    let ((mut x1, mut y1), (mut x2, mut y2)) = (from, to);
    let (mut code1, mut code2) = (side(x1) + level(y1), side(x2) + level(y2));
    if code1 & code2 == 0 && code1 | code2 != 0 {
        if code1 & 12 != 0 {
            let limit = if code1 < 8 { 0 } else { LAST };
            x1 += (limit - y1) * (x2 - x1) / (y2 - y1);
            y1 = limit;
            code1 = side(x1);
        }
        if code2 & 12 != 0 {
            let limit = if code2 < 8 { 0 } else { LAST };
            x2 += (limit - y2) * (x2 - x1) / (y2 - y1);
            y2 = limit;
            code2 = side(x2);
        }
        if code1 & code2 == 0 && code1 | code2 != 0 {
            if code1 != 0 {
                let limit = if code1 == 1 { 0 } else { LAST };
                y1 += (limit - x1) * (y2 - y1) / (x2 - x1);
                x1 = limit;
                code1 = 0;
            }
            if code2 != 0 {
                let limit = if code2 == 1 { 0 } else { LAST };
                y2 += (limit - x2) * (y2 - y1) / (x2 - x1);
                x2 = limit;
                code2 = 0;
            }
        }
    }
    (code1 | code2 == 0).then_some(((x1, y1), (x2, y2)))
}

#[cfg(test)]
mod tests;
