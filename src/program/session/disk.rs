use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Result;
use std::path::{Path, PathBuf};

use base::files;
use lang::Reader;
use results::report::{FileRecord, MAX_HELD_BYTES};

/// Reads regular files of the disk, up to [`files::MAX_BYTES`] each.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Reader for Disk {
    fn text(&self, path: &Path) -> Result<String> {
        files::text(path)
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        files::bytes(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        files::identity(path)
    }
}

/// Reads through another reader, and records each file.
pub(super) struct Recording<'a> {
    reader: &'a dyn Reader,
    /// Whether the contents matter: records have digests, and those of a moderate size are kept.
    contents: bool,
    files: RefCell<ReadFiles>,
}

/// The files that were read.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadFiles {
    /// A record of each, in the order in which they were read.
    pub records: Vec<FileRecord>,
    /// The contents of those of at most [`MAX_HELD_BYTES`], by their paths.
    pub contents: BTreeMap<String, Vec<u8>>,
}

impl<'a> Recording<'a> {
    /// Reads through this reader.
    pub fn new(reader: &'a dyn Reader, contents: bool) -> Self {
        Self { reader, contents, files: RefCell::default() }
    }

    pub fn record(&self, path: &Path, contents: &[u8]) -> FileRecord {
        let path = path.display().to_string();
        if self.contents {
            FileRecord::new(path, contents)
        } else {
            FileRecord { path, blake3: String::new(), rows: None }
        }
    }

    /// The files that were read.
    pub fn into_files(self) -> ReadFiles {
        self.files.into_inner()
    }

    fn note(&self, path: &Path, contents: &[u8]) {
        let record = self.record(path, contents);
        let files = &mut *self.files.borrow_mut();
        if self.contents && contents.len() <= MAX_HELD_BYTES {
            files.contents.insert(record.path.clone(), contents.to_vec());
        }
        files.records.push(record);
    }
}

impl Reader for Recording<'_> {
    fn text(&self, path: &Path) -> Result<String> {
        self.reader.text(path).inspect(|text| self.note(path, text.as_bytes()))
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        self.reader.bytes(path).inspect(|bytes| self.note(path, bytes))
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.reader.identity(path)
    }
}
