//! Open buffers, and files on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use lsp_types::{Position, Range, Uri};

use base::diagnostic::{Lines, Span};
use lang::{Reader, library, normal};

/// The buffers an editor has open; they have precedence over files on disk.
#[derive(Debug)]
pub struct Documents {
    open: BTreeMap<PathBuf, Document>,
    /// The folder to which the standard library is written when it is shown.
    shelf: PathBuf,
}

/// An open buffer.
#[derive(Debug)]
pub struct Document {
    /// The name the editor has for it.
    pub uri: Uri,
    pub text: String,
}

impl Reader for Documents {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        self.read(path)
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        base::files::bytes(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        base::files::identity(path)
    }
}

impl Documents {
    /// Starts with no buffer; the standard library is written to this folder when it is shown.
    pub fn new(shelf: PathBuf) -> Self {
        Self { open: BTreeMap::new(), shelf }
    }

    /// Sets a buffer's text.
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
    /// The errors of the file system.
    pub fn read(&self, path: &Path) -> std::io::Result<String> {
        match self.open.get(&normal(path)) {
            Some(document) => Ok(document.text.clone()),
            None => base::files::text(path),
        }
    }

    /// The editor's name for a file to show; the file may be in the library inside this program.
    pub fn uri_to_show(&self, path: &Path) -> Option<Uri> {
        if !library::holds(path) {
            return self.uri(path);
        }
        std::fs::create_dir_all(&self.shelf).ok()?;
        for name in library::names() {
            let (place, text) = (self.shelf.join(name), library::read(&library::place(&format!("std/{name}"))?).ok()?);
            // They import each other, so all are written; one that exists already may be open.
            if std::fs::read_to_string(&place).is_ok_and(|there| there == text) {
                continue;
            }
            std::fs::write(&place, text).ok()?;
        }
        self.uri(&self.shelf.join(path.file_name()?))
    }

    /// The editor's name for a path; `None` for a path that is not a file of the user's.
    pub fn uri(&self, path: &Path) -> Option<Uri> {
        match self.open.get(&normal(path)) {
            Some(document) => Some(document.uri.clone()),
            None if path.is_absolute() => {
                let address = base::files::address(&normal(path).display().to_string(), b"-._~/");
                Uri::from_str(&format!("file://{address}")).ok()
            }
            None => None,
        }
    }
}

/// The path of an editor's name; a buffer that is not a file keeps its name.
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
    normal(Path::new(&String::from_utf8_lossy(&bytes).into_owned()))
}

/// A span in the editor's line and column numbers.
pub fn range(lines: &Lines, span: Span) -> Range {
    Range { start: position(lines, span.start), end: position(lines, span.end) }
}

/// A byte in the editor's line and column numbers.
pub fn position(lines: &Lines, byte: usize) -> Position {
    let (line, character) = lines.utf16(byte);
    Position { line, character }
}
