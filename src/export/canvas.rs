use font8x8::legacy::BASIC_LEGACY;

use world::geometry::{Point, Vector};

/// Red, green and blue.
pub(super) type Colour = [u8; 3];

/// Scan lines of a row of pixels.
const LINES: u32 = 4;
/// Pixels of a dot of a letter, and dots of a letter from one to the next.
const DOT: usize = 2;
const LETTER: usize = 8;

/// A picture of pixels, with shapes in the metres of a town, north up.
///
/// All arithmetic is in double precision without functions that differ between machines, so a picture has the same bytes on each of them.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    /// Row by row from the top.
    pub pixels: Vec<Colour>,
    /// The upper left corner (m).
    corner: Point,
    /// Pixels of a metre.
    scale: f64,
}

/// The share of each pixel that shapes cover. Shapes that abut leave no seam.
#[derive(Debug, Clone)]
pub(super) struct Mask(Vec<f32>);

impl Canvas {
    /// A picture of one colour, whose upper left corner is at a place.
    pub fn new([width, height]: [usize; 2], corner: Point, scale: f64, colour: Colour) -> Self {
        Self { width, height, pixels: vec![colour; width * height], corner, scale }
    }

    /// The length of a pixel (m).
    pub fn pixel(&self) -> f64 {
        1.0 / self.scale
    }

    /// A mask without shapes.
    pub fn mask(&self) -> Mask {
        Mask(vec![0.0; self.width * self.height])
    }

    /// Adds a polygon to a mask; where it crosses itself, the even-odd rule decides.
    pub fn add_polygon(&self, mask: &mut Mask, corners: &[Point]) {
        let corners: Vec<Point> = corners
            .iter()
            .map(|place| Point::new((place.x - self.corner.x) * self.scale, (self.corner.y - place.y) * self.scale))
            .collect();
        let top = corners.iter().fold(f64::MAX, |least, corner| least.min(corner.y)).max(0.0);
        let bottom = corners.iter().fold(f64::MIN, |most, corner| most.max(corner.y)).min(self.height as f64);
        let mut crossings = Vec::new();
        for row in top as usize..bottom.max(0.0).ceil() as usize {
            for line in 0..LINES {
                let y = row as f64 + (f64::from(line) + 0.5) / f64::from(LINES);
                crossings.clear();
                for (index, a) in corners.iter().enumerate() {
                    let b = corners[(index + 1) % corners.len()];
                    if (a.y <= y) != (b.y <= y) {
                        crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
                    }
                }
                crossings.sort_by(f64::total_cmp);
                for span in crossings.chunks_exact(2) {
                    self.add_span(&mut mask.0[row * self.width..(row + 1) * self.width], span[0], span[1]);
                }
            }
        }
    }

