//! GIF: a film that plays in slides, chats and browsers.
//!
//! # Source
//! GIF89a; the loop is the application extension NETSCAPE 2.0.

use std::io;

use ::gif::{Encoder, Frame, Repeat};

use super::ExportError;
use super::canvas::Colour;
use super::film::{COLOURS, Film, SIZE};
use super::format::{ExportFile, Exporter};

const NAME: &str = "gif";
/// Steps from one colour to another in the palette.
const STEPS: u16 = 4;
/// Bits of a channel by which the nearest colour of the palette is looked up.
const BITS: u32 = 5;

pub(super) const GIF: Exporter = Exporter {
    name: NAME,
    about: "an animated picture from above, for slides and chats",
    approximates: "the last 12 s; a small pedestrian is drawn with a radius of 5 pixels",
    files: |episode, _| {
        let bytes = encode(&Film::new(episode))
            .map_err(|error| ExportError::Encoding { format: NAME, source: io::Error::other(error) })?;
        Ok(vec![ExportFile { name: format!("{}.gif", episode.stem()), bytes }])
    },
    ..Exporter::RECORDED
};

fn encode(film: &Film) -> Result<Vec<u8>, ::gif::EncodingError> {
    let mut palette = Palette::new();
    let [width, height] = SIZE;
    let mut encoder = Encoder::new(Vec::new(), width as u16, height as u16, &palette.colours.concat())?;
    encoder.set_repeat(Repeat::Infinite)?;
    // The index behind the colours.
    let transparent = palette.colours.len() as u8;
    let mut before: Vec<u8> = Vec::new();
    for number in 0..film.len() {
        let indices: Vec<u8> = film.frame(number).colours().map(|pixel| palette.nearest(pixel)).collect();
        let [left, top, right, bottom] = changed(&before, &indices);
        let rows = (top..bottom).flat_map(|row| row * width + left..row * width + right);
        // Pixels that remain are transparent: runs of one index are short.
        let remains = |place: usize| before.get(place) == Some(&indices[place]);
        let buffer: Vec<u8> = rows.map(|place| if remains(place) { transparent } else { indices[place] }).collect();
        // Hundredths of a second; rounding does not add up.
        let clock = |frame: usize| (film.time(frame) * 100.0).round() as u16;
        encoder.write_frame(&Frame {
            delay: clock(number + 1) - clock(number),
            left: left as u16,
            top: top as u16,
            width: (right - left) as u16,
            height: (bottom - top) as u16,
            buffer: buffer.into(),
            transparent: Some(transparent),
            ..Frame::default()
        })?;
        before = indices;
    }
    encoder.into_inner()
}

/// The rectangle in which two pictures differ: left, top, and right and bottom behind it. It has a pixel at least.
fn changed(before: &[u8], now: &[u8]) -> [usize; 4] {
    let [width, height] = SIZE;
    if before.is_empty() {
        return [0, 0, width, height];
    }
    let mut found = [width, height, 0, 0];
    for place in (0..now.len()).filter(|place| before[*place] != now[*place]) {
        let (x, y) = (place % width, place / width);
        found = [found[0].min(x), found[1].min(y), found[2].max(x + 1), found[3].max(y + 1)];
    }
    if found[2] == 0 { [0, 0, 1, 1] } else { found }
}

/// The colours of a film, and mixtures of any two of them.
struct Palette {
    colours: Vec<Colour>,
    /// The nearest one to each colour, as far as it is known.
    known: Vec<Option<u8>>,
}

impl Palette {
    fn new() -> Self {
        let mut colours = COLOURS.to_vec();
        for (place, a) in COLOURS.iter().enumerate() {
            for b in &COLOURS[place + 1..] {
                for step in 1..STEPS {
                    colours.push(std::array::from_fn(|part| {
                        ((u16::from(a[part]) * (STEPS - step) + u16::from(b[part]) * step) / STEPS) as u8
                    }));
                }
            }
        }
        Self { colours, known: vec![None; 1 << (3 * BITS)] }
    }

    fn nearest(&mut self, colour: Colour) -> u8 {
        let key = colour.iter().fold(0, |key, part| key << BITS | usize::from(part >> (8 - BITS)));
        let colours = &self.colours;
        *self.known[key].get_or_insert_with(|| {
            // The middle of the colours with these bits, whichever of them comes first.
            let middle = |part: u8| i32::from(part >> (8 - BITS) << (8 - BITS)) + (1 << (7 - BITS));
            let far =
                |own: &Colour| -> i32 { own.iter().zip(colour).map(|(a, b)| (i32::from(*a) - middle(b)).pow(2)).sum() };
            let found = (0..colours.len()).min_by_key(|place| far(&colours[*place]));
            found.map_or(0, |place| place as u8)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_palette_fits_and_knows_its_colours() {
        let mut palette = Palette::new();
        assert!(palette.colours.len() < 256, "{}", palette.colours.len());
        for colour in COLOURS {
            let nearest = palette.nearest(colour);
            let own = palette.colours[usize::from(nearest)];
            assert!(own.iter().zip(colour).all(|(a, b)| a.abs_diff(b) <= 8), "{own:?} {colour:?}");
        }
    }

    #[test]
    fn pictures_that_are_equal_change_one_pixel_at_most() {
        let [width, height] = SIZE;
        let mut picture = vec![0; width * height];
        assert_eq!(changed(&[], &picture), [0, 0, width, height]);
        assert_eq!(changed(&picture.clone(), &picture), [0, 0, 1, 1]);
        let before = picture.clone();
        picture[3 * width + 7] = 1;
        picture[5 * width + 4] = 1;
        assert_eq!(changed(&before, &picture), [4, 3, 8, 6]);
    }
}
