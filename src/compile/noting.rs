use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use lang::{Reader, library};

/// Reads files and remembers a digest of each, if fingerprints are wanted.
pub(super) struct Noting<'a> {
    read: &'a dyn Reader,
    wanted: bool,
    seen: RefCell<BTreeMap<PathBuf, [u8; 32]>>,
}

impl<'a> Noting<'a> {
    /// Reads through another reader.
    pub fn new(read: &'a dyn Reader, wanted: bool) -> Self {
        Self { read, wanted, seen: RefCell::default() }
    }

    /// Whether digests are wanted.
    pub fn wanted(&self) -> bool {
        self.wanted
    }

    fn note(&self, path: &Path, contents: &[u8]) {
        if self.wanted {
            self.seen.borrow_mut().insert(path.to_path_buf(), *blake3::hash(contents).as_bytes());
        }
    }

    /// The digest of a file that was read.
    pub fn seen(&self, path: &Path) -> Option<[u8; 32]> {
        self.seen.borrow().get(path).copied()
    }
}

impl Reader for Noting<'_> {
    fn text(&self, path: &Path) -> io::Result<String> {
        self.read.text(path).inspect(|text| self.note(path, text.as_bytes()))
    }

    fn bytes(&self, path: &Path) -> io::Result<Vec<u8>> {
        let held = library::network(path).map(|bytes| Ok(bytes.to_vec()));
        held.unwrap_or_else(|| self.read.bytes(path)).inspect(|bytes| self.note(path, bytes))
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.read.identity(path)
    }
}