    /// Adds a scan line from one abscissa to another to a row of a mask.
    fn add_span(&self, row: &mut [f32], from: f64, to: f64) {
        let (from, to) = (from.max(0.0), to.min(self.width as f64));
        if from >= to {
            return;
        }
        let share = 1.0 / LINES as f32;
        for (pixel, own) in row.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
            let covered = to.min(pixel as f64 + 1.0) - from.max(pixel as f64);
            *own += share * covered as f32;
        }
    }

    /// Adds a line of a width (m) to a mask.
    pub fn add_line(&self, mask: &mut Mask, points: &[Point], width: f64) {
        for pair in points.windows(2) {
            let Some(along) = (pair[1] - pair[0]).try_normalize(1e-9) else { continue };
            let across = Vector::new(-along.y, along.x) * (width / 2.0);
            self.add_polygon(mask, &[pair[0] + across, pair[1] + across, pair[1] - across, pair[0] - across]);
        }
    }

    /// Lays a colour over the pixels by their share in a mask, times an opacity.
    pub fn lay(&mut self, mask: &Mask, colour: Colour, opacity: f32) {
        for (pixel, share) in self.pixels.iter_mut().zip(&mask.0).filter(|(_, share)| **share > 0.0) {
            let share = share.min(1.0) * opacity;
            for (own, over) in pixel.iter_mut().zip(colour) {
                *own = (f32::from(*own) + (f32::from(over) - f32::from(*own)) * share).round() as u8;
            }
        }
    }

    /// Fills a polygon.
    pub fn fill(&mut self, corners: &[Point], colour: Colour) {
        let mut mask = self.mask();
        self.add_polygon(&mut mask, corners);
        self.lay(&mask, colour, 1.0);
    }

    /// Writes a line of text at a place in pixels. A character outside of ASCII becomes a question mark; what does not fit is cut off.
    pub fn write(&mut self, text: &str, left: usize, top: usize, colour: Colour) {
        for (place, character) in text.chars().enumerate() {
            let glyph = BASIC_LEGACY.get(character as usize).unwrap_or(&BASIC_LEGACY[usize::from(b'?')]);
            for (row, dots) in glyph.iter().enumerate() {
                for column in (0..8).filter(|column| dots >> column & 1 == 1) {
                    let (x, y) = (left + (place * LETTER + column) * DOT, top + row * DOT);
                    for at in (y..y + DOT).flat_map(|y| (x..x + DOT).map(move |x| (x, y))) {
                        if at.0 < self.width && at.1 < self.height {
                            self.pixels[at.1 * self.width + at.0] = colour;
                        }
                    }
                }
            }
        }
    }
}

/// The corners of a circle as a polygon.
pub(super) fn circle(centre: Point, radius: f64) -> Vec<Point> {
    let corner = |number: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(number) / 24.0);
        centre + Vector::new(cos, sin) * radius
    };
    (0..24).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Colour = [255; 3];
    const BLACK: Colour = [0; 3];

    fn covered(mask: &Mask) -> f32 {
        mask.0.iter().sum()
    }

    #[test]
    fn a_polygon_covers_its_area() {
        // Ten pixels a metre, so a square metre has 100 pixels.
        let canvas = Canvas::new([60, 40], Point::new(0.0, 4.0), 10.0, WHITE);
        let square = [(1.03, 1.0), (2.03, 1.0), (2.03, 2.0), (1.03, 2.0)].map(|(x, y)| Point::new(x, y));
        let mut mask = canvas.mask();
        canvas.add_polygon(&mut mask, &square);
        assert!((covered(&mask) - 100.0).abs() < 0.01, "{}", covered(&mask));
        // The row of y = 1.95 m is the 21st from the top; its first pixel is covered by 0.7.
        assert!((mask.0[20 * 60 + 10] - 0.7).abs() < 1e-4);
        let mut mask = canvas.mask();
        canvas.add_polygon(&mut mask, &circle(Point::new(3.0, 2.0), 1.0));
        assert!((covered(&mask) - 310.6).abs() < 1.5, "{}", covered(&mask));
        // Only a quarter is in the picture.
        let mut mask = canvas.mask();
        canvas.add_polygon(&mut mask, &circle(Point::new(0.0, 0.0), 1.0));
        assert!((covered(&mask) - 77.6).abs() < 1.0, "{}", covered(&mask));
    }

    #[test]
    fn shapes_that_abut_leave_no_seam() {
        let mut canvas = Canvas::new([30, 10], Point::new(0.0, 1.0), 10.0, WHITE);
        let mut mask = canvas.mask();
        for (from, to) in [(0.0, 1.234), (1.234, 3.0)] {
            let corners = [(from, 0.0), (to, 0.0), (to, 1.0), (from, 1.0)].map(|(x, y)| Point::new(x, y));
            canvas.add_polygon(&mut mask, &corners);
        }
        canvas.lay(&mask, BLACK, 1.0);
        assert!(canvas.pixels.iter().all(|pixel| *pixel == BLACK));
    }

    #[test]
    fn a_text_is_cut_off_at_the_edge() {
        let mut canvas = Canvas::new([20, 10], Point::origin(), 1.0, WHITE);
        canvas.write("Ié", 0, 0, BLACK);
        assert!(canvas.pixels.contains(&BLACK));
        canvas.write("far", 1000, 1000, BLACK);
    }
}
