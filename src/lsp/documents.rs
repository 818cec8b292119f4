//! Open buffers, and files beside them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use lsp_types::{Position, Range, Uri};

use crate::diagnostic::{self, Lines, Span};

/// The buffers an editor has open; they go before what is on disk.
#[derive(Debug, Default)]
pub struct Documents {
    open: BTreeMap<PathBuf, Document>,
}

/// An open buffer.
#[derive(Debug)]
pub struct Document {
    /// The name the editor has for it.
    pub uri: Uri,
    /// Its text.
    pub text: String,
}

impl Documents {
    /// Takes over a buffer's text.
    pub fn set(&mut self, uri: Uri, text: String) {
        self.open.insert(path(&uri), Document { uri, text });
    }

    /// Forgets a buffer.
    pub fn close(&mut self, uri: &Uri) {
        self.open.remove(&path(uri));
    }

    /// The text of an open buffer.
    pub fn text(&self, uri: &Uri) -> Option<&str> {
        self.open.get(&path(uri)).map(|document| document.text.as_str())
    }

    /// All paths with a buffer.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.open.keys().cloned().collect()
    }

    /// Reads a buffer, or else a file.
    ///
    /// # Errors
    /// As the file system says.
    pub fn read(&self, path: &Path) -> std::io::Result<String> {
        match self.open.get(&plain(path)) {
            Some(document) => Ok(document.text.clone()),
            None => std::fs::read_to_string(path),
        }
    }

    /// The editor's name for a path; none for what is no file of the user's.
    pub fn uri(&self, path: &Path) -> Option<Uri> {
        match self.open.get(&plain(path)) {
            Some(document) => Some(document.uri.clone()),
            None if path.is_absolute() => Uri::from_str(&diagnostic::uri(&plain(path).display().to_string())).ok(),
            None => None,
        }
    }
}

/// The path that an editor's name stands for; a buffer that is no file keeps its name.
pub fn path(uri: &Uri) -> PathBuf {
    let text = uri.as_str();
    let Some(rest) = text.strip_prefix("file://") else { return PathBuf::from(text) };
    let rest = &rest[rest.find('/').unwrap_or(0)..];
    let mut bytes = Vec::new();
    let mut left = rest.as_bytes();
    while let Some((first, more)) = left.split_first() {
        let code = more.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        match code.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                left = &more[2..];
            }
            None => {
                bytes.push(*first);
                left = more;
            }
        }
    }
    plain(Path::new(&String::from_utf8_lossy(&bytes).into_owned()))
}

/// The path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            std::path::Component::CurDir => {}
            std::path::Component::ParentDir => {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

/// A span as an editor counts it.
pub fn range(lines: &Lines, span: Span) -> Range {
    Range { start: position(lines, span.start), end: position(lines, span.end) }
}

/// A byte as an editor counts it.
pub fn position(lines: &Lines, byte: usize) -> Position {
    let (line, character) = lines.utf16(byte);
    Position { line, character }
}
