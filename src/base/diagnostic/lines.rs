use super::Span;

/// The starts of the lines of a text, to find lines and columns without counting from the top each time.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
    /// The number of characters and of UTF-16 units before each [`BLOCK`], so that a long line need not be counted as a whole.
    blocks: Vec<(usize, usize)>,
}

/// The maximum number of bytes that are counted again.
const BLOCK: usize = 1024;

impl<'a> Lines<'a> {
    /// Scans a text once.
    pub fn new(text: &'a str) -> Self {
        // A carriage return alone ends a line, too, in the protocol of editors.
        let bytes = text.as_bytes();
        let ends = |at: &usize| bytes[*at] == b'\n' || bytes[*at] == b'\r' && bytes.get(at + 1) != Some(&b'\n');
        let starts = std::iter::once(0).chain((0..bytes.len()).filter(ends).map(|at| at + 1)).collect();
        let (mut blocks, mut before) = (Vec::new(), (0, 0));
        for block in text.as_bytes().chunks(BLOCK) {
            blocks.push(before);
            let (characters, units) = count(block);
            before = (before.0 + characters, before.1 + units);
        }
        blocks.push(before);
        Self { text, starts, blocks }
    }

    /// The line of a byte, and the number of characters and of UTF-16 units in it before the byte; lines count from 0.
    fn before(&self, byte: usize) -> (usize, (usize, usize)) {
        let byte = self.floor(byte);
        let line = self.starts.partition_point(|start| *start <= byte) - 1;
        let (first, last) = (self.above(self.starts[line]), self.above(byte));
        (line, (last.0 - first.0, last.1 - first.1))
    }

    /// The number of characters and of UTF-16 units that start before a byte of the text.
    fn above(&self, byte: usize) -> (usize, usize) {
        let block = byte / BLOCK;
        let (characters, units) = count(&self.text.as_bytes()[block * BLOCK..byte]);
        (self.blocks[block].0 + characters, self.blocks[block].1 + units)
    }

    /// The nearest byte at or before this one that starts a character.
    fn floor(&self, byte: usize) -> usize {
        self.text.floor_char_boundary(byte)
    }

    /// Line and column of a byte, both from 1; the column counts characters.
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        let (line, (characters, _)) = self.before(byte);
        (line + 1, characters + 1)
    }

    /// Line and column of a byte, both from 0; the column counts UTF-16 units, as editors do.
    pub fn utf16(&self, byte: usize) -> (u32, u32) {
        let (line, (_, units)) = self.before(byte);
        (line as u32, units as u32)
    }

    /// The byte at a line and a UTF-16 column, both from 0; the nearest existing one if there is none.
    pub fn byte(&self, line: u32, column: u32) -> usize {
        let Some(start) = self.starts.get(line as usize).copied() else { return self.text.len() };
        let mut left = column as usize;
        let mut byte = start;
        for character in self.text[start..].chars() {
            if left < character.len_utf16() || matches!(character, '\n' | '\r') {
                break;
            }
            left -= character.len_utf16();
            byte += character.len_utf8();
        }
        byte
    }

    /// Line and column of both ends of a span, as [`Lines::line_column`].
    pub fn span(&self, span: Span) -> ((usize, usize), (usize, usize)) {
        (self.line_column(span.start), self.line_column(span.end))
    }
}

/// The number of characters and of UTF-16 units that start in some bytes of a text.
fn count(bytes: &[u8]) -> (usize, usize) {
    // A continuation byte starts no character; a character of four bytes takes two units.
    let characters = bytes.iter().filter(|byte| **byte & 0xc0 != 0x80).count();
    (characters, characters + bytes.iter().filter(|byte| **byte >= 0xf0).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_count_like_short_ones() {
        let text = "a🚗é\n".repeat(3) + &"xé🚗".repeat(2_000);
        let lines = Lines::new(&text);
        for (at, _) in text.char_indices().step_by(7).chain([(text.len(), ' ')]) {
            let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
            assert_eq!(lines.line_column(at).1, text[start..at].chars().count() + 1);
            assert_eq!(lines.utf16(at).1 as usize, text[start..at].encode_utf16().count());
        }
    }

    #[test]
    fn columns_count_characters_or_units_of_utf16() {
        let text = "a\n/* 🚗é */ x\r\nend";
        let lines = Lines::new(text);
        let x = text.find('x').unwrap();
        assert_eq!(lines.line_column(x), (2, 10));
        assert_eq!(lines.utf16(x), (1, 10));
        assert_eq!(lines.byte(1, 10), x);
        for (at, _) in text.char_indices().filter(|(_, c)| !matches!(c, '\n' | '\r')) {
            let (line, column) = lines.utf16(at);
            assert_eq!(lines.byte(line, column), at);
        }
        assert_eq!(lines.byte(1, 99), text.find('\r').unwrap(), "the line's end");
        assert_eq!(lines.byte(99, 0), text.len());
        // A carriage return alone ends a line; one before a line feed belongs to it.
        assert_eq!(Lines::new("a\rbc\r\nd").utf16(3), (1, 1));
        assert_eq!(Lines::new("a\rbc\r\nd").utf16(6), (2, 0));
        assert_eq!(lines.byte(1, 4), text.find('🚗').unwrap(), "the middle of a pair goes to its beginning");
    }
}
