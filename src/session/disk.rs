use std::cell::RefCell;
use std::io::Result;
use std::path::Path;

use crate::files;
use crate::lang::Reader;
use crate::report::FileRecord;

/// Reads regular files of the disk, up to [`files::MOST_BYTES`] each.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Reader for Disk {
    fn text(&self, path: &Path) -> Result<String> {
        files::text(path)
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        files::bytes(path)
    }
}

/// Reads through another reader and keeps a record of each file.
pub(super) struct Recording<'a> {
    reader: &'a dyn Reader,
    /// Whether records have digests.
    digests: bool,
    records: RefCell<Vec<FileRecord>>,
}

impl<'a> Recording<'a> {
    /// Reads through this reader.
    pub fn new(reader: &'a dyn Reader, digests: bool) -> Self {
        Self { reader, digests, records: RefCell::default() }
    }

    /// Makes a record of a file.
    pub fn record(&self, path: &Path, contents: &[u8]) -> FileRecord {
        let path = path.display().to_string();
        if self.digests { FileRecord::new(path, contents) } else { FileRecord { path, blake3: String::new() } }
    }

    /// The records of the files, in the order in which they were read.
    pub fn into_records(self) -> Vec<FileRecord> {
        self.records.into_inner()
    }

    fn note(&self, path: &Path, contents: &[u8]) {
        let record = self.record(path, contents);
        self.records.borrow_mut().push(record);
    }
}

impl Reader for Recording<'_> {
    fn text(&self, path: &Path) -> Result<String> {
        self.reader.text(path).inspect(|text| self.note(path, text.as_bytes()))
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        self.reader.bytes(path).inspect(|bytes| self.note(path, bytes))
    }
}
