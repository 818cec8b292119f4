use font8x8::legacy::BASIC_LEGACY;
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

use road::geometry::Point;

/// Red, green and blue.
pub(super) type Colour = [u8; 3];

/// Pixels of a dot of a letter, and dots of a letter from one to the next.
const DOT: usize = 2;
const LETTER: usize = 8;

/// A picture of pixels, with shapes in the metres of a town, north up. It has the same bytes on every machine: tiny-skia is built without the
/// instructions of one.
#[derive(Clone)]
pub(super) struct Canvas {
    pixels: Pixmap,
    /// The upper left corner (m).
    corner: Point,
    /// Pixels of a metre.
    scale: f64,
}

impl Canvas {
    /// A picture of one colour, whose upper left corner is at a place.
    pub fn new([width, height]: [usize; 2], corner: Point, scale: f64, [r, g, b]: Colour) -> Self {
        let mut pixels = Pixmap::new(width as u32, height as u32).expect("a picture has pixels");
        pixels.fill(Color::from_rgba8(r, g, b, u8::MAX));
        Self { pixels, corner, scale }
    }

    /// The colours of the pixels, row by row from the top.
    pub fn colours(&self) -> impl Iterator<Item = Colour> {
        self.pixels.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()])
    }

    /// The length of a pixel (m).
    pub fn pixel(&self) -> f64 {
        1.0 / self.scale
    }

    /// Fills polygons with a colour of an opacity; where they meet or overlap they are one shape.
    pub fn fill(&mut self, polygons: &[impl AsRef<[Point]>], colour: Colour, opacity: f32) {
        let mut path = PathBuilder::new();
        for polygon in polygons {
            let mut corners = self.places(polygon.as_ref());
            // All turn the same way, or overlaps would be holes.
            let next = corners.iter().cycle().skip(1);
            if corners.iter().zip(next).map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum::<f32>() < 0.0 {
                corners.reverse();
            }
            add(&mut path, &corners);
            path.close();
        }
        self.fill_path(path, &paint(colour, opacity));
    }

    /// Fills a circle (m).
    pub fn fill_circle(&mut self, centre: Point, radius: f64, colour: Colour) {
        let (x, y) = self.places(&[centre])[0];
        let mut path = PathBuilder::new();
        path.push_circle(x, y, (radius * self.scale) as f32);
        self.fill_path(path, &paint(colour, 1.0));
    }

    /// Draws lines of a width (px) with a colour of an opacity.
    pub fn draw(&mut self, lines: &[Vec<Point>], width: f32, colour: Colour, opacity: f32) {
        let mut path = PathBuilder::new();
        lines.iter().for_each(|line| add(&mut path, &self.places(line)));
        let stroke = Stroke { width, ..Stroke::default() };
        if let Some(path) = path.finish() {
            self.pixels.stroke_path(&path, &paint(colour, opacity), &stroke, Transform::identity(), None);
        }
    }

    /// Fills the rows above a height.
    pub fn fill_head(&mut self, height: usize, colour: Colour) {
        let mut path = PathBuilder::new();
        add_rectangle(&mut path, [0, 0], [self.pixels.width() as usize, height]);
        self.fill_path(path, &paint(colour, 1.0));
    }

    /// Writes a line of text at a place in pixels. A character outside of ASCII becomes a question mark; what does not fit is cut off.
    pub fn write(&mut self, text: &str, left: usize, top: usize, colour: Colour) {
        let mut path = PathBuilder::new();
        for (place, character) in text.chars().enumerate() {
            let glyph = BASIC_LEGACY.get(character as usize).unwrap_or(&BASIC_LEGACY[usize::from(b'?')]);
            for (row, dots) in glyph.iter().enumerate() {
                for column in (0..8).filter(|column| dots >> column & 1 == 1) {
                    let corner = [left + (place * LETTER + column) * DOT, top + row * DOT];
                    add_rectangle(&mut path, corner, [DOT; 2]);
                }
            }
        }
        self.fill_path(path, &paint(colour, 1.0));
    }

    fn fill_path(&mut self, path: PathBuilder, paint: &Paint) {
        if let Some(path) = path.finish() {
            self.pixels.fill_path(&path, paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    /// Where places are (px).
    fn places(&self, places: &[Point]) -> Vec<(f32, f32)> {
        let at =
            |place: &Point| [place.x - self.corner.x, self.corner.y - place.y].map(|far| (far * self.scale) as f32);
        places.iter().map(at).map(|[x, y]| (x, y)).collect()
    }
}

fn add(path: &mut PathBuilder, places: &[(f32, f32)]) {
    for (number, (x, y)) in places.iter().enumerate() {
        if number == 0 { path.move_to(*x, *y) } else { path.line_to(*x, *y) }
    }
}

fn add_rectangle(path: &mut PathBuilder, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
    let rectangle = Rect::from_xywh(x as f32, y as f32, width as f32, height as f32);
    path.push_rect(rectangle.expect("a rectangle has an area"));
}

fn paint([r, g, b]: Colour, opacity: f32) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (opacity * 255.0).round() as u8);
    paint
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Colour = [255; 3];
    const BLACK: Colour = [0; 3];

    fn rectangle(from: f64, to: f64) -> Vec<Point> {
        [(from, 0.0), (to, 0.0), (to, 1.0), (from, 1.0)].map(|(x, y)| Point::new(x, y)).to_vec()
    }

    #[test]
    fn shapes_that_meet_or_overlap_leave_no_seam_and_no_hole() {
        let mut canvas = Canvas::new([30, 10], Point::new(0.0, 1.0), 10.0, WHITE);
        let mut turned = rectangle(1.234, 3.0);
        turned.reverse();
        canvas.fill(&[rectangle(0.0, 1.234), turned, rectangle(2.0, 2.5)], BLACK, 1.0);
        assert!(canvas.colours().all(|pixel| pixel == BLACK));
    }

    #[test]
    fn a_text_is_cut_off_at_the_edge() {
        let mut canvas = Canvas::new([20, 10], Point::origin(), 1.0, WHITE);
        canvas.write("Ié", 0, 0, BLACK);
        assert!(canvas.colours().any(|pixel| pixel == BLACK));
        canvas.write("far", 1000, 1000, BLACK);
    }
}
