use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Names one of the [`Sources`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId(u32);

/// A range of bytes in a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The source it lies in.
    pub source: SourceId,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The smallest span that contains both; the other must be in the same source.
    pub fn to(self, other: Span) -> Span {
        Span { source: self.source, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// A text with the name it is shown under.
#[derive(Debug, Clone)]
pub struct Source {
    /// Its path, as the user wrote it; imports are relative to its folder.
    pub path: PathBuf,
    /// The whole text, without a byte order mark.
    pub text: Cow<'static, str>,
    /// Bytes of the file before the text: its byte order mark.
    pub mark: usize,
}

/// The mark at which some editors start files.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// All texts of one run of the front end.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    all: Vec<Source>,
}

impl Sources {
    pub fn add(&mut self, path: impl AsRef<Path>, text: impl Into<String>) -> SourceId {
        self.push(path.as_ref(), Cow::Owned(text.into()), 0)
    }

    /// Adds the text of a file, which may start with a byte order mark.
    pub fn add_file(&mut self, path: impl AsRef<Path>, mut text: String) -> SourceId {
        let mark = if text.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len_utf8() } else { 0 };
        text.drain(..mark);
        self.push(path.as_ref(), Cow::Owned(text), mark)
    }

    /// Adds a text that is part of the program.
    pub fn add_builtin(&mut self, path: impl AsRef<Path>, text: &'static str) -> SourceId {
        self.push(path.as_ref(), Cow::Borrowed(text), 0)
    }

    fn push(&mut self, path: &Path, text: Cow<'static, str>, mark: usize) -> SourceId {
        self.all.push(Source { path: path.to_path_buf(), text, mark });
        SourceId(self.all.len() as u32 - 1)
    }

    pub fn get(&self, id: SourceId) -> &Source {
        &self.all[id.0 as usize]
    }

    /// All sources, in the order they were added.
    pub fn iter(&self) -> impl Iterator<Item = (SourceId, &Source)> {
        self.all.iter().enumerate().map(|(index, source)| (SourceId(index as u32), source))
    }

    /// The text a span covers.
    pub fn text(&self, span: Span) -> &str {
        &self.get(span.source).text[span.start..span.end]
    }

    /// The text a span covers on one line, without comments.
    pub fn plain_text(&self, span: Span) -> String {
        let (mut plain, mut rest) = (String::new(), self.text(span));
        while let Some(first) = rest.chars().next() {
            let length = match first {
                '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
                '/' if rest.starts_with("//") => rest.find(['\n', '\r']).unwrap_or(rest.len()),
                '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
                _ => first.len_utf8(),
            };
            let blank = first.is_whitespace() || rest.starts_with("//") || rest.starts_with("/*");
            match blank {
                false => plain.push_str(&rest[..length]),
                true if plain.ends_with(' ') => {}
                true => plain.push(' '),
            }
            rest = &rest[length..];
        }
        plain.trim().to_string()
    }

    /// Line and column of a byte, both from 1; the column counts characters.
    pub fn line_column(&self, id: SourceId, byte: usize) -> (usize, usize) {
        let before = &self.get(id).text[..byte];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}
